# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two sets of uncertain points in one frame, and whether a list of pairs can be true.

The points may be landmarks of two maps, a map and a scan, or the objects of two dives: what the
sets share, such as an unknown offset between them, is in the covariances.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from hullrecon.typing import Array, Ints, Mask

Pair = tuple[int, int]  # of the first set, of the second


@dataclass(frozen=True, kw_only=True)
class PointSets:
    """Two sets of points of dimension d = 2 or 3."""

    first: Array  # (n, d) m
    second: Array  # (m, d) m
    first_covariance: Array  # (nd, nd)
    second_covariance: Array  # (md, md)
    cross_covariance: Array | None = None  # (nd, md), where the sets depend on each other

    @property
    def dimension(self) -> int:
        """Dimension of a point."""
        return int(self.first.shape[1])

    def difference(self, pair: Pair) -> Array:
        """Compute how far (d,) the second point of a pair lies from the first."""
        return np.asarray(self.second[pair[1]] - self.first[pair[0]])

    def covariance(self, pair: Pair, other: Pair) -> Array:
        """Compute the cross covariance (d, d) of the differences of two pairs of points."""
        (i, j), (k, m), d = pair, other, self.dimension
        block = _block(self.first_covariance, i, k, d) + _block(self.second_covariance, j, m, d)
        if self.cross_covariance is not None:
            block = block - _block(self.cross_covariance, i, m, d)
            block = block - _block(self.cross_covariance, k, j, d).T
        return block

    @cached_property
    def differences(self) -> Array:
        """Compute how far the second point of each pair lies from the first (n, m, d)."""
        return np.asarray(self.second[None, :] - self.first[:, None])

    @cached_property
    def spreads(self) -> Array:
        """Compute the covariance (n, m, d, d) of each pair's difference."""
        n, m, d = len(self.first), len(self.second), self.dimension
        spread = _diagonal_blocks(self.first_covariance, d)[:, None]
        spread = spread + _diagonal_blocks(self.second_covariance, d)[None, :]
        if self.cross_covariance is not None:
            cross = self.cross_covariance.reshape(n, d, m, d).transpose(0, 2, 1, 3)
            spread = spread - cross - cross.swapaxes(2, 3)
        return np.asarray(spread)

    @cached_property
    def squared_distances(self) -> Array:
        """Compute the squared Mahalanobis distance (n, m) of each pair by itself."""
        if len(self.first) == 0 or len(self.second) == 0:
            return np.zeros((len(self.first), len(self.second)))
        return squared_lengths(self.differences, self.spreads)

    def spread_of(self, firsts: Ints, seconds: Ints) -> Array:
        """Compute the joint covariance (kd, kd) of the differences of k pairs.

        firsts, seconds: rows (kd,) of the pairs' points in either covariance, as of `rows_of`.
        """
        spread = self.first_covariance[np.ix_(firsts, firsts)]
        spread = spread + self.second_covariance[np.ix_(seconds, seconds)]
        if self.cross_covariance is not None:
            cross = self.cross_covariance[np.ix_(firsts, seconds)]
            spread = spread - cross - cross.T
        return np.asarray(spread)

    def joint_distance(self, pairs: Sequence[Pair]) -> float:
        """Compute the squared Mahalanobis distance of all pairs together."""
        if not pairs:
            return 0.0
        firsts, seconds = (rows_of(list(side), self.dimension) for side in zip(*pairs, strict=True))
        off = self.second.ravel()[seconds] - self.first.ravel()[firsts]
        return float(off @ np.linalg.solve(self.spread_of(firsts, seconds), off))

    def part(self, firsts: Ints, seconds: Ints) -> PointSets:
        """Select points of either set by their numbers (k,) and (l,), with their covariances."""
        rows, columns = (rows_of(side.tolist(), self.dimension) for side in (firsts, seconds))
        cross = self.cross_covariance
        return PointSets(
            first=self.first[firsts],
            second=self.second[seconds],
            first_covariance=self.first_covariance[np.ix_(rows, rows)],
            second_covariance=self.second_covariance[np.ix_(columns, columns)],
            cross_covariance=None if cross is None else cross[np.ix_(rows, columns)],
        )

    def compatible(self, confidence: float) -> Mask:
        """Tell which pairs (n, m) pass the chi-square gate of this confidence by themselves."""
        return np.asarray(self.squared_distances < chi_square(confidence, self.dimension))


