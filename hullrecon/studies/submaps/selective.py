# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Selective submap joining: maps are fused that share enough landmarks [Aulinas2011 Alg. 3]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap
from hullrecon.studies.submaps.global_map import GlobalMap, Submap, append_submap
from hullrecon.studies.submaps.join import fuse, landmarks_in_one_frame
from hullrecon.studies.submaps.loops import CONFIDENCE, Area, pair_maps, proximity
from hullrecon.studies.submaps.models import place
from hullrecon.typing import Array, Ints

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
    """Joins submaps in sequence, and fuses those that see enough of the same landmarks.

    Enough is `threshold` times the number of landmarks of a submap.
    """

    def __init__(self, threshold: float, submap_size: int, effort: Effort) -> None:
        """Start without submaps.

        Parameters
        ----------
        threshold
            Share of a submap's landmarks that must be common for a fusion.
        submap_size
            Landmarks of a full submap.
        effort
            Counts the multiplications that it takes.
        """
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
            # the predecessor's map is left out: what they share is the border, not a loop
            others = [m for m in self.submaps if newest.base - 1 not in m.frames]
            self.submaps.append(newest)
            near = proximity(self.world, self._effort)
            areas = {m.base: self._area(m) for m in others}
            others.sort(key=lambda m: near.distance_m(areas[m.base]))
            for candidate in others:
                marks = near.overlap(areas[candidate.base], self._area(newest))
                if len(marks[1]) < self._least:
                    continue
                fused = self._try(candidate, newest, marks)
                if fused is not None:
                    newest, near = fused, proximity(self.world, self._effort)

    def _area(self, submap: Submap) -> Area:
        """Place a submap's landmarks in the mission's frame."""
        points = submap.now(self.world).reshape(-1, 2)
        self._effort.count(*submap.gain.shape)
        return Area(frames=submap.frames, points=place(self.world.frames()[submap.base], points))

    def _try(self, candidate: Submap, newest: Submap, marks: tuple[Ints, Ints]) -> Submap | None:
        """Fuse two maps if enough of their landmarks are common. None if they are not.

        marks: numbers of the landmarks that may be common, of the candidate and of the newest.
        """
        self.tried += 1
        sets = landmarks_in_one_frame(self.world, candidate, newest, marks, self._effort)
        if np.sum(sets.compatible(CONFIDENCE).any(axis=0)) < self._least:
            return None
        with self._effort.stage("association"):
            found = pair_maps(sets, self._rng)
        if len(found.pairs) < self._least:
            return None
        pairs = tuple((int(marks[0][i]), int(marks[1][j])) for i, j in found.pairs)
        transform, _ = self.world.relative(candidate.base, newest.base)
        before = place(transform, newest.now(self.world).reshape(-1, 2))
        old = candidate.now(self.world).reshape(-1, 2)
        fused = fuse(self.world, candidate, newest, pairs, self._effort)
        firsts, seconds = (list(side) for side in zip(*pairs, strict=True))
        after = fused.now(self.world).reshape(-1, 2)
        self.fusions.append(
            Fusion(
                shared=len(pairs),
                wrong=sum(candidate.truth[i] != newest.truth[j] for i, j in pairs),
                old_points=old,
                new_points=before,
                fused_points=after,
                moved_m=float(np.linalg.norm(after[firsts] - before[seconds], axis=1).mean()),
            )
        )
        self.submaps = [m for m in self.submaps if m is not candidate and m is not newest]
        self.submaps.append(fused)
        return fused

    def last_frame(self) -> tuple[Array, Array]:
        """Compute where the last submap ended, with covariance, in the mission's frame."""
        return self.world.last_frame()

    def landmarks(self) -> list[tuple[int, Array]]:
        """List all landmarks: number of the true one, and place (2,) m in the mission."""
        frames = self.world.frames()
        places = []
        for submap in self.submaps:
            points = place(frames[submap.base], submap.now(self.world).reshape(-1, 2))
            places += list(zip(submap.truth, points, strict=True))
        return places
