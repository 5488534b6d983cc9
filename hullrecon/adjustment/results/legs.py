# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Legs of a dive: which legs share landmarks, and which ones images tie to no other leg."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from scipy.sparse import coo_array

from hullrecon.typing import Array, Ints

# Least length of a leg: in m, and as a share of the survey's length
LEAST_SWING_M, LEAST_SWING = 1.5, 0.15
MIN_LANDMARKS = 12  # least number of landmarks that two tied legs share
MOST_LISTED = 5  # legs that a sentence names


@dataclass(frozen=True, kw_only=True)
class LegTies:
    """Legs of a dive, and the landmarks they share."""

    leg: Ints  # (n,) leg of each node; legs are numbered in the order of time
    shared: Ints  # (l, l) number of landmarks that two legs share; on the diagonal, of each leg

    @property
    def untied(self) -> Ints:
        """Legs that have landmarks, but share fewer than MIN_LANDMARKS with any other leg."""
        others = self.shared - np.diag(np.diag(self.shared))
        return np.flatnonzero(
            (np.diag(self.shared) > 0) & (others.max(axis=1, initial=0) < MIN_LANDMARKS)
        )

    def table(self, t_ns: Ints) -> list[dict[str, object]]:
        """Tabulate the legs, numbered from 1, for adjust.json.

        Each row has the leg's span in time, its nodes and landmarks, and the number of landmarks
        that it shares with each later leg. t_ns (n,): stamps of the nodes.
        """
        rows: list[dict[str, object]] = []
        for k in range(len(self.shared)):
            at = t_ns[self.leg == k]
            later = {
                str(j + 1): int(self.shared[k, j])
                for j in range(k + 1, len(self.shared))
                if self.shared[k, j]
            }
            rows.append(
                {
                    "leg": k + 1,
                    "from_ns": int(at.min()),
                    "to_ns": int(at.max()),
                    "nodes": len(at),
                    "landmarks": int(self.shared[k, k]),
                    "shared_with": later,
                }
            )
        return rows

    def describe_untied(self, t_ns: Ints) -> str | None:
        """Describe the legs that images tie to no other leg. None without any, or with one leg.

        t_ns (n,): stamps of the nodes.
        """
        legs = self.untied
        if len(self.shared) < 2 or not len(legs):
            return None
        spans = [f"{k + 1} (from {_hour(t_ns[self.leg == k].min())})" for k in legs[:MOST_LISTED]]
        more = f" and {len(legs) - MOST_LISTED} more" if len(legs) > MOST_LISTED else ""
        word, lies = ("Leg", "it lies") if len(legs) == 1 else ("Legs", "they lie")
        return (
            f"{word} {', '.join(spans)}{more} of {len(self.shared)}: fewer than {MIN_LANDMARKS} "
            "landmarks are shared with any other leg; navigation and the CAD model, where there "
            f"is one, tell where {lies}."
        )


def tie_legs(positions: Array, observations: Iterable[tuple[Ints, Ints]]) -> LegTies:
    """Count the landmarks that legs share, so that a leg that images do not place is reported.

    Parameters
    ----------
    positions
        Positions (n, 3) m of the vehicle at the nodes, which are split into legs.
    observations
        Blocks of whole landmarks: node and landmark of each observation, both (m,).
    """
    leg = split_legs(positions)
    count = int(leg.max(initial=-1)) + 1
    shared = np.zeros((count, count), np.int64)
    for node, landmark in observations:
        _, number = np.unique(landmark, return_inverse=True)
        shape = (count, int(number.max(initial=-1)) + 1)
        seen = coo_array((np.ones(len(node), np.int64), (leg[node], number)), shape=shape).tocsr()
        seen.data[:] = 1  # a leg sees a landmark or not, however often
        shared += (seen @ seen.T).toarray()
    return LegTies(leg=leg, shared=shared)


def split_legs(positions: Array) -> Ints:
    """Split a path, positions (n, 3) m, into legs (n,) numbered from 0 on.

    A leg ends at an extremum of the position along the survey's longest axis from which the vehicle
    then goes back by at least a leg's least length.
    """
    if len(positions) < 2:
        return np.zeros(len(positions), np.int64)
    centred = positions - positions.mean(axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][0]
    along = centred @ axis
    swing = max(LEAST_SWING_M, LEAST_SWING * float(np.ptp(along)))
    turns: list[int] = []
    # Rows of the lowest and the highest position since the last turn. rising: 1 on a leg on which
    # the position grows, -1 where it falls, 0 before the first leg has its least length.
    low = high = rising = 0
    for k in range(1, len(along)):
        low, high = (k if along[k] < along[low] else low), (k if along[k] > along[high] else high)
        if rising >= 0 and along[high] - along[k] > swing:
            if rising:  # where the first leg begins is no turn
                turns.append(high)
            rising, low = -1, k
        elif rising <= 0 and along[k] - along[low] > swing:
            if rising:
                turns.append(low)
            rising, high = 1, k
        # On a leg only the extremum ahead counts, as the other is the turn behind
        if rising > 0:
            low = k
        elif rising < 0:
            high = k
    return np.searchsorted(np.array(turns, np.int64), np.arange(len(along)), side="left")


def _hour(t_ns: int) -> str:
    return datetime.fromtimestamp(int(t_ns) / 1e9, UTC).strftime("%H:%M:%S")
