# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The map of submaps: their relative transforms, with joint covariance (3.12)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.submaps.ekf_slam import EkfMap
from hullrecon.studies.submaps.models import (
    invert,
    invert_jacobian,
    wrap,
)
from hullrecon.typing import Array


class GlobalMap:
    """Transforms of each frame in the frame before it. Frame 0 is the mission's start.

    Frame k + 1 is where submap k ended: transform k is the last pose of the car in submap k.
    """

    def __init__(self) -> None:
        self.mean = np.zeros(0)
        self.covariance = np.zeros((0, 0))

    def __len__(self) -> int:
        return len(self.mean) // 3

    def append(self, transform: Array, covariance: Array) -> None:
        """Add the transform (3,) of a new frame in the last one, with its covariance (3, 3).

        Its error is independent of those of all other transforms.
        """
        size = len(self.mean)
        grown = np.zeros((size + 3, size + 3))
        grown[:size, :size], grown[size:, size:] = self.covariance, covariance
        self.mean, self.covariance = np.concatenate([self.mean, transform]), grown

    def relative(self, first: int, second: int) -> tuple[Array, Array]:
        """Chain the transforms between two frames to the pose of `second` in `first`.

        Returns
        -------
        Array
            The pose (3,).
        Array
            Its Jacobian (3, 3k) by all k transforms, zero by those outside of the two frames.
        """
        if second < first:
            pose, jacobian = self.relative(second, first)
            return invert(pose), invert_jacobian(pose) @ jacobian
        poses = chain(self.mean[3 * first : 3 * second].reshape(-1, 3))
        jacobian = np.zeros((3, len(self), 3))
        links = slice(first, second)
        # a transform is moved in the frame before it, and turns all that comes after it
        cos, sin = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
        jacobian[0, links] = np.column_stack([cos, -sin, poses[1:, 1] - poses[-1, 1]])
        jacobian[1, links] = np.column_stack([sin, cos, poses[-1, 0] - poses[1:, 0]])
        jacobian[2, links, 2] = 1.0
        return poses[-1], jacobian.reshape(3, -1)

    def frames(self) -> Array:
        """Chain all transforms to the poses (n + 1, 3) of all frames in frame 0."""
        return chain(self.mean.reshape(-1, 3))

    def spreads_seen_from_each(self, frame: int) -> Array:
        """Compute the covariance (k, 3, 3) of a frame's pose in each of the k frames before it.

        k is `frame`. Positions are differences in the axes of frame 0. What an error of a link
        moves at frame k does not depend on the frame that the chain starts in, so the covariance
        from frame j is the sum over all pairs of links from j on. `sums` has these sums for all j
        at once.
        """
        poses = self.frames()[: frame + 1]
        cos, sin = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
        ahead = poses[-1, :2] - poses[1:, :2]
        # derivative of the last frame's pose by each link
        by_link = np.zeros((frame, 3, 3))
        by_link[:, 0] = np.column_stack([cos, -sin, -ahead[:, 1]])
        by_link[:, 1] = np.column_stack([sin, cos, ahead[:, 0]])
        by_link[:, 2, 2] = 1.0
        blocks = self.covariance[: 3 * frame, : 3 * frame].reshape(frame, 3, frame, 3)
        terms = by_link[:, None] @ blocks.transpose(0, 2, 1, 3) @ by_link.swapaxes(1, 2)
        sums = terms[::-1, ::-1].cumsum(axis=0).cumsum(axis=1)[::-1, ::-1]
        return np.asarray(sums[np.arange(frame), np.arange(frame)])

    def last_frame(self) -> tuple[Array, Array]:
        """Compute pose and covariance of the last frame in frame 0."""
        pose, jacobian = self.relative(0, len(self))
        return pose, jacobian @ self.covariance @ jacobian.T


def chain(links: Array) -> Array:
    """Compose transforms (n, 3) to the poses (n + 1, 3) of all frames in the first one."""
    heading = np.concatenate([[0.0], np.cumsum(links[:, 2])])
    cos, sin = np.cos(heading[:-1]), np.sin(heading[:-1])
    steps = np.column_stack(
        [cos * links[:, 0] - sin * links[:, 1], sin * links[:, 0] + cos * links[:, 1]]
    )
    places = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return np.column_stack([places, wrap(heading)])


@dataclass(frozen=True, kw_only=True)
class Submap:
    """Landmarks in one frame, conditional on the transforms of the global map.

    A landmark's place depends on where its map ended, which is a transform of the global map. In
    this form a submap moves with the global map, no information is used twice, and submaps are
    independent of each other.
    """

    base: int  # frame of its coordinates
    frames: tuple[int, ...]  # all frames that it was built from
    mean: Array  # (2n,) m
    gain: Array  # (2n, g) by the transforms that existed when it was made
    given: Array  # (g,) those transforms
    rest: Array  # (2n, 2n) covariance that is left when the transforms are known
    truth: tuple[int, ...]  # only for judging

    @property
    def count(self) -> int:
        """Number of its landmarks."""
        return len(self.truth)

    def now(self, world: GlobalMap) -> Array:
        """Compute the landmarks (2n,) m as they follow from the transforms of now."""
        change = world.mean[: len(self.given)] - self.given
        change[2::3] = wrap(change[2::3])
        return np.asarray(self.mean + self.gain @ change)

    def gain_of(self, size: int) -> Array:
        """Widen the gain to (2n, size) by zeros: landmarks do not depend on later transforms.

        size: number of the transforms' coordinates now.
        """
        return np.pad(self.gain, ((0, 0), (0, size - self.gain.shape[1])))


def append_submap(world: GlobalMap, built: EkfMap) -> Submap:
    """Add the last pose of a finished map to the global map, and keep its landmarks given it."""
    frame = len(world)
    world.append(built.mean[:3], built.covariance[:3, :3])
    own = np.linalg.solve(built.covariance[:3, :3], built.covariance[:3, 3:]).T
    gain = np.zeros((len(own), len(world.mean)))
    gain[:, -3:] = own
    return Submap(
        base=frame,
        frames=(frame,),
        mean=built.mean[3:].copy(),
        gain=gain,
        given=world.mean.copy(),
        rest=built.covariance[3:, 3:] - own @ built.covariance[:3, 3:],
        truth=tuple(built.truth),
    )
