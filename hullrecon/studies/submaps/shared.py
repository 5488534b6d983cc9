# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Submaps that share what lies between them (CIS) [PiniesTardos2008].

A map starts with a copy of the car's pose and of the landmarks in view, correlated as they are:
the separator. Given it, what comes is independent of what was before, so that nothing is lost and
no map grows. A landmark that is seen again is copied from map to map up to the newest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits
from hullrecon.studies.submaps.missions import Track, track_of
from hullrecon.studies.submaps.worlds import Log
from hullrecon.typing import Array, Ints

Key = tuple[str, int]  # a landmark or the car's pose at a border, with its number
NEAR_M = 12.0  # landmarks so near may be seen again: the laser's reach, and how unsure the car is
IN_VIEW_M = 8.0  # what is copied at a border


@dataclass
class Part:
    """A map in the mission's frame."""

    keys: list[Key]  # what the rows of the state hold, in their order
    mean: Array
    covariance: Array
    truth: dict[Key, int]  # only for judging

    def rows(self, keys: list[Key]) -> Ints:
        """Find the rows of the state that hold these landmarks and poses, in their order."""
        starts, row = {}, 0
        for key in self.keys:
            starts[key] = row
            row += _size(key)
        return np.concatenate([starts[key] + np.arange(_size(key)) for key in keys])


class SharedSeparators:
    """Maps in a row, each sharing its border with the next."""

    def __init__(self, limits: Limits, effort: Effort) -> None:
        """Start with an empty map. effort: counts the multiplications that it takes."""
        self._effort, self._limits = effort, limits
        self._done: list[Part] = []  # finished maps
        self._filter = EkfMap(effort)  # the newest map
        self._keys: list[Key] = []  # of the filter's landmarks
        self._border: list[Key] = []  # the pose at which the newest map starts. Empty in the first
        self._own = 0  # landmarks that the newest map added itself
        self._known = 0  # landmarks so far
        self.costs: list[tuple[int, float]] = []  # step and multiplications, at each border

    def run(self, log: Log) -> Track:
        """Filter a mission scan by scan, and start a new map whenever one is full."""
        noise, filters = log.noise.odometry, [self._filter]
        first = 0
        for step, scan in sorted(log.scans.items()):
            moved = slice(first, step + 1)
            self._filter.predict(log.car, log.odometry[moved], log.step_s[moved], noise)
            first = step + 1
            with self._effort.stage("global"):
                self._revisit()
            before = len(self._filter.landmarks)
            with self._effort.stage("local"):
                self._filter.observe(step, scan, log.noise.laser)
            for _ in range(len(self._filter.landmarks) - before):
                self._keys.append(("landmark", self._known))
                self._known += 1
                self._own += 1
            if self._own >= self._limits.landmarks:
                with self._effort.stage("global"):
                    self._close()
                self.costs.append((step, self._effort.multiplications["global"]))
                filters.append(self._filter)
        frames = [(np.zeros(3), np.zeros((3, 3)), built) for built in filters]
        return track_of(frames)

    def _part(self) -> Part:
        """Copy the newest map as it is now. Its pose is the border to the next map.

        Keys name what the rows of the state hold: the pose, then the border, then landmarks.
        """
        built = self._filter
        end = ("pose", len(self._done))
        truth = dict(zip(self._keys, built.truth, strict=True))
        keys = [end, *self._border, *self._keys]
        return Part(keys, built.mean.copy(), built.covariance.copy(), truth)

    def _close(self) -> None:
        """Finish a map, and start the next with a copy of the border."""
        part = self._part()
        pose = part.mean[:2]
        view = np.linalg.norm(self._filter.landmarks - pose, axis=1) < IN_VIEW_M
        shared = [key for key, seen in zip(self._keys, view, strict=True) if seen]
        end = part.keys[0]
        # the car stands at the border: its pose, a copy of it, the landmarks in view
        rows = np.concatenate([part.rows([end]), part.rows([end, *shared])])
        started = EkfMap(self._effort)
        started.mean = part.mean[rows]
        started.covariance = part.covariance[np.ix_(rows, rows)]
        started.fixed = 6
        started.truth = [part.truth[key] for key in shared]
        self._done.append(part)
        self._filter, self._keys, self._border, self._own = started, shared, [end], 0

    def _revisit(self) -> None:
        """Copy landmarks of older maps near the car through all maps to the newest."""
        if not self._done:
            return
        here, have = self._filter.mean[:2], set(self._keys)
        for number, part in enumerate(self._done):
            marks = [key for key in part.keys if key[0] == "landmark" and key not in have]
            if not marks:
                continue
            places = part.mean[part.rows(marks)].reshape(-1, 2)
            near = np.linalg.norm(places - here, axis=1) < NEAR_M
            for key in [key for key, is_near in zip(marks, near, strict=True) if is_near]:
                self._carry(key, number)
                have.add(key)

    def _carry(self, key: Key, start: int) -> None:
        """Copy a landmark from map `start` through the later ones to the newest map."""
        for number in range(start, len(self._done) - 1):
            if key not in self._done[number + 1].keys:
                copy_landmark(key, self._done[number], self._done[number + 1], self._effort)
        newest = self._part()
        copy_landmark(key, self._done[-1], newest, self._effort)
        built = self._filter
        built.mean, built.covariance = newest.mean, newest.covariance
        built.truth.append(newest.truth[key])
        self._keys.append(key)

    def landmarks(self) -> list[tuple[int, Array]]:
        """List each landmark's true number and place, after later knowledge was carried back."""
        with self._effort.stage("global"):
            parts = [*self._done, self._part()]
            for number in range(len(parts) - 2, -1, -1):
                carry_back(parts[number], parts[number + 1], self._effort)
        places: dict[Key, tuple[int, Array]] = {}
        for part in parts:
            for key, true in part.truth.items():
                places[key] = (true, part.mean[part.rows([key])])
        return list(places.values())


