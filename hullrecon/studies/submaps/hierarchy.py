# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A graph of independent submaps with relative poses, as hierarchical SLAM (HS) of [Estrada2005].

Submaps are never fused: two that share landmarks give a relative pose, and all relative poses
are adjusted at once whenever a loop appears.
"""

from __future__ import annotations

import numpy as np

from hullrecon.studies.association.point_sets import PointSets
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap
from hullrecon.studies.submaps.global_map import GlobalMap
from hullrecon.studies.submaps.join import refer_to_base
from hullrecon.studies.submaps.loops import Area, pair_maps, proximity
from hullrecon.studies.submaps.models import place, place_by_points, place_by_pose, wrap
from hullrecon.studies.submaps.sequence import PlainMap, plain_map
from hullrecon.typing import Array

LEAST_SHARED = 4  # landmarks of a loop; two fix a pose, more reveal a wrong pair
ITERATIONS = 3  # of an adjustment, from the last solution
SEED = 5  # of random draws

Loop = tuple[int, int, Array, Array]  # frames, pose of the second in the first, covariance


class Hierarchy:
    """Submaps, the transforms between them, and loops."""

    def __init__(self, effort: Effort) -> None:
        """Start without submaps. effort: counts the multiplications that it takes."""
        self.world = GlobalMap()
        self.loops: list[Loop] = []
        self._maps: list[PlainMap] = []
        # By submap, the pose (3,) of its end in its frame, as measured, with covariance (3, 3)
        self._links: list[tuple[Array, Array]] = []
        self._effort = effort
        self._rng = np.random.default_rng(SEED)

    def add(self, built: EkfMap) -> None:
        """Add a submap, look for loops, and adjust the graph where there are any."""
        with self._effort.stage("global"):
            newest, base = plain_map(built), len(self._maps)
            self._maps.append(newest)
            self._links.append((newest.mean[:3], newest.covariance[:3, :3]))
            self.world.append(newest.mean[:3].copy(), newest.covariance[:3, :3])
            near, frames = proximity(self.world, self._effort), self.world.frames()
            *areas, own = (
                Area(frames=(number,), points=place(frames[number], m.points))
                for number, m in enumerate(self._maps)
            )
            found = []
            for number, area in enumerate(areas[:-1]):
                if len(near.overlap(area, own)[1]) >= LEAST_SHARED:
                    found += self._close(number, base)
            if found:
                self.loops += found
                self._adjust()

    def _close(self, first: int, second: int) -> list[Loop]:
        """Close a loop between two submaps by the landmarks that they share. Empty for too few."""
        old, new = self._maps[first], self._maps[second]
        pose, jacobian = self.world.relative(first, second)
        points, covariance = refer_to_base(
            new.points, new.covariance[3:, 3:], pose, jacobian @ self.world.covariance @ jacobian.T
        )
        sets = PointSets(
            first=old.points,
            second=points,
            first_covariance=old.covariance[3:, 3:],
            second_covariance=covariance,
        )
        self._effort.count(3, len(self.world.mean), len(self.world.mean))
        self._effort.count(len(covariance), len(covariance), 3)
        with self._effort.stage("association"):
            pairs = pair_maps(sets, self._rng).pairs
        if len(pairs) < LEAST_SHARED:
            return []
        return [(first, second, *register(old, new, pairs, pose))]

    def _adjust(self) -> None:
        """Adjust all transforms to the submaps' ends and to the loops, by Gauss-Newton.

        `world.mean` holds three unknowns for each submap: x, y and heading of its end in its frame.
        """
        size = len(self.world.mean)
        for _ in range(ITERATIONS):
            matrix, vector = np.zeros((size, size)), np.zeros(size)
            for number, (link, covariance) in enumerate(self._links):
                rows = slice(3 * number, 3 * number + 3)
                weight = np.linalg.inv(covariance)
                matrix[rows, rows] += weight
                vector[rows] += weight @ _off(link, self.world.mean[rows])
            for first, second, pose, covariance in self.loops:
                now, jacobian = self.world.relative(first, second)
                links = slice(3 * first, 3 * second)  # those between the two, no others
                jacobian = jacobian[:, links]
                weighted = np.linalg.solve(covariance, jacobian).T
                matrix[links, links] += weighted @ jacobian
                vector[links] += weighted @ _off(pose, now)
                self._effort.count(len(weighted), len(weighted), 3)
            self.world.covariance = np.asarray(np.linalg.inv(matrix))
            self.world.mean = self.world.mean + self.world.covariance @ vector
            self.world.mean[2::3] = wrap(self.world.mean[2::3])
            self._effort.count(size, size, size)

    def last_frame(self) -> tuple[Array, Array]:
        """Compute where the last submap ended, with covariance, in the mission's frame."""
        return self.world.last_frame()

    def landmarks(self) -> list[tuple[int, Array]]:
        """List all landmarks: number of the true one, and place (2,) m in the mission."""
        places = []
        for frame, built in zip(self.world.frames(), self._maps, strict=False):
            places += list(zip(built.truth, place(frame, built.points), strict=True))
        return places


def register(
    first: PlainMap, second: PlainMap, pairs: tuple[tuple[int, int], ...], start: Array
) -> tuple[Array, Array]:
    """Fit the pose of the second map in the first to their common landmarks.

    Parameters
    ----------
    first, second
        The maps, with covariances of their landmarks.
    pairs
        Common landmarks: number in the first and in the second map.
    start
        Pose (3,) from which Gauss-Newton starts.

    Returns
    -------
    Array
        The pose (3,).
    Array
        Its covariance (3, 3).
    """
    firsts, seconds = (list(side) for side in zip(*pairs, strict=True))
    rows, columns = ((3 + 2 * np.array(n)[:, None] + [0, 1]).ravel() for n in (firsts, seconds))
    fixed = first.covariance[np.ix_(rows, rows)]
    moving = second.covariance[np.ix_(columns, columns)]
    points, targets, pose = second.points[seconds], first.points[firsts], start.copy()
    covariance: Array = np.eye(3)
    # Least squares by the landmarks' covariance in both maps, that of the second turned by the pose
    for _ in range(ITERATIONS):
        turn = place_by_points(pose, len(pairs))
        weighted = np.linalg.solve(fixed + turn @ moving @ turn.T, place_by_pose(pose, points)).T
        covariance = np.asarray(np.linalg.inv(weighted @ place_by_pose(pose, points)))
        pose = pose + covariance @ weighted @ (targets - place(pose, points)).ravel()
    pose[2] = wrap(pose[2])
    return pose, covariance


def _off(measured: Array, now: Array) -> Array:
    """Subtract one pose (3,) from another, with the heading's difference in (-pi, pi]."""
    difference = measured - now
    difference[2] = wrap(difference[2])
    return difference
