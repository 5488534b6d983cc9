# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which features may be the same point, by position alone: inside a box, or inside each feature's own ellipse (PCCS)."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array, Ints


def in_box(wanted: Array, half_width: Array, points: Array) -> tuple[Ints, Ints]:
    """Return pairs (row of wanted, row of points) with both |differences| within half_width (2,); rows with NaN pair with
    none."""
    return _sorted_pairs(*_in_boxes(wanted, np.broadcast_to(half_width, wanted.shape), points), len(points))


def in_ellipse(wanted: Array, covariance: Array, points: Array, chi2: float) -> tuple[Ints, Ints]:
    """Return pairs whose squared Mahalanobis distance under covariance (n, 2, 2) of each wanted (n, 2) is at most chi2."""
    first, second = _in_boxes(wanted, np.sqrt(chi2 * covariance[:, [0, 1], [0, 1]]), points)
    across, down = (points[second, k] - wanted[first, k] for k in range(2))
    xx, xy, yy = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    by_xx, by_xy, by_yy = (np.take(term / (xx * yy - xy * xy), first) for term in (yy, -xy, xx))
    near = (by_xx * across + 2 * by_xy * down) * across + by_yy * down * down <= chi2
    return _sorted_pairs(first[near], second[near], len(points))


def _in_boxes(wanted: Array, half_width: Array, points: Array) -> tuple[Ints, Ints]:
    """Return pairs within each row's own half_width (n, 2): of the points sorted along one axis those in a row's band, the axis
    whose bands hold fewer, and of them those near along the other."""
    rows = np.flatnonzero(np.isfinite(wanted).all(axis=1) & np.isfinite(half_width).all(axis=1))
    among = np.flatnonzero(np.isfinite(points).all(axis=1))
    low, high = wanted[rows] - half_width[rows], wanted[rows] + half_width[rows]
    bands = []
    for axis in range(2):
        order = among[np.argsort(points[among, axis])]
        along = points[order, axis]
        start = np.searchsorted(along, low[:, axis], "left")
        bands.append((order, start, np.searchsorted(along, high[:, axis], "right") - start))
    narrow = int(bands[1][2].sum() < bands[0][2].sum())
    order, start, count = bands[narrow]
    row = np.repeat(np.arange(len(rows)), count)
    second = order[np.arange(len(row)) + np.repeat(start - (np.cumsum(count) - count), count)]
    place = points[second, 1 - narrow]
    near = (place >= low[row, 1 - narrow]) & (place <= high[row, 1 - narrow])
    return rows[row[near]], second[near]


def _sorted_pairs(first: Ints, second: Ints, points: int) -> tuple[Ints, Ints]:
    """Return the pairs in order of both rows: which of two equal descriptors is the better one must not hang on the search."""
    pair = np.sort(first * points + second)  # one number a pair: far faster than a sort by two keys
    return pair // max(points, 1), pair % max(points, 1)
