# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Add position fixes (USBL, GNSS) to a native problem, and compare them with a solved path."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import PositionTies
from hullrecon.typing import Array

ROUNDS = 50  # of the first alignment, each weighted by the residuals of the one before
OUTLIER_SIGMAS = 5.0  # in units of the robust rms of all, if that is above one
DISAGREE_SIGMAS = 3.0  # robust rms, beyond which position fixes and navigation disagree
MEDIAN_OF_NORM = float(np.sqrt(2 * np.log(2)))  # median length of two unit normal numbers


def with_positions(problem: native.Problem, ties: PositionTies | None) -> native.Problem:
    """Add position fixes to a problem, with a start value of g's position and heading."""
    if ties is None:
        return problem
    pose = problem.unknowns.pose
    return replace(
        problem,
        unknowns=replace(
            problem.unknowns, world=place_path(ties, Poses(pose[:, 3:7], pose[:, :3]))
        ),
        positions=native.PositionTable(
            node=ties.node.astype(np.int32),
            antenna=ties.antenna,
            measured=ties.north_east,
            sigma=ties.sigma,
        ),
    )


def place_path(ties: PositionTies, path: Poses) -> Array:
    """Fit a path to position fixes: north and east of g's origin, m, heading of its x axis, rad.

    The sum of distances in sigmas is minimised by reweighted least squares. Outliers hardly change
    it.
    """
    at = path[ties.node].apply(ties.antenna)[:, :2]
    weight = 1 / ties.sigma**2
    world = np.zeros(3)
    for _ in range(ROUNDS):
        # the turn between both weighted means that brings the path nearest to the fixes
        here, there = (np.average(x, axis=0, weights=weight) for x in (at, ties.north_east))
        cross = (weight[:, None] * (at - here)).T @ (ties.north_east - there)
        heading = np.arctan2(cross[0, 1] - cross[1, 0], cross[0, 0] + cross[1, 1])
        turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
        world = np.r_[there - turn @ here, heading]
        away = np.linalg.norm(ties.north_east - at @ turn.T - world[:2], axis=1) / ties.sigma
        # no fix near the path may outweigh all others
        weight = 1 / (ties.sigma**2 * np.maximum(away, 0.1))
    return world


@dataclass(frozen=True, kw_only=True)
class PositionFit:
    """How well position fixes agree with a solved path."""

    count: int  # number of fixes
    span_s: float  # from the first to the last
    sigma_m: float  # median sigma
    rms: float  # of residuals in sigmas, estimated from their median so that outliers do not count
    outliers: int  # number of fixes beyond OUTLIER_SIGMAS
    heading: float  # rad, of g's x axis from north
    heading_sigma: float  # rad

    def facts(self) -> dict[str, object]:
        """Collect the figures for adjust.json."""
        return {
            "count": self.count,
            "span_s": self.span_s,
            "sigma_m": self.sigma_m,
            "rms_sigmas": self.rms,
            "outliers": self.outliers,
            "heading_deg": float(np.degrees(self.heading)),
            "heading_sigma_deg": float(np.degrees(self.heading_sigma)),
        }

    def disagreement(self) -> str | None:
        """Write a warning that position fixes and navigation disagree. None where they agree."""
        if self.rms <= DISAGREE_SIGMAS:
            return None
        return (
            f"The positions from outside disagree with navigation: {self.rms:.1f} of their sigmas "
            f"of {self.sigma_m:.2g} m (rms) are left between them. Check position.origin, "
            "position.frame, position.time_offset, position.sigma_m and "
            "imu.heading_drift_deg_per_hour."
        )


def fit_of_positions(
    problem: native.Problem,
    ties: PositionTies | None,
    world_covariance: Array,
    options: native.Options,
) -> PositionFit | None:
    """Compare position fixes with the path of a problem at its solution. None without fixes.

    world_covariance (3, 3): of Unknowns.world at the solution.
    """
    if ties is None:
        return None
    unknowns = problem.unknowns
    alone = native.Problem(
        unknowns=native.Unknowns(pose=unknowns.pose, world=unknowns.world),
        positions=problem.positions,
    )
    found = native.evaluate(alone, options, jacobian=False)
    rows = found.residual[found.factor == native.FACTORS.index("position")].reshape(-1, 2)
    away = np.linalg.norm(rows, axis=1)
    rms = float(np.median(away)) / MEDIAN_OF_NORM
    return PositionFit(
        count=len(ties),
        span_s=float(ties.t_ns.max() - ties.t_ns.min()) * 1e-9,
        sigma_m=float(np.median(ties.sigma)),
        rms=rms,
        outliers=int((away > OUTLIER_SIGMAS * max(rms, 1.0)).sum()),
        heading=float(problem.unknowns.world[2]),
        heading_sigma=float(np.sqrt(world_covariance[2, 2])),
    )
