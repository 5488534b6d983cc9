# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tie position fixes (USBL, GNSS) to the nodes of the path, or say why they determine nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri  # not scipy.stats, which takes a quarter of a second to load

from hullrecon.estimation.position_tables import place_path
from hullrecon.geometry.poses import Poses, interpolate
from hullrecon.records.clock import nearest
from hullrecon.records.sensors import PositionFixes
from hullrecon.records.trajectory import PositionTies, Trajectory
from hullrecon.typing import Array

FARTHEST_S = 5.0  # from a node: the path between two nodes is taken as straight
ONE_PLACE = 0.99  # quantile of the chi-square of fixes that all measure one point
# The two coordinates were exchanged in the log where fixes lie farther from the path than their
# sigmas (FAR_SIGMAS) and dead reckoning (DRIFT, of the path's length) explain, and where exchanging
# them reduces that distance to a share of EXPLAINED
EXPLAINED, FAR_SIGMAS, DRIFT = 0.4, 3.0, 0.02


@dataclass(frozen=True, kw_only=True)
class AttachedPositions:
    """Position fixes tied to the nodes of a path."""

    ties: PositionTies | None  # None with too few fixes, or with all at one point
    outside: int  # fixes before or after the path, or far from any node
    refusal: str | None  # why the fixes determine nothing, None where they are used
    # Distances from the path, m, as logged and with both coordinates exchanged, where the fixes
    # were corrected by exchanging these
    put_right_m: tuple[float, float] | None = None

    def sentences(self) -> list[str]:
        """Describe, for the report, which fixes cannot be used or were corrected, and why."""
        out = []
        if self.outside:
            lie = (
                "1 position from outside lies"
                if self.outside == 1
                else f"{self.outside} positions from outside lie"
            )
            out.append(
                f"{lie} before or after the path, or more than {FARTHEST_S:g} s from a "
                "pose, and cannot be used."
            )
        if self.put_right_m is not None:
            before_m, after_m = self.put_right_m
            out.append(
                "The two coordinates of the positions from outside are exchanged: as logged they "
                f"lie {before_m:.2g} m from the path, exchanged {after_m:.2g} m. They were put "
                "right."
            )
        if self.refusal is not None:
            out.append(f"Positions from outside tell nothing of this dive: {self.refusal}.")
        return out

    def facts(self) -> dict[str, object]:
        """Summarise the positions in numbers for navigation.json."""
        used = 0 if self.ties is None else len(self.ties)
        return {"used": used, "outside": self.outside, "refusal": self.refusal}


def attach_positions(
    fixes: PositionFixes, trajectory: Trajectory, origin: Array
) -> AttachedPositions:
    """Tie each fix to the node nearest in time, if that is within FARTHEST_S.

    Fixes that show nothing are refused. North and east are exchanged where they fit the path only
    so.

    origin (3,): m, antenna or transponder in the vehicle frame.
    """
    t = trajectory.t_ns
    node = nearest(t, fixes.t_ns)
    near = np.abs(t[node] - fixes.t_ns) <= FARTHEST_S * 1e9
    near &= (fixes.t_ns >= t[0]) & (fixes.t_ns <= t[-1])
    poses = trajectory.poses()
    node_from_fix = poses[node[near]].inverse() @ interpolate(t, poses, fixes.t_ns[near])
    ties = PositionTies(
        t_ns=fixes.t_ns[near],
        node=node[near],
        antenna=node_from_fix.rotation.apply(origin) + node_from_fix.translation,
        north_east=fixes.north_east[near],
        sigma=fixes.sigma[near],
    )
    exchanged = replace(ties, north_east=fixes.exchanged[near])
    put_right_m = None
    refusal = _why_useless(ties)
    if refusal is None:
        put_right_m = _distances_if_exchanged(ties, exchanged, poses)
        ties = ties if put_right_m is None else exchanged
    return AttachedPositions(
        ties=ties if refusal is None else None,
        outside=int((~near).sum()),
        refusal=refusal,
        put_right_m=put_right_m,
    )


def _distances_if_exchanged(
    ties: PositionTies, exchanged: PositionTies, path: Poses
) -> tuple[float, float] | None:
    """Measure how far fixes lie from the path, as logged and with their coordinates exchanged.

    None unless they fit the path only once the coordinates are exchanged. A straight path fits
    either way, so its fixes are left as logged.

    ties, exchanged: the fixes as logged, and with their coordinates exchanged.

    Returns
    -------
    tuple
        Median distances, m, as logged and exchanged.
    """
    as_logged_m, exchanged_m = (_median_distance(one, path) for one in (ties, exchanged))
    at = path[ties.node].apply(ties.antenna)[:, :2]
    way_m = float(np.linalg.norm(np.diff(at, axis=0), axis=1).sum())
    least_m = FAR_SIGMAS * float(np.median(ties.sigma)) + DRIFT * way_m
    if as_logged_m < least_m or exchanged_m > EXPLAINED * as_logged_m:
        return None
    return as_logged_m, exchanged_m


def _median_distance(ties: PositionTies, path: Poses) -> float:
    """Compute the median distance, m, of fixes from the path once it is fitted to them."""
    north, east, heading = place_path(ties, path)
    at = path[ties.node].apply(ties.antenna)[:, :2]
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    # the path, fitted to the fixes by a shift and a turn of its heading
    away = ties.north_east - at @ turn.T - [north, east]
    return float(np.median(np.linalg.norm(away, axis=1)))


def _why_useless(ties: PositionTies) -> str | None:
    """Explain why fixes determine nothing of a path whose heading and start are free, else None.

    A single fix fits any such path. Fixes that all measure one point show no heading: that is
    tested by the chi-square of their scatter about the weighted mean.
    """
    if len(ties) < 2:
        return (
            "there is none along the path"
            if len(ties) == 0
            else "there is one alone, and where the dive began is free"
        )
    weight = 1 / ties.sigma**2
    middle = (weight[:, None] * ties.north_east).sum(axis=0) / weight.sum()
    chi2 = float((weight[:, None] * (ties.north_east - middle) ** 2).sum())
    if chi2 > chdtri(2 * len(ties) - 2, 1 - ONE_PLACE):
        return None
    return (
        f"all {len(ties)} are of one place within their sigma of "
        f"{np.median(ties.sigma):.2g} m, so no heading shows in them"
    )
