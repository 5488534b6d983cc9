# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which submaps may overlap, and which of their landmarks are the same [Aulinas2011 3.3.4]."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon.studies.association.methods import joint_compatibility, randomised_compatibility
from hullrecon.studies.association.point_sets import Association, PointSets
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.global_map import GlobalMap
from hullrecon.typing import Array, Ints

CONFIDENCE = 0.99
SEARCHED_WHOLE = 25  # points in the overlap up to which joint compatibility is searched through
MOST_TESTS = 3000

OWN_M = 1.5  # how far off two estimates of a landmark in their own maps may be, generously


@dataclass(frozen=True, kw_only=True)
class Area:
    """Where a map lies."""

    frames: tuple[int, ...]  # that it was built from
    points: Array  # (n, 2) m, its landmarks in the mission's frame


@dataclass(frozen=True, kw_only=True)
class Proximity:
    """How far the newest map may be off, seen from every other [Aulinas2011 3.3.4].

    The thesis says `by proximity at the global level`. Here: landmarks may be the same that are
    nearer than three standard deviations of the transforms between the newest frame and the frame
    of the other map that lies nearest to it.
    """

    frames: Array  # (k, 3) poses in the mission's frame, the newest map's the last
    spreads: Array  # (k - 1, 3, 3) covariance of the newest frame, seen from every other

    def overlap(self, other: Area, newest: Area) -> tuple[Ints, Ints]:
        """List the landmarks of each map that may be the same as one of the other map."""
        off = np.linalg.norm(other.points[:, None] - newest.points[None], axis=2)
        near = off < self._reach_m(other, newest)
        return np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))

    def distance_m(self, other: Area) -> float:
        """Measure how far the newest frame is from the nearest frame of a map."""
        return float(self._distances(other).min())

    def _distances(self, other: Area) -> Array:
        """Measure the distances (k,) m of a map's frames from the newest frame."""
        off = self.frames[list(other.frames), :2] - self.frames[-1, :2]
        return np.asarray(np.linalg.norm(off, axis=1))

    def _reach_m(self, other: Area, newest: Area) -> Array:
        """Bound how far off each landmark (n,) of the newest map may be, seen from another map.

        Errors of the newest frame's position and, by the landmark's lever arm, of its heading.
        """
        spread = self.spreads[other.frames[int(np.argmin(self._distances(other)))]]
        lever = newest.points - self.frames[-1, :2]
        variance = np.trace(spread[:2, :2]) + (lever**2).sum(axis=1) * spread[2, 2]
        variance += 2 * (lever[:, 0] * spread[1, 2] - lever[:, 1] * spread[0, 2])
        return np.asarray(OWN_M + 3 * np.sqrt(variance))


def proximity(world: GlobalMap, effort: Effort) -> Proximity:
    """Find how sure the newest map's frame is, seen from every other frame.

    effort: counts the multiplications that it takes.
    """
    newest = len(world) - 1
    effort.count(27, newest, newest)  # a product of 3 x 3 matrices for each two links
    return Proximity(
        frames=world.frames()[: newest + 1], spreads=world.spreads_seen_from_each(newest)
    )


def pair_maps(sets: PointSets, rng: np.random.Generator) -> Association:
    """Pair landmarks of two maps by joint compatibility.

    It is searched through where the overlap is small, and by random draws where it is large.
    """
    compatible = sets.compatible(CONFIDENCE)
    firsts, seconds = (np.flatnonzero(compatible.any(axis=axis)) for axis in (1, 0))
    overlap = sets.part(firsts, seconds)
    if len(seconds) <= SEARCHED_WHOLE:
        found = joint_compatibility(overlap, CONFIDENCE, most_tests=MOST_TESTS)
    else:
        found = randomised_compatibility(overlap, rng, CONFIDENCE, good_share=0.5)
    pairs = tuple((int(firsts[i]), int(seconds[j])) for i, j in found.pairs)
    return replace(found, pairs=pairs)
