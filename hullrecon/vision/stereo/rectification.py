# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Coordinates of a stereo rig in which a match lies on one column.

Both cameras are turned in software so that the baseline becomes the y axis: whatever way the rig is
built, a point then has the same x in both images and y differs by the baseline over its depth
[Ozog2016 D.2.1]. Frames rt, rb are the turned cameras.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class Rectification:
    """rotation_top, rotation_bottom (3, 3): turned camera from camera; baseline_m > 0, bottom is at
    +y of top in rt.
    """

    rotation_top: Array
    rotation_bottom: Array
    baseline_m: float

    def rectify_top(self, xy: Array) -> Array:
        """Return ideal coordinates (n, 2) of the top camera, turned; NaN where a ray no longer
        points forward.
        """
        return turn_rays(self.rotation_top, xy)

    def rectify_bottom(self, xy: Array) -> Array:
        """Return ideal coordinates (n, 2) of the bottom camera, turned; NaN where a ray no longer
        points forward.
        """
        return turn_rays(self.rotation_bottom, xy)

    def disparity(self, depth_m: Array | float) -> Array:
        """Return y_top - y_bottom, ideal coordinates, of points at those depths in rt."""
        return np.asarray(self.baseline_m / np.asarray(depth_m, float))


def rectify(top_from_bottom: Poses) -> Rectification:
    """Return the turn that puts the baseline on y with the least rotation of the two optical axes'
    mean.

    Raises ValueError where the two cameras stand at one place.
    """
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
    return Rectification(rotation_top=top, rotation_bottom=top @ rotation, baseline_m=length)


def turn_rays(rotation: Array, xy: Array) -> Array:
    """Return ideal coordinates (n, 2) as seen by a camera turned by `rotation` (3, 3)."""
    ray = np.hstack([xy, np.ones((len(xy), 1))]) @ rotation.T
    depth = np.where(ray[:, 2:] > 1e-3, ray[:, 2:], np.nan)
    return np.asarray(ray[:, :2] / depth)


def triangulate(rectification: Rectification, top: Array, bottom: Array) -> Array:
    """Return points (n, 3) in the top camera, m, of turned coordinates (n, 2) each; NaN where the
    disparity is not positive.
    """
    disparity = top[:, 1] - bottom[:, 1]
    depth = rectification.baseline_m / np.where(disparity > 1e-9, disparity, np.nan)
    x = 0.5 * (top[:, 0] + bottom[:, 0])
    points = np.stack([x * depth, top[:, 1] * depth, depth], axis=1)
    return np.asarray(points @ rectification.rotation_top)