@dataclass(frozen=True, kw_only=True)
class Association:
    """Points held for the same."""

    pairs: tuple[Pair, ...]  # by the second point
    squared_distance: float  # joint, of all pairs
    tests: int  # joint tests that it took
    complete: bool = True  # False where the search was cut short


@cache
def chi_square(confidence: float, degrees: int) -> float:
    """Compute the bound that chi-square stays below with this probability."""
    from scipy.special import chdtri

    return float(chdtri(degrees, 1.0 - confidence))


class Hypothesis:
    """Pairs with the triangular factor of their joint covariance, grown pair by pair."""

    def __init__(self, sets: PointSets) -> None:
        """Start without pairs. Memory is set aside for as many as the sets can have."""
        self._sets = sets
        self.pairs: list[Pair] = []
        size = min(len(sets.first), len(sets.second)) * sets.dimension
        self._rows = np.zeros((2, size), dtype=np.int64)  # of the pairs in either covariance
        self._whitening = np.zeros((size, size))  # inverse of the factor
        self._whitened = np.zeros(size)
        self._squares = [0.0]  # joint squared distance by number of pairs

    @property
    def squared_distance(self) -> float:
        """Joint squared Mahalanobis distance of all pairs."""
        return self._squares[-1]

    def add(self, pair: Pair) -> None:
        """Add a pair, and extend the inverse factor and the joint distance by its d rows."""
        d, have = self._sets.dimension, len(self.pairs) * self._sets.dimension
        whitening = self._whitening[:have, :have]
        gain = whitening @ self._across(pair)
        rest = self._sets.covariance(pair, pair) - gain.T @ gain  # given the pairs before
        inverse = np.linalg.inv(np.linalg.cholesky(rest))
        new = slice(have, have + d)
        self._whitening[new, :have] = -inverse @ gain.T @ whitening
        self._whitening[new, new] = inverse
        innovation = self._sets.difference(pair) - gain.T @ self._whitened[:have]
        self._whitened[new] = inverse @ innovation
        self._rows[:, new] = np.array(pair)[:, None] * d + np.arange(d)
        self._squares.append(self._squares[-1] + float(self._whitened[new] @ self._whitened[new]))
        self.pairs.append(pair)

    def _across(self, pair: Pair) -> Array:
        """Look up the covariance of all pairs' differences (kd) with that of another pair (d)."""
        sets, d = self._sets, self._sets.dimension
        firsts, seconds = self._rows[:, : len(self.pairs) * d]
        first, second = (slice(number * d, (number + 1) * d) for number in pair)
        across = sets.first_covariance[firsts, first] + sets.second_covariance[seconds, second]
        if sets.cross_covariance is not None:
            across = across - sets.cross_covariance[firsts, second]
            across = across - sets.cross_covariance[first, seconds].T
        return np.asarray(across)

    def drop(self) -> None:
        """Take the last pair back."""
        self.pairs.pop()
        self._squares.pop()

    def holds(self, confidence: float) -> bool:
        """Tell whether the pairs are jointly compatible."""
        degrees = len(self.pairs) * self._sets.dimension
        return degrees == 0 or self.squared_distance < chi_square(confidence, degrees)


def squared_lengths(off: Array, covariance: Array) -> Array:
    """Compute squared Mahalanobis lengths of vectors (..., d) with covariances (..., d, d)."""
    whitened = np.linalg.solve(covariance, off[..., None])[..., 0]
    return np.asarray((off * whitened).sum(axis=-1))


def rows_of(points: list[int], dimension: int) -> Ints:
    """Find the rows (k * dimension,) of points, given by number, in a covariance."""
    return np.asarray(
        (np.array(points, dtype=np.int64)[:, None] * dimension + np.arange(dimension)).ravel()
    )


def _block(matrix: Array, row: int, column: int, size: int) -> Array:
    """Cut the block (size, size) of two points out of a covariance."""
    return matrix[row * size : (row + 1) * size, column * size : (column + 1) * size]


def _diagonal_blocks(matrix: Array, size: int) -> Array:
    """Cut the own covariance (n, size, size) of each point out of a covariance."""
    count = len(matrix) // size
    index = np.arange(count)
    return np.asarray(matrix.reshape(count, size, count, size)[index, :, index])
