# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Predict where a feature of one image lies in another (PCCS), and find features there.

Points are transferred through the scene's depth, with covariance. Candidates are the features in
each point's ellipse.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array, Ints


@dataclass(frozen=True)
class Motion:
    """The motion between the cameras of two nodes."""

    second_from_first: Array  # (4, 4)
    # (6, 6) of translation in second's axes, and rotation perturbed on the right, in first's axes
    covariance: Array

    def inverse(self) -> Motion:
        """Invert the motion, its covariance to first order."""
        rotation, translation = self.second_from_first[:3, :3], self.second_from_first[:3, 3]
        back = np.eye(4)
        back[:3, :3], back[:3, 3] = rotation.T, -rotation.T @ translation
        by = np.zeros((6, 6))
        by[:3, :3] = -rotation.T
        # with w the small rotation: t' = -Exp(-w) R^T t = -R^T t - (R^T t) x w
        by[:3, 3:] = -cross_matrix(rotation.T @ translation)
        by[3:, 3:] = -rotation  # R^T perturbed by Exp(-w) on its left is Exp(-R w) on its right
        return Motion(back, by @ self.covariance @ by.T)


def transfer(
    motion: Motion, xy: Array, depth_m: Array, depth_sigma_m: Array, pixel_sigma: float
) -> tuple[Array, Array]:
    """Predict features in a second camera by the unscented transform [Julier2002], [Ozog2016 D.12].

    Around the predicted position, within its covariance, the feature is then searched. A feature
    has nine unknowns: motion (6), position in the first image (2) and depth. With kappa 0 each is
    moved by 3 sigma both ways.

    Parameters
    ----------
    motion
        From the first camera to the second.
    xy
        Features (n, 2) in the first camera, ideal coordinates.
    depth_m, depth_sigma_m
        Depth (n,) of the features along the first camera's axis, and its sigma.
    pixel_sigma
        Sigma of a feature's position, ideal coordinates.

    Returns
    -------
    mean, covariance
        (n, 2) and (n, 2, 2) in the second camera, ideal coordinates. NaN where any of the moved
        points falls behind it.
    """
    spread = _motion_points(motion)
    centre = np.hstack([xy, np.ones((len(xy), 1))])
    moved = [_project(spread, centre * depth_m[:, None])]
    unmoved = motion.second_from_first[None]
    for sign in (3.0, -3.0):
        # a depth that three sigmas would move behind the camera stays just ahead of it
        deeper = np.maximum(depth_m + sign * depth_sigma_m, 0.02 * depth_m)
        moved.append(_project(unmoved, centre * deeper[:, None]))
        for axis in range(2):
            shifted = centre.copy()
            shifted[:, axis] += sign * pixel_sigma
            moved.append(_project(unmoved, shifted * depth_m[:, None]))
    # (2, 18, n): each has weight 1 / 18. The unmoved point has weight 0 and is left out.
    points = np.concatenate(moved, axis=1)
    mean = points.mean(axis=1)
    across, down = points - mean[:, None]
    covariance = np.empty((len(xy), 2, 2))
    # The feature in the second image adds its own sigma.
    covariance[:, 0, 0] = (across * across).mean(axis=0) + pixel_sigma**2
    covariance[:, 1, 1] = (down * down).mean(axis=0) + pixel_sigma**2
    covariance[:, 0, 1] = covariance[:, 1, 0] = (across * down).mean(axis=0)
    return mean.T, covariance


def _motion_points(motion: Motion) -> Array:
    """Move a motion by 3 sigma along each column of its covariance's square root: (12, 4, 4).

    These are the points of the unscented transform that belong to the motion, both ways.
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
    """Project points (n, 3) m of the first camera into the second to ideal coordinates (2, s, n).

    motions: (s, 4, 4) samples of second_from_first. NaN behind the camera.
    """
    seen = (motions[:, :3, :3].swapaxes(0, 1).reshape(-1, 3) @ points.T).reshape(
        3, len(motions), len(points)
    )
    seen += motions[:, :3, 3].T[:, :, None]
    depth = np.where(seen[2] > 1e-6, seen[2], np.nan)
    return np.asarray(seen[:2] / depth)


def in_box(predicted: Array, half_width: Array, points: Array) -> tuple[Ints, Ints]:
    """Pair each predicted position (n, 2) with the points (m, 2) in a box about it.

    half_width: (2,) of the box, in the unit of the points. Pairs are rows of both, in order. Rows
    with NaN pair with none.
    """
    return native.pairs_in_regions(
        predicted, np.broadcast_to(half_width, predicted.shape), None, points
    )


def in_ellipse(
    predicted: Array, covariance: Array, points: Array, chi2: float
) -> tuple[Ints, Ints]:
    """Pair each predicted position (n, 2) with the points (m, 2) of a chi-square below `chi2`.

    covariance: (n, 2, 2) of each predicted position. Pairs are rows of both, in order. Rows with
    NaN pair with none.
    """
    # The inverse covariance over chi2, as (xx, xy, yy): an ellipse's points have the value 1.
    xx, xy, yy = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    form = np.stack([yy, -xy, xx], axis=1) / (chi2 * (xx * yy - xy * xy))[:, None]
    return native.pairs_in_regions(
        predicted, np.sqrt(chi2 * covariance[:, [0, 1], [0, 1]]), form, points
    )
