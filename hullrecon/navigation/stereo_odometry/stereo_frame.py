# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What one stereo pair gives visual odometry: features of both images and the points that they triangulate to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array, Floats32, Ints, Mask, Pixels

BLOCK = 256  # descriptors compared at a time
UNLIKE = 0.8  # squared distance of descriptors that have nothing in common: a lone candidate must be nearer than to those
RATIO = 0.85  # nearest to second nearest descriptor, Lowe's test; the geometry refuses what it lets through


@dataclass(frozen=True)
class StereoRig:
    """Two cameras, and T_ct_cb, one pose. sigma_px: of a feature. slack_px: how far the rig's own uncertainty moves an epipolar
    line. nearest_m, farthest_m: depths that count."""

    top: CameraModel
    bottom: CameraModel
    T_ct_cb: Poses
    sigma_px: float = 1.0
    slack_px: float = 0.0
    nearest_m: float = 0.2
    farthest_m: float = 30.0


@dataclass(frozen=True)
class Features:
    """Of one image: ideal (n, 2) coordinates x/z, y/z; descriptor (n, 128) float32 of unit length."""

    ideal: Array
    descriptor: Floats32


@dataclass(frozen=True)
class StereoFrame:
    """top, bottom: all features. rows (m, 2): those of a point; point (m, 3) m in camera_top; covariance (m, 3, 3)."""

    top: Features
    bottom: Features
    rows: Ints
    point: Array
    covariance: Array


def stereo_frame(top: Pixels | None, bottom: Pixels | None, rig: StereoRig, most_features: int) -> StereoFrame:
    """From two images (h, w, 3) RGB; one that is None has no features."""
    a, b = find_features(top, rig.top, most_features), find_features(bottom, rig.bottom, most_features)
    rows = stereo_matches(a, b, rig)
    point, covariance = triangulate(a.ideal[rows[:, 0]], b.ideal[rows[:, 1]], rig)
    kept = (point[:, 2] > rig.nearest_m) & (point[:, 2] < rig.farthest_m)
    return StereoFrame(a, b, rows[kept], point[kept], covariance[kept])


def find_features(picture: Pixels | None, camera: CameraModel, most: int) -> Features:
    """SIFT on the gray image after CLAHE (clip 3, 8 x 8 tiles), which lifts what lamps leave dark."""
    import cv2

    if picture is None:
        return Features(np.zeros((0, 2)), np.zeros((0, 128), np.float32))
    gray = cv2.createCLAHE(3.0, (8, 8)).apply(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))
    keypoints, descriptors = cv2.SIFT.create(most, contrastThreshold=0.02).detectAndCompute(gray, None)
    if not keypoints:
        return Features(np.zeros((0, 2)), np.zeros((0, 128), np.float32))
    rooted = np.sqrt(descriptors / np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-9))  # RootSIFT: unit length
    return Features(camera.undistort(np.array([k.pt for k in keypoints])), rooted.astype(np.float32))


def stereo_matches(a: Features, b: Features, rig: StereoRig) -> Ints:
    """Rows (m, 2) of features that lie on each other's epipolar line and look alike."""
    reach = (2.0 * rig.sigma_px + rig.slack_px) / rig.top.fx
    return mutual_best(a.descriptor, b.descriptor, lambda rows: epipolar_distance(a.ideal[rows], b.ideal, rig) <= reach)


def epipolar_distance(a: Array, b: Array, rig: StereoRig) -> Floats32:
    """(n, m): Sampson distance of every pair of ideal points, in units of focal length."""
    R, t = rig.T_ct_cb.rotation.as_matrix()[0], rig.T_ct_cb.translation[0]
    E = cross_matrix(t[None])[0] @ R  # x_a' E x_b = 0
    xa, xb = np.hstack([a, np.ones((len(a), 1))]), np.hstack([b, np.ones((len(b), 1))])
    line_a, line_b = xb @ E.T, xa @ E
    slope_a, slope_b = ((line[:, :2] ** 2).sum(axis=1).astype(np.float32) for line in (line_a, line_b))
    off = line_b.astype(np.float32) @ xb.T.astype(np.float32)
    return np.asarray(np.abs(off) / np.sqrt(np.maximum(slope_a[None] + slope_b[:, None], 1e-20)))


def mutual_best(a: Floats32, b: Floats32, allowed: Callable[[slice], Mask] | None = None) -> Ints:
    """Rows (m, 2) that are each other's nearest descriptor among the allowed, clearly nearer than a's second.

    allowed: from rows of a to a mask (rows, len(b)). Worked through in blocks that stay in the cache.
    """
    best = np.zeros(len(a), np.int64)
    first, second = np.full(len(a), np.inf, np.float32), np.full(len(a), np.inf, np.float32)
    back, back_first = np.full(len(b), -1), np.full(len(b), np.inf, np.float32)
    for start in range(0, len(a) if len(b) else 0, BLOCK):
        rows = slice(start, min(start + BLOCK, len(a)))
        squared = np.maximum(2.0 - 2.0 * (a[rows] @ b.T), 0.0)
        if allowed is not None:
            squared[~allowed(rows)] = np.inf
        nearest, least = np.argmin(squared, axis=0), squared.min(axis=0)
        closer = least < back_first
        back[closer], back_first[closer] = start + nearest[closer], least[closer]
        best[rows] = np.argmin(squared, axis=1)
        own = (np.arange(len(squared)), best[rows])
        first[rows] = squared[own]
        squared[own] = np.inf
        second[rows] = squared.min(axis=1)
    good = np.isfinite(first) & (first < RATIO**2 * np.minimum(second, UNLIKE))
    row = np.flatnonzero(good)
    row = row[back[best[row]] == row]
    return np.stack([row, best[row]], axis=1)


def triangulate(a: Array, b: Array, rig: StereoRig) -> tuple[Array, Array]:
    """Points (n, 3) in camera_top between two rays, and their covariance (n, 3, 3) from sigma_px; NaN where the rays part."""
    R, t = rig.T_ct_cb.rotation.as_matrix()[0], rig.T_ct_cb.translation[0]
    xa = np.hstack([a, np.ones((len(a), 1))])
    xb = np.hstack([b, np.ones((len(b), 1))]) @ R.T
    aa, bb, ab = (xa**2).sum(1), (xb**2).sum(1), (xa * xb).sum(1)
    det = aa * bb - ab**2
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(det > 1e-12, (bb * (xa @ t) - ab * (xb @ t)) / det, np.nan)
        other = np.where(det > 1e-12, (ab * (xa @ t) - aa * (xb @ t)) / det, np.nan)
    point = 0.5 * (xa * depth[:, None] + t + xb * other[:, None])
    point[(depth <= 0) | (other <= 0)] = np.nan
    J = np.concatenate([pinhole_derivative(point), pinhole_derivative((point - t) @ R) @ R.T], axis=1)
    sigma = rig.sigma_px / np.array([rig.top.fx, rig.top.fy, rig.bottom.fx, rig.bottom.fy])
    information = np.swapaxes(J, 1, 2) @ (J / sigma[:, None] ** 2)
    good = np.isfinite(point).all(axis=1)
    covariance = np.full((len(point), 3, 3), np.nan)
    covariance[good] = np.linalg.inv(information[good])
    return point, covariance


def pinhole_derivative(points: Array) -> Array:
    """(n, 2, 3): derivative of x/z, y/z by the point."""
    x, y, z = points.T
    zero = np.zeros_like(z)
    return np.stack([np.stack([1 / z, zero, -x / z**2], 1), np.stack([zero, 1 / z, -y / z**2], 1)], axis=1)
