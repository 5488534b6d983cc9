# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Fit the turn of a camera between two images to the features of a rigid scene, whatever its form.

Where a camera moves across its view, a wrong distortion looks as if it turned in proportion: the
hull seems to bend, and an orientation tells that it did not (docs/methods.md, Suspects).
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.poses import Poses, exp
from hullrecon.geometry.robust import robust_sigma
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array

MOST_FEATURES = 120  # of a pair: twelve pairs of as many know a turn to 0.05 degrees
LEAST_SIGMA = 0.0003  # of a feature's place, ideal coordinates: a tenth of a pixel
FREE_RAD = np.array([0.2, 0.2, 0.2, 0.05, 0.05])  # sigmas of the turn, and of the way's direction
STEPS = 3  # of Gauss and Newton
HUBER = 2.0  # sigmas of a residual beyond which its weight falls


def fit_turn(motion: Poses, first: Array, second: Array) -> tuple[Array, Array]:
    """Fit the turn that images show beyond a known motion.

    Parameters
    ----------
    motion
        second_from_first of the camera, a batch of one.
    first, second
        Features (m, 2), ideal coordinates.

    Returns
    -------
    turn, sigma
        (3,) rad, in the second camera's axes.
    """
    rows = np.unique(np.linspace(0, len(first) - 1, MOST_FEATURES).astype(np.int64))
    a, b = (np.column_stack([of[rows], np.ones(len(rows))]) for of in (first, second))
    way, rotation = motion.translation[0], motion.rotation.as_matrix()[0]
    across = np.linalg.norm(way) * np.linalg.svd(way[None])[2][1:]
    unknowns, information = np.zeros(5), np.eye(5)
    for _ in range(STEPS):
        turned = exp(np.r_[0.0, 0.0, 0.0, unknowns[:3]][None]).rotation.as_matrix()[0] @ rotation
        moved = cross_matrix(way + unknowns[3:] @ across)
        essential = moved @ turned
        by_unknown = np.concatenate(
            [moved @ cross_matrix(np.eye(3)) @ turned, cross_matrix(across) @ turned]
        )
        lines = np.hstack([a @ essential.T[:, :2], b @ essential[:, :2]])
        size = np.sqrt(np.maximum((lines**2).sum(axis=1), 1e-18))
        left = ((b @ essential) * a).sum(axis=1) / size
        jacobian = ((b @ by_unknown) * a).sum(axis=2).T / size[:, None]
        sigma = max(robust_sigma(left, about=0.0), LEAST_SIGMA)
        weighted = jacobian.T * np.minimum(1, HUBER * sigma / np.maximum(abs(left), 1e-12))
        information = weighted @ jacobian / sigma**2 + np.diag(FREE_RAD**-2)
        gradient = weighted @ left / sigma**2 + unknowns / FREE_RAD**2
        unknowns = unknowns - np.linalg.solve(information, gradient)
    return unknowns[:3], np.sqrt(np.diag(np.linalg.inv(information)))[:3]
