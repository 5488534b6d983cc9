# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Factors of a graph of poses and planes, a table for each kind.

Each table names the poses (m, k) and planes (m, l) that its rows see, and linearises all of them at
once: whitened residuals (m, d), and their derivatives by each pose and plane.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.rows import Rows
from hullrecon.studies.sessions.motions import between, compose, errors, plane_in
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class State:
    """What a graph estimates: poses in one frame, or in those of their sessions, and planes."""

    # (n) of the vehicle in g, or in its session's frame; anchors stand first, if there are any
    poses: Poses
    # (p, 3) m in the same frames: unit normal towards the origin times distance, as in `motions`
    planes: Array


@dataclass(frozen=True, kw_only=True)
class Linear:
    """Residuals of a table and their derivatives."""

    residual: Array  # (m, d)
    by_pose: Array  # (m, k, d, 6)
    by_plane: Array  # (m, l, d, 3)


@dataclass(frozen=True, kw_only=True)
class Factors(Rows, ABC):
    """Factors of one kind."""

    poses: Ints  # (m, k) row in `State.poses` of each pose that a factor sees
    planes: Ints  # (m, l) row in `State.planes` of each plane

    @abstractmethod
    def linearise(self, state: State) -> Linear:
        """Compute whitened residuals and their derivatives at a state."""

    def renumbered(self, poses: Ints, planes: Ints) -> Self:
        """Renumber the poses and planes: pose k becomes poses[k], plane k becomes planes[k].

        An empty array leaves the numbers as they are.
        """
        return replace(
            self,
            poses=poses[self.poses] if len(poses) else self.poses,
            planes=planes[self.planes] if len(planes) else self.planes,
        )


@dataclass(frozen=True, kw_only=True)
class Priors(Factors):
    """Poses that are known."""

    measured: Poses  # (m)
    sqrt_information: Array  # (m, 6, 6) of translation m and rotation rad in the measured frame

    def linearise(self, state: State) -> Linear:
        """Compute residuals (m, 6) of poses against what they are known to be."""
        error, derivative = errors(self.measured, state.poses[self.poses[:, 0]])
        return _whitened(self.sqrt_information, error, [derivative])


@dataclass(frozen=True, kw_only=True)
class Levels(Factors):
    """Depth, roll and pitch of poses, as a pressure sensor and an IMU measure them."""

    depth: Array  # (m,) m, z of the pose's frame
    down: Array  # (m, 3) unit, in the vehicle's frame
    sigma: Array  # (2,) of the depth m and of the direction rad

    SHARED = frozenset({"sigma"})

    def linearise(self, state: State) -> Linear:
        """Compute residuals of depth and of the direction of gravity at poses (m, 1): (m, 3)."""
        poses = state.poses[self.poses[:, 0]]
        down = poses.rotation.inv().apply([0.0, 0.0, 1.0]).reshape(-1, 3)
        residual = np.column_stack(
            [(poses.translation[:, 2] - self.depth) / self.sigma[0],
             (down - self.down)[:, :2] / self.sigma[1]]
        )  # fmt: skip
        derivative = np.zeros((len(poses), 3, 6))
        derivative[:, 0, 2] = 1 / self.sigma[0]
        derivative[:, 1:, 3:] = cross_matrix(down)[:, :2] / self.sigma[1]
        return _linear(residual, [derivative])


@dataclass(frozen=True, kw_only=True)
class Links(Factors):
    """Relative poses first_from_second, by odometry or by images."""

    measured: Poses  # (m)
    sqrt_information: Array  # (m, 6, 6)

    def linearise(self, state: State) -> Linear:
        """Compute residuals (m, 6) of the relative pose of two poses."""
        relative, *by = between(state.poses[self.poses[:, 0]], state.poses[self.poses[:, 1]])
        error, derivative = errors(self.measured, relative)
        return _whitened(self.sqrt_information, error, [derivative @ d for d in by])


@dataclass(frozen=True, kw_only=True)
class Encounters(Factors):
    """Relative poses between two sessions, each through its anchor [Ozog2016 2.4.2].

    Poses (m, 4): the first session's anchor and a pose in its frame, then the second's.
    """

    measured: Poses  # (m) first_from_second
    sqrt_information: Array  # (m, 6, 6)

    def linearise(self, state: State) -> Linear:
        """Compute residuals (m, 6) of the relative pose of both places in the common frame."""
        anchor_a, a, anchor_b, b = (state.poses[keys] for keys in self.poses.T)
        first, *by_a = compose(anchor_a, a)
        second, *by_b = compose(anchor_b, b)
        relative, by_first, by_second = between(first, second)
        error, derivative = errors(self.measured, relative)
        by = [by_first @ d for d in by_a] + [by_second @ d for d in by_b]
        return _whitened(self.sqrt_information, error, [derivative @ d for d in by])

    def as_links(self) -> Links:
        """Drop the anchors: the same relative poses where all poses are in one frame."""
        return Links(
            poses=self.poses[:, [1, 3]],
            planes=self.planes,
            measured=self.measured,
            sqrt_information=self.sqrt_information,
        )


