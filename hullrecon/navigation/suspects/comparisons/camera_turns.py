# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Fit the turn of a camera between two images to the features of a rigid scene of any shape.

With a wrong distortion, a camera that moves across its view seems to turn in proportion, as the
hull seems to bend. The IMU's orientation shows that it did not (docs/methods.md, Suspects).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses
from hullrecon.geometry.robust import NORMAL_MAD, huber_weight, median_of_known
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.rows import spread_rows
from hullrecon.typing import Array, Ints

MOST_FEATURES = 120  # of a pair; twelve such pairs give a turn to 0.05 degrees
LEAST_SIGMA = 0.0003  # of a feature's position, ideal coordinates: a tenth of a pixel
# prior sigmas of the turn (3), and of the direction of motion (2)
FREE_RAD = np.array([0.2, 0.2, 0.2, 0.05, 0.05])
STEPS = 3  # of Gauss-Newton


def fit_turns(
    motion: Poses, first: Sequence[Array], second: Sequence[Array]
) -> tuple[Array, Array]:
    """Fit the turns that pairs of images show beyond the motions that DVL and IMU measured.

    Right sensors leave none. A wrong distortion makes them grow with the way across the view.

    Parameters
    ----------
    motion
        second_from_first (n) of the camera by DVL and IMU.
    first, second
        Features (m, 2) of each pair, ideal coordinates.

    Returns
    -------
    turn, sigma
        (n, 3) rad each, in the second camera's axes.
    """
    a, b = (_rays(features) for features in (first, second))
    translation, rotation = motion.translation, motion.rotation.as_matrix()
    length = np.linalg.norm(translation, axis=1)[:, None, None]
    across = length * np.linalg.svd(translation[:, None])[2][:, 1:]
    # By pair: a turn (3), and a turn of the direction of motion (2), rad, with a weak prior. They
    # are fitted by Gauss-Newton to distances from epipolar lines, with Huber's weights.
    unknowns, information = np.zeros((len(translation), 5)), np.zeros((len(translation), 5, 5))
    for _ in range(STEPS):
        turned = Rotation.from_rotvec(unknowns[:, :3]).as_matrix() @ rotation
        moved = cross_matrix(translation + np.einsum("nk,nkx->nx", unknowns[:, 3:], across))
        essential = moved @ turned
        # derivatives of the essential matrix
        by_turn = moved[:, None] @ cross_matrix(np.eye(3)) @ turned[:, None]
        by_unknown = np.concatenate([by_turn, cross_matrix(across) @ turned[:, None]], axis=1)
        # Sampson errors: b' E a over the length of both lines' normals, held in the derivative
        lines = np.concatenate(
            [a @ essential[:, :2].transpose(0, 2, 1), b @ essential[:, :, :2]], axis=2
        )
        size = np.sqrt(np.maximum((lines**2).sum(axis=2), 1e-18))
        error = ((b @ essential) * a).sum(axis=2) / size
        jacobian = ((b[:, None] @ by_unknown) * a[:, None]).sum(axis=3) / size[:, None]
        # one normal equation a pair
        sigma = np.maximum(NORMAL_MAD * median_of_known(np.abs(error)), LEAST_SIGMA)[:, None]
        weight = huber_weight(error, sigma)
        known = np.isfinite(error)
        weight, error = np.where(known, weight, 0.0), np.where(known, error, 0.0)
        jacobian = np.where(known[:, None], jacobian, 0.0)
        weighted = jacobian * weight[:, None]
        information = weighted @ jacobian.transpose(0, 2, 1) + np.diag(FREE_RAD**-2)
        gradient = np.einsum("nkm,nm->nk", weighted, error) + unknowns / FREE_RAD**2
        unknowns = unknowns - np.linalg.solve(information, gradient[..., None])[..., 0]
    variance = np.diagonal(np.linalg.inv(information), axis1=1, axis2=2)
    return unknowns[:, :3], np.sqrt(variance[:, :3])


def _rays(features: Sequence[Array]) -> Array:
    """Choose rays (n, m, 3) to at most MOST_FEATURES of each image, evenly, padded with NaN.

    features: ideal coordinates (k, 2) of each image's features.
    """
    rays = np.full((len(features), min(MOST_FEATURES, max(map(len, features))), 3), np.nan)
    for ray, found in zip(rays, features, strict=True):
        rows = _spread_rows(len(found))
        ray[: len(rows), :2], ray[: len(rows), 2] = found[rows], 1.0
    return rays


@cache
def _spread_rows(count: int) -> Ints:
    """Choose at most MOST_FEATURES of `count` rows, evenly spread."""
    return spread_rows(count, MOST_FEATURES)
