# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which features may be the same point, by position alone: inside a box, or inside each feature's own ellipse (PCCS)."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array, Ints


def in_box(wanted: Array, half_width: Array, points: Array) -> tuple[Ints, Ints]:
    """Return pairs (row of wanted, row of points) with both |differences| within half_width (2,); rows with NaN pair with
    none."""
    return _near(wanted / half_width, points / half_width, 1.0, np.inf)


def in_ellipse(wanted: Array, covariance: Array, points: Array, chi2: float) -> tuple[Ints, Ints]:
    """Return pairs whose squared Mahalanobis distance under covariance (n, 2, 2) of each wanted (n, 2) is at most chi2."""
    if len(wanted) == 0 or len(points) == 0:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    reach = np.sqrt(chi2 * covariance[:, [0, 1], [0, 1]])
    first, second = _by_reach(wanted, reach, points)
    across, down = (points[second, k] - wanted[first, k] for k in range(2))
    xx, xy, yy = (np.ascontiguousarray(column)[first] for column in np.linalg.inv(covariance)[:, [0, 0, 1], [0, 1, 1]].T)
    near = (xx * across + 2 * xy * down) * across + yy * down * down <= chi2
    return first[near], second[near]


def _by_reach(wanted: Array, reach: Array, points: Array) -> tuple[Ints, Ints]:
    """Return pairs within each feature's own box, in groups of like size: one wide ellipse does not cost all."""
    size = np.nan_to_num(reach.max(axis=1), nan=0.0)
    group = np.floor(np.log2(np.maximum(size, 1e-12))).astype(np.int64)
    parts = []
    for level in np.unique(group):
        rows = np.flatnonzero(group == level)
        first, second = in_box(wanted[rows], np.nanmax(reach[rows], axis=0), points)
        parts.append((rows[first], second))
    return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])


def _near(a: Array, b: Array, radius: float, norm: float) -> tuple[Ints, Ints]:
    from scipy.spatial import cKDTree

    rows_a, rows_b = np.flatnonzero(np.isfinite(a).all(axis=1)), np.flatnonzero(np.isfinite(b).all(axis=1))
    if len(rows_a) == 0 or len(rows_b) == 0:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    found = cKDTree(a[rows_a]).sparse_distance_matrix(cKDTree(b[rows_b]), radius, p=norm, output_type="ndarray")
    pair = np.sort(rows_a[found["i"]] * len(b) + rows_b[found["j"]])  # one number a pair: far faster than a sort by two keys
    return pair // len(b), pair % len(b)
