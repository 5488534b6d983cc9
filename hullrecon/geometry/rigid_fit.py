# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rigid motions and similarities between point sets in the least-squares sense [Umeyama1991]."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.poses import Poses, from_matrix
from hullrecon.typing import Array


def fit_rigid(source: Array, target: Array) -> Poses:
    """Fit the rigid motion that maps each point set of `source` onto that of `target`.

    Both are (s, n, 3), or (n, 3) for one set, with n >= 3 corresponding points. Returns s poses.
    """
    # The rotation that aligns two sets about their means follows from the SVD of their covariance
    first, second = (np.asarray(p, float).reshape(-1, *np.shape(p)[-2:]) for p in (source, target))
    mean_first, mean_second = first.mean(axis=1, keepdims=True), second.mean(axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(np.einsum("sni,snj->sij", second - mean_second, first - mean_first))
    # Of flat or noisy sets the best fit may be a reflection: its third axis is then reversed
    no_reflection = np.ones((len(first), 3))
    no_reflection[:, 2] = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    matrix = np.tile(np.eye(4), (len(first), 1, 1))
    matrix[:, :3, :3] = (u * no_reflection[:, None, :]) @ vt
    matrix[:, :3, 3] = mean_second[:, 0] - np.einsum(
        "sij,sj->si", matrix[:, :3, :3], mean_first[:, 0]
    )
    return from_matrix(matrix)


def fit_scale(source: Array, target: Array, motion: Poses) -> float:
    """Fit the scale that, after a rigid motion, maps `source` (n, 3) onto `target` (n, 3).

    It acts about the source's mean.
    """
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    return float(np.sum(motion.rotation.apply(a) * b) / np.sum(a**2))