def _size(key: Key) -> int:
    """Count the coordinates of a pose (x, y, heading) or a landmark (x, y)."""
    return 3 if key[0] == "pose" else 2


def _common(first: Part, second: Part) -> list[Key]:
    """List the separator of two neighbours."""
    return [key for key in first.keys if key in second.keys]


def copy_landmark(key: Key, source: Part, target: Part, effort: Effort) -> None:
    """Add a landmark of one map to the next map, with its covariance there.

    Given the separator, it is independent of the rest of the next map. So its mean and covariance
    there follow from a regression on the separator, which the source map tells.
    """
    shared = _common(source, target)
    border, own = source.rows(shared), source.rows([key])
    gain = np.linalg.solve(
        source.covariance[np.ix_(border, border)], source.covariance[np.ix_(border, own)]
    ).T
    # what the separator leaves open
    rest = source.covariance[np.ix_(own, own)] - gain @ source.covariance[np.ix_(border, own)]
    there = target.rows(shared)
    across = gain @ target.covariance[there]
    place = source.mean[own] + gain @ (target.mean[there] - source.mean[border])
    corner = rest + gain @ target.covariance[np.ix_(there, there)] @ gain.T
    target.mean = np.concatenate([target.mean, place])
    target.covariance = np.block([[target.covariance, across.T], [across, corner]])
    target.keys = [*target.keys, key]
    target.truth = {**target.truth, key: source.truth[key]}
    effort.count(len(border), len(border), len(border))
    effort.count(2, len(border), len(target.mean))


def carry_back(part: Part, later: Part, effort: Effort) -> None:
    """Update a map by what the next one learnt of their separator, as a smoother does."""
    shared = _common(part, later)
    border, there = part.rows(shared), later.rows(shared)
    gain = np.linalg.solve(part.covariance[np.ix_(border, border)], part.covariance[border]).T
    change = later.covariance[np.ix_(there, there)] - part.covariance[np.ix_(border, border)]
    part.mean = part.mean + gain @ (later.mean[there] - part.mean[border])
    part.covariance = part.covariance + gain @ change @ gain.T
    effort.count(len(part.mean), len(border), len(border) + len(part.mean))
