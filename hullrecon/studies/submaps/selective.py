# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Selective submap joining: maps are fused that share enough landmarks [Aulinas2011 Alg. 3]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.association.point_sets import Association, PointSets
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap
from hullrecon.studies.submaps.global_map import GlobalMap, Submap, append_submap
from hullrecon.studies.submaps.join import fuse, join
from hullrecon.studies.submaps.loops import CONFIDENCE, pair_maps, possible_loops
from hullrecon.studies.submaps.models import place
from hullrecon.typing import Array

SEED = 5  # of random draws
LEAST_SHARED = 2  # landmarks that fix a relative pose


@dataclass(frozen=True, kw_only=True)
class Fusion:
    """Two maps that were fused."""

    shared: int
    wrong: int  # pairs that are false by the truth
    old_points: Array  # (n, 2) m, before, in the old map's frame
    new_points: Array  # (m, 2) m, before, in the old map's frame
    fused_points: Array  # (k, 2) m, after
    moved_m: float  # mean of the new map's common landmarks


class SelectiveJoining:
    """Submaps kept apart, but for those that share more than a share of a submap's size."""

    def __init__(self, threshold: float, submap_size: int, effort: Effort) -> None:
        self.world = GlobalMap()
        self.submaps: list[Submap] = []
        self.fusions: list[Fusion] = []
        self.tried = 0  # loop hypotheses
        self._least = max(LEAST_SHARED, threshold * submap_size)
        self._effort = effort
        self._rng = np.random.default_rng(SEED)

    def add(self, built: EkfMap) -> None:
        """Add a finished submap, and close loops that it shows."""
        with self._effort.stage("global"):
            newest = append_submap(self.world, built)
            self.submaps.append(newest)
            points = newest.now(self.world).reshape(-1, 2)
            # the predecessor's map is left out: what they share is the border, not a loop
            others = [m for m in self.submaps[:-1] if newest.base - 1 not in m.frames]
            places = [(m.base, m.now(self.world).reshape(-1, 2)) for m in others]
            for number in possible_loops(self.world, places, (newest.base, points)):
                newest = self._try(others[number], newest)

    def _try(self, candidate: Submap, newest: Submap) -> Submap:
        self.tried += 1
        joined = join(self.world, candidate, newest, self._effort)
        sets = joined.point_sets()
        if np.sum(sets.compatible(CONFIDENCE).any(axis=0)) <= self._least:
            return newest
        with self._effort.stage("association"):
            found = pair_maps(sets, self._rng)
        if len(found.pairs) < self._least:
            return newest
        fused = fuse(self.world, joined, found.pairs, self._effort)
        self.fusions.append(_describe(sets, candidate, newest, found, fused.now(self.world)))
        self.submaps = [m for m in self.submaps if m is not candidate and m is not newest]
        self.submaps.append(fused)
        return fused

    def last_frame(self) -> tuple[Array, Array]:
        """Compute where the last submap ended, with covariance, in the mission's frame."""
        return self.world.last_frame()

    def landmarks(self) -> list[tuple[int, Array]]:
        """List each landmark of each submap with its place in the mission's frame."""
        frames = self.world.frames()
        places = []
        for submap in self.submaps:
            points = place(frames[submap.base], submap.now(self.world).reshape(-1, 2))
            places += list(zip(submap.truth, points, strict=True))
        return places


def _describe(
    sets: PointSets, old: Submap, new: Submap, found: Association, fused: Array
) -> Fusion:
    firsts, seconds = (list(side) for side in zip(*found.pairs, strict=True))
    after = fused.reshape(-1, 2)
    return Fusion(
        shared=len(found.pairs),
        wrong=sum(old.truth[i] != new.truth[j] for i, j in found.pairs),
        old_points=sets.first,
        new_points=sets.second,
        fused_points=after,
        moved_m=float(np.linalg.norm(after[firsts] - sets.second[seconds], axis=1).mean()),
    )
