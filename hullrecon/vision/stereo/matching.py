# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Matches between the two cameras of a node, and the points that they triangulate to.

Both cameras are turned in software so that the baseline becomes the y axis. Whatever way the rig is
built, a point then has the same x in both images, and y differs by the baseline over its depth
[Ozog2016 D.2.1]. Frames rt, rb are the turned cameras.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.rows import Rows
from hullrecon.typing import Array, Floats32, Ints
from hullrecon.vision.features.descriptors import MatchDescriptors
from hullrecon.vision.pairs.gating import in_box


@dataclass(frozen=True, kw_only=True)
class Rectification:
    """The turned cameras of a stereo rig."""

    rotation_top: Array  # (3, 3) rt from camera_top
    rotation_bottom: Array  # (3, 3) rb from camera_bottom
    baseline_m: float  # > 0: the bottom camera is at +y of the top one in rt

    def rectify_top(self, xy: Array) -> Array:
        """Turn ideal coordinates (n, 2) of the top camera. NaN where a ray points backwards."""
        return turn_rays(self.rotation_top, xy)

    def rectify_bottom(self, xy: Array) -> Array:
        """Turn ideal coordinates (n, 2) of the bottom camera. NaN where a ray points backwards."""
        return turn_rays(self.rotation_bottom, xy)

    def disparity(self, depth_m: Array | float) -> Array:
        """Compute y_top - y_bottom, ideal coordinates, of points at those depths in rt."""
        return np.asarray(self.baseline_m / np.asarray(depth_m, float))


@dataclass(frozen=True, kw_only=True)
class StereoMatches(Rows):
    """Features of a node's two cameras that show one point."""

    top: Ints  # (m,) rows of the top camera's features, each standing for all at its pixel
    bottom: Ints  # (m,) rows of the bottom camera's
    point: Array  # (m, 3) in the top camera, m


@dataclass(frozen=True, kw_only=True)
class StereoSide:
    """The features of one of the two cameras."""

    xy: Array  # (n, 2) ideal coordinates
    descriptor: Floats32  # (n, 128) unit vectors
    place: Ints  # (n,) the row that stands for all at its pixel


def no_matches() -> StereoMatches:
    """Stand in for the matches of a node that has none."""
    return StereoMatches(
        top=np.zeros(0, np.int64), bottom=np.zeros(0, np.int64), point=np.zeros((0, 3))
    )


def rectify(top_from_bottom: Poses) -> Rectification:
    """Rotate both cameras so that the baseline is on y and their axes are parallel.

    Then a match differs in y alone, by an amount that gives its depth. top_from_bottom: the stereo
    mount, a batch of one. The common optical axis is the mean of both, made perpendicular to the
    baseline, so that neither camera is turned more than needed.

    Raises
    ------
    ValueError
        Where the two cameras stand at one place.
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
    """Convert ideal coordinates (n, 2) to those of a camera turned by `rotation` (3, 3).

    NaN where a ray does not point ahead of the turned camera.
    """
    ray = np.hstack([xy, np.ones((len(xy), 1))]) @ rotation.T
    depth = np.where(ray[:, 2:] > 1e-3, ray[:, 2:], np.nan)
    return np.asarray(ray[:, :2] / depth)


def triangulate(rectification: Rectification, top: Array, bottom: Array) -> Array:
    """Triangulate matches to points (n, 3) in the top camera, m [Ozog2016 eq. D.11].

    top, bottom: (n, 2) rectified ideal coordinates. NaN where the disparity is not positive.
    """
    disparity = top[:, 1] - bottom[:, 1]
    depth = rectification.baseline_m / np.where(disparity > 1e-9, disparity, np.nan)
    # x is the same in both images but for noise: the mean is taken
    x = 0.5 * (top[:, 0] + bottom[:, 0])
    points = np.stack([x * depth, top[:, 1] * depth, depth], axis=1)
    return np.asarray(points @ rectification.rotation_top)


def match_stereo(
    rectification: Rectification,
    top: StereoSide,
    bottom: StereoSide,
    depth_m: tuple[float, float],
    column: float,
    match_descriptors: MatchDescriptors,
) -> StereoMatches:
    """Match the features of two cameras within the band of [Ozog2016 D.2.1].

    A feature is searched along its epipolar line between the disparities of the nearest and the
    farthest depth. Matches whose disparity is not positive are dropped.

    Parameters
    ----------
    rectification
        Turns the rays of both cameras, so that matches have the same x.
    top, bottom
        The features of either camera.
    depth_m
        Nearest and farthest depth of the scene.
    column
        Half the width of the band across the epipolar line, ideal coordinates.
    match_descriptors
        Chooses among the pairs in the band.
    """
    xy_top, xy_bottom = rectification.rectify_top(top.xy), rectification.rectify_bottom(bottom.xy)
    most, least = (float(rectification.disparity(depth)) for depth in depth_m)
    # Middle and half size of the box in which the match lies, relative to the rectified feature.
    middle = np.array([0.0, 0.5 * (most + least)])
    half = np.array([column, max(0.5 * (most - least), column)])
    found = match_descriptors(top, bottom, in_box(xy_top - middle, half, xy_bottom))
    points = triangulate(rectification, xy_top[found.first], xy_bottom[found.second])
    matches = StereoMatches(top=found.first, bottom=found.second, point=points)
    return matches.take(np.asarray(np.isfinite(points).all(axis=1)))
