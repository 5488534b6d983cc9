# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where a feature of one image should lie in another (PCCS): point transfer through the scene's
depth, with covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array


@dataclass(frozen=True)
class Motion:
    """second_from_first (4, 4) between the cameras of two nodes; covariance (6, 6) of (translation
    in second's axes, rotation perturbed on the right, in first's axes).
    """

    second_from_first: Array
    covariance: Array

    def inverse(self) -> Motion:
        """Return first_from_second, its covariance carried over to first order."""
        rotation, translation = self.second_from_first[:3, :3], self.second_from_first[:3, 3]
        back = np.eye(4)
        back[:3, :3], back[:3, 3] = rotation.T, -rotation.T @ translation
        by = np.zeros((6, 6))
        by[:3, :3] = -rotation.T
        # t' = -Exp(-w) R^T t = -R^T t - (R^T t) x w
        by[:3, 3:] = -cross_matrix(rotation.T @ translation)
        by[3:, 3:] = -rotation  # R^T perturbed by Exp(-w) on its left is Exp(-R w) on its right
        return Motion(back, by @ self.covariance @ by.T)


def transfer(
    motion: Motion, xy: Array, depth_m: Array, depth_sigma_m: Array, pixel_sigma: float
) -> tuple[Array, Array]:
    """Return by the unscented transform [Julier2002; Ozog2016 eq. D.12] the mean (n, 2) and
    covariance (n, 2, 2) in the second camera's ideal coordinates.

    xy (n, 2) ideal coordinates in the first camera, depth_m (n,) along its axis, pixel_sigma in
    ideal units. Nine unknowns a feature, kappa 0: each is moved by 3 sigma both ways. NaN where any
    of the nineteen points falls behind the camera.
    """
    spread = _motion_points(motion)
    centre = np.hstack([xy, np.ones((len(xy), 1))])
    moved = [_project(spread, centre * depth_m[:, None])]
    here = motion.second_from_first[None]
    for sign in (3.0, -3.0):
        deeper = np.maximum(depth_m + sign * depth_sigma_m, 0.02 * depth_m)
        moved.append(_project(here, centre * deeper[:, None]))
        for axis in range(2):
            shifted = centre.copy()
            shifted[:, axis] += sign * pixel_sigma
            moved.append(_project(here, shifted * depth_m[:, None]))
    # (2, 18, n), each of weight 1 / 18; the centre has weight 0
    points = np.concatenate(moved, axis=1)
    mean = points.mean(axis=1)
    across, down = points - mean[:, None]
    covariance = np.empty((len(xy), 2, 2))
    # that of the feature in the second image
    covariance[:, 0, 0] = (across * across).mean(axis=0) + pixel_sigma**2
    covariance[:, 1, 1] = (down * down).mean(axis=0) + pixel_sigma**2
    covariance[:, 0, 1] = covariance[:, 1, 0] = (across * down).mean(axis=0)
    return mean.T, covariance


def _motion_points(motion: Motion) -> Array:
    """Return (12, 4, 4): the motion moved by 3 sigma along each column of the square root of its
    covariance.
    """
    values, vectors = np.linalg.eigh(motion.covariance)
    columns = 3.0 * (vectors * np.sqrt(np.maximum(values, 0))).T
    step = np.concatenate([columns, -columns])
    out = np.tile(motion.second_from_first, (12, 1, 1))
    out[:, :3, 3] += step[:, :3]
    out[:, :3, :3] = (
        motion.second_from_first[:3, :3] @ Rotation.from_rotvec(step[:, 3:]).as_matrix()
    )
    return out


def _project(motions: Array, points: Array) -> Array:
    """Return ideal coordinates (2, s, n) of points (n, 3) under each of the motions (s, 4, 4)."""
    seen = (motions[:, :3, :3].swapaxes(0, 1).reshape(-1, 3) @ points.T).reshape(
        3, len(motions), len(points)
    )
    seen += motions[:, :3, 3].T[:, :, None]
    depth = np.where(seen[2] > 1e-6, seen[2], np.nan)
    return np.asarray(seen[:2] / depth)
