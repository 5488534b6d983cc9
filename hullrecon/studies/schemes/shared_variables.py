# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two submaps that share variables are independent given those [Aulinas2011 Fig. 2.5].

The graph of the figure, with places in the plane: a vehicle at x1 to x5, features f1 to f5. The
first submap ends at x3 and has f1 to f3, the second starts with x3 and f3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array, Ints

NAMES = ("x1", "x2", "f1", "f2", "x3", "f3", "x4", "x5", "f4", "f5")
FIRST, SHARED, SECOND = np.arange(4), np.arange(4, 6), np.arange(6, 10)  # rows of NAMES
PLACES_M = np.array(
    [
        [0, 0],
        [1, 0.1],
        [0.5, 1],
        [1.2, 1.2],
        [2, 0],
        [2.2, 1],
        [3, -0.1],
        [4, 0],
        [3.2, 1],
        [4.3, 1],
    ]
)
STEPS = (("x1", "x2"), ("x2", "x3"), ("x3", "x4"), ("x4", "x5"))
SIGHTINGS = (
    ("x1", "f1"), ("x2", "f1"), ("x2", "f2"), ("x3", "f2"), ("x3", "f3"), ("x4", "f3"),
    ("x4", "f4"), ("x5", "f4"), ("x5", "f5"),
)  # fmt: skip
STEP_SIGMA_M, SIGHT_SIGMA_M, START_SIGMA_M = 0.1, 0.05, 0.01


@dataclass(frozen=True, kw_only=True)
class Normal:
    """A normal distribution of places (n, 2), independent and equal in both coordinates."""

    mean: Array  # (n, 2)
    covariance: Array  # (n, n)


def measured(rng: np.random.Generator) -> list[tuple[str, str, Array, float]]:
    """Measure the differences (2,) m between pairs of places, with their sigmas.

    Returns name, name, second less first, and sigma of each.
    """
    pairs = [(*pair, STEP_SIGMA_M) for pair in STEPS] + [(*p, SIGHT_SIGMA_M) for p in SIGHTINGS]
    return [
        (a, b, PLACES_M[NAMES.index(b)] - PLACES_M[NAMES.index(a)] + s * rng.standard_normal(2), s)
        for a, b, s in pairs
    ]


def information(rows: list[tuple[str, str, Array, float]], start: bool) -> tuple[Array, Array]:
    """Compute the information matrix (10, 10) and vector (10, 2) of measured differences.

    rows: as of `measured`. start: whether the first place is known, as the origin.
    """
    matrix, vector = np.zeros((10, 10)), np.zeros((10, 2))
    for a, b, difference, sigma in rows:
        row = np.zeros(10)
        row[NAMES.index(b)], row[NAMES.index(a)] = 1.0, -1.0
        matrix += np.outer(row, row) / sigma**2
        vector += np.outer(row, difference) / sigma**2
    if start:
        matrix[0, 0] += 1 / START_SIGMA_M**2
    return matrix, vector


def solved(matrix: Array, vector: Array, kept: Ints) -> Normal:
    """Solve for some of the places, rows `kept` (k,), with all others left out.

    matrix, vector: as of `information`.
    """
    covariance = np.asarray(np.linalg.inv(matrix[np.ix_(kept, kept)]), float)
    return Normal(mean=covariance @ vector[kept], covariance=covariance)


def in_two_submaps(rows: list[tuple[str, str, Array, float]]) -> Normal:
    """Estimate all places with two submaps, and carry what the second learnt back to the first.

    rows: as of `measured`. The second starts with what the first knows of x3 and f3. Given those,
    the first has nothing more to learn: its rest follows by m_A + P_AC P_C^-1 (m_C' - m_C), and its
    covariance follows in the same way.
    """
    own = {NAMES[k] for k in np.r_[FIRST, SHARED]}
    of_first = [row for row in rows if row[0] in own and row[1] in own]
    of_second = [row for row in rows if row not in of_first]
    first = solved(*information(of_first, start=True), np.r_[FIRST, SHARED])
    a, c = slice(0, 4), slice(4, 6)  # what the first has alone, and what is shared
    matrix, vector = information(of_second, start=False)
    known = np.linalg.inv(first.covariance[c, c])
    matrix[np.ix_(SHARED, SHARED)] += known
    vector[SHARED] += known @ first.mean[c]
    second = solved(matrix, vector, np.r_[SHARED, SECOND])
    gain = first.covariance[a, c] @ known
    mean = first.mean[a] + gain @ (second.mean[:2] - first.mean[c])
    own_spread = (
        first.covariance[a, a]
        + gain @ (second.covariance[:2, :2] - first.covariance[c, c]) @ gain.T
    )
    across = gain @ second.covariance[:2]
    return Normal(
        mean=np.vstack([mean, second.mean]),
        covariance=np.block([[own_spread, across], [across.T, second.covariance]]),
    )


def whole(rows: list[tuple[str, str, Array, float]]) -> Normal:
    """Estimate all places at once."""
    return solved(*information(rows, start=True), np.arange(10))
