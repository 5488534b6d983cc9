# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A mission by one filter or by submaps, and how far it is from the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits, build_map
from hullrecon.studies.submaps.models import compose, compose_jacobians, wrap
from hullrecon.studies.submaps.worlds import Log, World
from hullrecon.typing import Array


class Strategy(Protocol):
    """A way of making one map of submaps."""

    def add(self, built: EkfMap) -> None:
        """Add a finished submap."""

    def last_frame(self) -> tuple[Array, Array]:
        """Compute the pose (3,) at which the last submap ended, and its covariance (3, 3).

        The pose is x, y, m, and heading, rad, in the mission's frame.
        """

    def landmarks(self) -> list[tuple[int, Array]]:
        """List the landmarks: number of the true one, and place (2,) m in the mission's frame."""


@dataclass(frozen=True, kw_only=True)
class Track:
    """The car as estimated at each scan, with the information up to then."""

    steps: Array  # (n,)
    poses: Array  # (n, 3) x, y m and heading rad in the mission's frame
    covariances: Array  # (n, 3, 3), translation in the mission's frame

    def errors(self, world: World) -> Array:
        """Compute errors (n, 3) in x, y and heading."""
        off = self.poses - world.track[self.steps.astype(int) + 1]
        off[:, 2] = wrap(off[:, 2])
        return np.asarray(off)

    def distances(self, world: World) -> Array:
        """Compute errors (n,) of the position, m."""
        return np.asarray(np.linalg.norm(self.errors(world)[:, :2], axis=1))

    def nees(self, world: World) -> Array:
        """Compute normalised estimation errors squared (n,) (3.21), of three degrees of freedom."""
        off = self.errors(world)
        solved = np.linalg.solve(self.covariances, off[..., None])[..., 0]
        return np.asarray(np.einsum("ni,ni->n", off, solved))


def build_submaps(
    log: Log, limits: Limits, effort: Effort, whole: bool = False, first_estimates: bool = False
) -> list[EkfMap]:
    """Build the submaps of a mission one after the other. Steps after the last scan are left.

    whole, first_estimates: as of `EkfMap`.
    """
    submaps, step, last = [], 0, max(log.scans)
    with effort.stage("local"):
        while step <= last:
            built, step = build_map(log, step, limits, effort, whole, first_estimates)
            submaps.append(built)
    return submaps


def run_filter(
    log: Log, effort: Effort, whole: bool = False, first_estimates: bool = False
) -> tuple[EkfMap, Track]:
    """Run one filter over the whole mission: its map, and the track it estimated.

    whole, first_estimates: as of `EkfMap`.
    """
    with effort.stage("local"):
        built, _ = build_map(log, 0, None, effort, whole, first_estimates)
    return built, track_of([(np.zeros(3), np.zeros((3, 3)), built)])


def run_strategy(submaps: Sequence[EkfMap], strategy: Strategy) -> Track:
    """Hand submaps to a strategy one by one: each starts where the one before ended.

    The track's poses are those known at the time: a later loop does not correct them.
    """
    parts = []
    frame, covariance = np.zeros(3), np.zeros((3, 3))  # x, y, heading of the next submap's start
    for built in submaps:
        parts.append((frame, covariance, built))
        strategy.add(built)
        frame, covariance = strategy.last_frame()
    return track_of(parts)


def final_track(submaps: Sequence[EkfMap], frames: Array) -> Track:
    """Place each submap's path in the frames (n, 3) as they are known in the end."""
    unknown = np.full((3, 3), np.nan)  # the final covariance of a frame is not used
    return track_of([(f, unknown, built) for f, built in zip(frames, submaps, strict=False)])


def track_of(parts: list[tuple[Array, Array, EkfMap]]) -> Track:
    """Put the paths of maps together in the mission's frame.

    parts: pose (3,) and covariance (3, 3) of each map's frame, and the map.
    """
    steps, poses, covariances = [], [], []
    for frame, covariance, built in parts:
        for point in built.path:
            by_frame, by_pose = compose_jacobians(frame, point.pose)
            own = by_pose @ point.covariance @ by_pose.T
            steps.append(point.step)
            poses.append(compose(frame, point.pose))
            covariances.append(by_frame @ covariance @ by_frame.T + own)
    return Track(
        steps=np.array(steps, dtype=float), poses=np.array(poses), covariances=np.array(covariances)
    )


def map_errors(places: list[tuple[int, Array]], world: World) -> Array:
    """Compute how far (n,) mapped landmarks are from the true ones, m.

    places: number of the true landmark, and where it was mapped (2,).
    """
    return np.array([np.linalg.norm(place - world.landmarks[true]) for true, place in places])
