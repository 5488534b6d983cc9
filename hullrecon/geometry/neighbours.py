# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Nearest points in batches."""

from __future__ import annotations

import os

import numpy as np

from hullrecon.typing import Array, Ints, Mask

MANY = 5000  # query points for which threads are started: 7 ms of search, to 0.1 ms for the threads


def nearest(points: Array, queries: Array, count: int, reach: float = np.inf) -> tuple[Array, Ints]:
    """Find the `count` points (n, k) that are nearest to each query point (m, k).

    Returns
    -------
    distance, row
        (m, count) each, nearest first. Where fewer points are within reach, the distance is inf and
        the row is n.
    """
    return Nearest(points)(queries, count, reach)


class Nearest:
    """Finds the points (n, k) nearest to query points as `nearest` does, with one tree."""

    def __init__(self, points: Array) -> None:
        from scipy.spatial import cKDTree

        self._tree = cKDTree(points)

    def __call__(self, queries: Array, count: int, reach: float = np.inf) -> tuple[Array, Ints]:
        """Find the `count` nearest points to each of the queries (m, k).

        Returns distances (m, count) and rows (m, count). Farther off than `reach` they are inf, and
        the number of points.
        """
        distance, row = self._tree.query(
            queries,
            k=[*range(1, count + 1)],
            distance_upper_bound=reach,
            workers=_threads(len(queries)),
        )
        return np.asarray(distance, np.float64), np.asarray(row, np.int64)


class Around:
    """An index of points (n, k) that finds those around a query point. For many queries."""

    def __init__(self, points: Array) -> None:
        from scipy.spatial import cKDTree

        self._tree = cKDTree(points)

    def __call__(self, center: Array, reach: float) -> Ints:
        """Find the rows within reach of a center (k,), ascending."""
        return np.array(self._tree.query_ball_point(center, reach, return_sorted=True), np.int64)

    def ball(self, points: Array, reach: float) -> Ints:
        """Find the rows in a ball that contains everything within reach of any of the points.

        It is a fast first choice: rows farther off than reach may be among them.
        """
        center = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return self(center, float(np.linalg.norm(points - center, axis=1).max()) + reach)


def is_near(points: Array, queries: Array, reach: float) -> Mask:
    """Tell which query points (m, k) have one of the points (n, k) within reach."""
    if not len(points):
        return np.zeros(len(queries), bool)
    return np.asarray(np.isfinite(nearest(points, queries, 1, reach)[0][:, 0]))


def count_within(points: Array, queries: Array, reach: float) -> Ints:
    """Count the points (n, k) within reach of each of the queries (m, k): (m,)."""
    from scipy.spatial import cKDTree

    counts = cKDTree(points).query_ball_point(
        queries, reach, return_length=True, workers=_threads(len(queries))
    )
    return np.asarray(counts, np.int64)


def _threads(count: int) -> int:
    """Choose the number of threads that search. The result does not depend on it."""
    return len(os.sched_getaffinity(0)) if count > MANY else 1