@dataclass(frozen=True, kw_only=True)
class Sightings(Factors):
    """Planes fitted to the DVL's points of a pose [Ozog2016 eq. 2.2]."""

    measured: Array  # (m, 3) m in the vehicle's frame: unit normal towards it times distance
    sigma_m: float  # of each of the three numbers

    SHARED = frozenset({"sigma_m"})

    def linearise(self, state: State) -> Linear:
        """Compute residuals (m, 3) of planes in the frames of the poses that see them."""
        seen, by_pose, by_plane = plane_in(
            state.poses[self.poses[:, 0]], state.planes[self.planes[:, 0]]
        )
        return _linear(
            (seen - self.measured) / self.sigma_m, [by_pose / self.sigma_m],
            [by_plane / self.sigma_m],
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class PlanePairs(Factors):
    """Planes (m, 2) of one smooth surface, seen in the frame of a pose [Ozog2016 eq. 2.3]."""

    measured: Array  # (m, 3) m, second less first in that frame
    sqrt_information: Array  # (m, 3, 3)

    def linearise(self, state: State) -> Linear:
        """Compute residuals (m, 3) of the two planes' difference in the frame of a pose."""
        poses = state.poses[self.poses[:, 0]]
        first, by_pose, by_first = plane_in(poses, state.planes[self.planes[:, 0]])
        second, by_pose_too, by_second = plane_in(poses, state.planes[self.planes[:, 1]])
        return _whitened(
            self.sqrt_information,
            second - first - self.measured,
            [by_pose_too - by_pose],
            [-by_first, by_second],
        )


@dataclass(frozen=True, kw_only=True)
class Beams(Factors):
    """Ranges of single beams to planes that are known already [Ozog2016 eqs 2.4, 2.5]."""

    ray: Array  # (m, 3) unit, in the vehicle's frame
    measured_m: Array  # (m,)
    sigma_m: float

    SHARED = frozenset({"sigma_m"})

    def linearise(self, state: State) -> Linear:
        """Compute residuals (m, 1) of ranges along the beams of poses to planes."""
        seen, by_pose, by_plane = plane_in(
            state.poses[self.poses[:, 0]], state.planes[self.planes[:, 0]]
        )
        towards = np.sum(self.ray * seen, axis=1)
        squared = np.sum(seen**2, axis=1)
        # From pi . x = -|pi|^2 on the plane. The print has neither the square nor the sign
        length = -squared / towards
        by_seen = (-2 * seen / towards[:, None] + (squared / towards**2)[:, None] * self.ray)[
            :, None
        ] / self.sigma_m
        return _linear(
            ((length - self.measured_m) / self.sigma_m)[:, None], [by_seen @ by_pose],
            [by_seen @ by_plane],
        )  # fmt: skip


def _whitened(
    sqrt_information: Array, error: Array, by_pose: list[Array], by_plane: list[Array] | None = None
) -> Linear:
    """Whiten errors by the square root of their information, and their derivatives with them.

    Parameters
    ----------
    sqrt_information
        (n, d, d).
    error
        (n, d).
    by_pose, by_plane
        Derivatives (n, d, 6) by each pose and (n, d, 3) by each plane that a factor sees.
    """
    return _linear(
        np.einsum("nij,nj->ni", sqrt_information, error),
        [sqrt_information @ d for d in by_pose],
        [sqrt_information @ d for d in by_plane or []],
    )


def _linear(residual: Array, by_pose: list[Array], by_plane: list[Array] | None = None) -> Linear:
    """Stack whitened residuals (n, d) with their derivatives by each pose and each plane.

    by_pose, by_plane: as of `_whitened`.
    """
    m, d = residual.shape
    return Linear(
        residual=residual,
        by_pose=np.stack(by_pose, axis=1) if by_pose else np.zeros((m, 0, d, 6)),
        by_plane=np.stack(by_plane, axis=1) if by_plane else np.zeros((m, 0, d, 3)),
    )


def no_planes(count: int) -> Ints:
    """Make the planes (rows, 0) of factors that see none."""
    return np.zeros((count, 0), int)
