# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The cameras of a node as one rig, in coordinates where a stereo match lies on one column.

Both cameras are turned in software so that the baseline becomes the y axis: whatever way the rig is built, a point then has
the same x in both images and y differs by the baseline over its depth [Ozog2016 D.2.1]. Frames rt, rb are the turned cameras.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array


@dataclass(frozen=True)
class Rig:
    """cameras: one (mono) or two, top first. top_from_bottom: T_ct_cb, None when mono."""

    top: CameraModel
    bottom: CameraModel | None = None
    top_from_bottom: Poses | None = None

    @property
    def stereo(self) -> bool:
        return self.bottom is not None and self.top_from_bottom is not None

    @property
    def baseline_m(self) -> float:
        """Between the cameras; 1 for a mono rig, whose points have no length."""
        return 1.0 if self.top_from_bottom is None else float(np.linalg.norm(self.top_from_bottom.translation[0]))

    def camera(self, number: int) -> CameraModel:
        """0 top, 1 bottom."""
        if number == 0:
            return self.top
        if self.bottom is None:
            raise ValueError("this rig has no bottom camera")
        return self.bottom

    def focal(self, number: int) -> float:
        """Pixels to a unit of ideal coordinates, the mean of both axes."""
        camera = self.camera(number)
        return 0.5 * (camera.fx + camera.fy)

    def from_top(self, number: int) -> Array:
        """(4, 4): points of the top camera to that camera."""
        if number == 0 or self.top_from_bottom is None:
            return np.eye(4)
        return np.asarray(self.top_from_bottom.inverse().matrix()[0])


@dataclass(frozen=True)
class Rectification:
    """rotation_top, rotation_bottom (3, 3): turned camera from camera; baseline_m > 0, bottom is at +y of top in rt."""

    rotation_top: Array
    rotation_bottom: Array
    baseline_m: float

    def top(self, xy: Array) -> Array:
        """Ideal coordinates (n, 2) of the top camera, turned; NaN where a ray no longer points forward."""
        return turn(self.rotation_top, xy)

    def bottom(self, xy: Array) -> Array:
        return turn(self.rotation_bottom, xy)

    def disparity(self, depth_m: Array | float) -> Array:
        """y_top - y_bottom in ideal coordinates of a point at that depth in rt."""
        return np.asarray(self.baseline_m / np.asarray(depth_m, float))


def rectify(top_from_bottom: Poses) -> Rectification:
    """The turn that puts the baseline on y with the least rotation of the two optical axes' mean."""
    rotation = top_from_bottom.rotation.as_matrix()[0]
    baseline = top_from_bottom.translation[0]
    length = float(np.linalg.norm(baseline))
    if length == 0:
        raise ValueError("the two cameras stand at the same place: no stereo")
    down = baseline / length
    forward = np.array([0.0, 0.0, 1.0]) + rotation[:, 2]
    forward -= down * (forward @ down)
    forward /= np.linalg.norm(forward)
    top = np.stack([np.cross(down, forward), down, forward])
    return Rectification(top, top @ rotation, length)


def turn(rotation: Array, xy: Array) -> Array:
    """Ideal coordinates (n, 2) seen by a camera turned by `rotation` (3, 3)."""
    ray = np.hstack([xy, np.ones((len(xy), 1))]) @ rotation.T
    depth = np.where(ray[:, 2:] > 1e-3, ray[:, 2:], np.nan)
    return np.asarray(ray[:, :2] / depth)


def triangulate(rectification: Rectification, top: Array, bottom: Array) -> Array:
    """Points (n, 3) in the top camera of turned coordinates (n, 2) each; NaN where the disparity is not positive."""
    disparity = top[:, 1] - bottom[:, 1]
    depth = rectification.baseline_m / np.where(disparity > 1e-9, disparity, np.nan)
    x = 0.5 * (top[:, 0] + bottom[:, 0])
    points = np.stack([x * depth, top[:, 1] * depth, depth], axis=1)
    return np.asarray(points @ rectification.rotation_top)
