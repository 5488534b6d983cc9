# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Legs of a dive: which share landmarks, and which are tied to no other by images."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from scipy.sparse import coo_array

from hullrecon.typing import Array, Ints

# Length of a leg at least: in m, and as a share of the survey's
LEAST_SWING_M, LEAST_SWING = 1.5, 0.15
MIN_LANDMARKS = 12  # that two legs share, from which they are tied
MOST_LISTED = 5


@dataclass(frozen=True, kw_only=True)
class LegTies:
    """Legs of a dive, and the landmarks they share."""

    leg: Ints  # (n,) of each node, in order of time
    shared: Ints  # (l, l) landmarks of two legs, on the diagonal those of each

    @property
    def untied(self) -> Ints:
        """Legs that see landmarks, but share too few with any other."""
        others = self.shared - np.diag(np.diag(self.shared))
        return np.flatnonzero(
            (np.diag(self.shared) > 0) & (others.max(axis=1, initial=0) < MIN_LANDMARKS)
        )

    def table(self, t_ns: Ints) -> list[dict[str, object]]:
        """Tabulate the legs, counted from 1: span, and landmarks shared with later legs."""
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
        """Name the legs that images tie to no other leg.

        None without such legs, or with one leg.
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
    """Count the landmarks that legs share.

    Parameters
    ----------
    positions
        Of the vehicle (n, 3) m.
    observations
        In blocks of whole landmarks: node and landmark of each (m,).
    """
    leg = split_legs(positions)
    count = int(leg.max(initial=-1)) + 1
    shared = np.zeros((count, count), np.int64)
    for node, landmark in observations:
        _, number = np.unique(landmark, return_inverse=True)
        shape = (count, int(number.max(initial=-1)) + 1)
        seen = coo_array((np.ones(len(node), np.int64), (leg[node], number)), shape=shape).tocsr()
        seen.data[:] = 1
        shared += (seen @ seen.T).toarray()
    return LegTies(leg=leg, shared=shared)


def split_legs(positions: Array) -> Ints:
    """Split positions (n, 3) into legs (n,).

    A leg ends where the vehicle turns back along the survey's long axis.
    """
    if len(positions) < 2:
        return np.zeros(len(positions), np.int64)
    centred = positions - positions.mean(axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][0]
    along = centred @ axis
    swing = max(LEAST_SWING_M, LEAST_SWING * float(np.ptp(along)))
    turns: list[int] = []
    # rows of the lowest and highest since the last turn; rising: 1, -1, or 0 before the first swing
    low = high = rising = 0
    for k in range(1, len(along)):
        low, high = (k if along[k] < along[low] else low), (k if along[k] > along[high] else high)
        if rising >= 0 and along[high] - along[k] > swing:
            turns += [high] * abs(rising)
            rising, low = -1, k
        elif rising <= 0 and along[k] - along[low] > swing:
            turns += [low] * abs(rising)
            rising, high = 1, k
        if rising > 0:
            low = k
        elif rising < 0:
            high = k
    return np.searchsorted(np.array(turns, np.int64), np.arange(len(along)), side="left")


def _hour(t_ns: int) -> str:
    return datetime.fromtimestamp(int(t_ns) / 1e9, UTC).strftime("%H:%M:%S")
