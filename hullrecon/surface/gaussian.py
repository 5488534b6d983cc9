# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Gaussian process regression on the chart (docs/methods.md 11), in tiles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy import linalg, sparse

from hullrecon.errors import StageError
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints

MOST = 6000  # observations of a tile and its margin at most: the regression's time is cubic in them
OUTLIER_SIGMAS = 2.0  # distance from the surface beyond which an observation loses weight
ROUNDS = 4  # of reweighting outliers
# Width of the margin around a tile from which observations are taken, and of the band on either
# side of its border in which tiles are blended, as shares of the kernel's lengths
MARGIN = 0.5
BLEND = 0.25


@dataclass(frozen=True, kw_only=True)
class Observations(Rows):
    """Means of points over n cells of the chart."""

    at: Array  # (n, 2) m on the chart
    offset: Array  # (n,) m from the base surface
    noise: Array  # (n,) m, sigma of the mean
    count: Ints  # (n,) number of points that were averaged


def cell_means(at: Array, offset: Array, noise: Array, cell_m: float | Array) -> Observations:
    """Average points over the cells of a grid, weighted by their noise, in the grid's order.

    So the regression has fewer observations. Cells without a point are left out.

    Parameters
    ----------
    at, offset
        (n, 2) m on the chart, and (n,) m.
    noise
        (n,) m, sigma of each point, independent of the others.
    cell_m
        Side of a cell, or its sides along and in girth (2,).
    """
    corner = np.floor(at / cell_m).astype(np.int64)
    _, cell = np.unique(corner, axis=0, return_inverse=True)
    cell = cell.reshape(-1)
    weight = noise**-2.0
    total = np.bincount(cell, weight)
    mean = [np.bincount(cell, weight * values) / total for values in (at[:, 0], at[:, 1], offset)]
    return Observations(
        at=np.stack(mean[:2], axis=1),
        offset=mean[2],
        noise=np.sqrt(1 / total),
        count=np.bincount(cell),
    )


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """The predicted field at n points."""

    mean: Array  # (n,) m
    sigma: Array  # (n,) m
    tiles: int  # number of tiles in which it was regressed


@dataclass(frozen=True)
class Box:
    """A rectangle of the chart, low and high (2,) m."""

    low: Array
    high: Array

    def around(self, at: Array, by: Array) -> Ints:
        """List the points (n, 2) in the box, or within `by` (2,) m of it along either axis."""
        return np.flatnonzero(((at >= self.low - by) & (at <= self.high + by)).all(axis=1))

    def weight(self, at: Array, by: Array) -> Array:
        """Compute blending weights (n,) of points (n, 2): from 1 inside to 0 outside of the box.

        They fall linearly over a band that reaches `by` (2,) m to either side of the border.
        """
        inside = np.minimum(at - (self.low - by), (self.high + by) - at) / (2 * by)
        return np.asarray(np.clip(inside, 0, 1).prod(axis=1))


def regress(kernel: Kernel, seen: Observations, wanted: Array, most: int = MOST) -> Prediction:
    """Predict a zero-mean field at points (k, 2) of the chart, with outliers weighted down.

    The chart is split into tiles, which are regressed separately and blended at their borders.

    Parameters
    ----------
    kernel
        Covariance function of the field.
    seen
        Observations to which the field is fitted.
    wanted
        Points (k, 2) m at which it is predicted.
    most
        Observations of a tile and its margin at most: a tile with more is split.

    Raises
    ------
    NotPositiveDefiniteError
        As `fit` does.
    """
    lengths = np.array(kernel.length)
    corners = np.vstack([seen.at, wanted])
    whole = Box(corners.min(axis=0), corners.max(axis=0))
    boxes = list(_split(whole, seen.at, MARGIN * lengths, most))
    # Sums of weights, of weighted means and of weighted sigmas over the tiles that hold a point
    total, mean, sigma = np.zeros((3, len(wanted)))
    for box in boxes:
        rows, near = (
            box.around(wanted, BLEND * lengths),
            seen.take(box.around(seen.at, MARGIN * lengths)),
        )
        if not len(rows):
            continue
        weight = box.weight(wanted[rows], BLEND * lengths) if len(boxes) > 1 else np.ones(len(rows))
        found = _predict(kernel, near, wanted[rows])
        total[rows] += weight
        mean[rows] += weight * found[0]
        sigma[rows] += weight * found[1]
    return Prediction(mean=mean / total, sigma=sigma / total, tiles=len(boxes))


def _predict(kernel: Kernel, seen: Observations, wanted: Array) -> tuple[Array, Array]:
    """Predict mean and sigma (k,) m at points `wanted` (k, 2) m.

    Without observations they are the prior's.
    """
    if not len(seen.at):
        return np.zeros(len(wanted)), np.full(len(wanted), kernel.sigma)
    found = fit_robust(kernel, seen.at, seen.offset, seen.noise)
    return found.mean(wanted), found.sigma(wanted)


def _split(box: Box, at: Array, margin: Array, most: int) -> Iterator[Box]:
    """Split a box until each part has, with its margin (2,) m, at most `most` observations (n, 2).

    Parts that are no larger than their margins are not split.
    """
    size = (box.high - box.low) / margin
    if len(box.around(at, margin)) <= most or size.max() <= 1:
        yield box
        return
    axis = int(np.argmax(size))
    middle = 0.5 * (box.low[axis] + box.high[axis])
    for low, high in ((box.low[axis], middle), (middle, box.high[axis])):
        part = Box(box.low.copy(), box.high.copy())
        part.low[axis], part.high[axis] = low, high
        yield from _split(part, at, margin, most)


CHUNK = 2000  # points predicted at once, and rows of a covariance at once: limits memory


@dataclass(frozen=True)
class Kernel:
    """A covariance function that is zero beyond its lengths, so that its matrices are sparse.

    It is the product of the Melkumyan-Ramos functions of the two axes, which is positive definite.
    """

    length: tuple[float, float]  # m along the hull and in girth, at which the covariance is zero
    sigma: float  # m, of the field

    NAME: ClassVar[str] = "product"  # as surface.json has it
    # Norm of a gap in units of the lengths, in which the covariance is zero from 1 on
    NORM: ClassVar[float] = np.inf

    def matrix(self, a: Array, b: Array) -> sparse.csr_array:
        """Compute covariances (n, k) between points a (n, 2) m and b (k, 2) m of the chart.

        Only pairs nearer than the lengths are found and stored: all others are zero.
        """
        from scipy.spatial import cKDTree

        # In units of the lengths the covariance ends at a distance of 1, which a tree finds
        scale = np.array(self.length)
        left, right = np.asarray(a, float) / scale, np.asarray(b, float) / scale
        tree = cKDTree(right)

        def rows(part: Array) -> sparse.csr_array:
            """Compute the rows of the matrix that belong to a part of the points `a`, scaled."""
            pairs = cKDTree(part).sparse_distance_matrix(
                tree, 1.0, p=self.NORM, output_type="ndarray"
            )
            row, column = pairs["i"], pairs["j"]
            value = self.sigma**2 * self.correlation(part[row] - right[column])
            return sparse.csr_array((value, (row, column)), shape=(len(part), len(right)))

        starts = range(0, max(1, len(left)), CHUNK)
        return sparse.csr_array(sparse.vstack([rows(left[i : i + CHUNK]) for i in starts]))

    def covariance(self, at: Array) -> sparse.csr_array:
        """Compute the covariances (n, n) of points (n, 2) of the chart with each other."""
        return self.matrix(at, at)

    def correlation(self, gap: Array) -> Array:
        """Compute correlations (n,) at gaps (n, 2) in units of the lengths."""
        return np.asarray(compact(np.abs(gap[:, 0])) * compact(np.abs(gap[:, 1])))


def compact(r: Array) -> Array:
    """Evaluate the compact function of [MelkumyanRamos2009] at radii r.

    It is (2 + cos 2 pi r)/3 (1 - r) + sin(2 pi r)/(2 pi), and zero from r = 1 on.
    """
    turn = 2 * np.pi * r
    return np.where(r < 1, (2 + np.cos(turn)) / 3 * (1 - r) + np.sin(turn) / (2 * np.pi), 0.0)


@dataclass(frozen=True, kw_only=True)
class Regression:
    """A field of offsets conditioned on n observations."""

    kernel: Kernel
    at: Array  # (n, 2) m on the chart
    noise: Array  # (n,) m, sigma of each observation: 1/sqrt(beta) in [Ozog2016]
    weights: Array  # (n,) of the observations' kernels, whose sum is the mean
    factor: CovarianceFactor  # of the observations' covariance

    def mean(self, wanted: Array) -> Array:
        """Predict the field (k,) m at points `wanted` (k, 2) m [Ozog2016 eq. 3.2]."""
        starts = range(0, len(wanted), CHUNK)
        parts = [self.kernel.matrix(wanted[i : i + CHUNK], self.at) @ self.weights for i in starts]
        return np.concatenate([np.zeros(0), *parts])

    def sigma(self, wanted: Array, noise: float = 0.0) -> Array:
        """Predict the sigma (k,) m of the field at points `wanted` (k, 2) m [Ozog2016 eq. 3.3].

        With the noise of a return, m, it is that of the offset which another return would measure.
        """
        parts = [
            self._explained_variance(wanted[i : i + CHUNK]) for i in range(0, len(wanted), CHUNK)
        ]
        variance = np.concatenate([np.zeros(0), *parts])
        return np.asarray(np.sqrt(np.maximum(0.0, self.kernel.sigma**2 - variance) + noise**2))

    def _explained_variance(self, wanted: Array) -> Array:
        """Compute by how much the observations lower the prior variance at points (k, 2)."""
        cross = self.kernel.matrix(self.at, wanted).toarray()
        return self.factor.explained_variance(cross)


def fit(kernel: Kernel, at: Array, values: Array, noise: Array) -> Regression:
    """Condition a zero-mean field on values (n,) m with noise (n,) m at points (n, 2).

    The values' covariance is K + I/beta [Ozog2016 eq. 3.1]. Raises NotPositiveDefiniteError when
    the kernel is no covariance on these points.
    """
    return _condition(kernel, kernel.covariance(at), at, values, noise)


def _condition(
    kernel: Kernel, covariance: sparse.csr_array, at: Array, values: Array, noise: Array
) -> Regression:
    """Condition a field on values as `fit` does, given the field's covariance (n, n) there."""
    factor = factorise(covariance + sparse.diags_array(noise**2).tocsr())
    return Regression(
        kernel=kernel, at=at, noise=noise, weights=factor.solve(values), factor=factor
    )


def fit_robust(kernel: Kernel, at: Array, values: Array, noise: Array) -> Regression:
    """Condition a zero-mean field as `fit` does, with outliers weighted down iteratively.

    The noise of an observation beyond OUTLIER_SIGMAS from the surface grows in proportion to its
    distance. at: (n, 2) m. values, noise: (n,) m, and their sigmas.
    """
    covariance = kernel.covariance(at)
    result = _condition(kernel, covariance, at, values, noise)
    for _ in range(ROUNDS):
        off = np.abs(values - covariance @ result.weights) / noise
        result = _condition(
            kernel, covariance, at, values, noise * np.maximum(1.0, off / OUTLIER_SIGMAS)
        )
    return result


def maximise_likelihood(
    start: Kernel, at: Array, values: Array, noise: Array, limit: tuple[float, float]
) -> tuple[Kernel, float]:
    """Estimate the kernel's lengths and sigma, and a factor on the noise, by marginal likelihood.

    Parameters
    ----------
    start
        Kernel from which the search starts.
    at, values, noise
        Observations: (n, 2) m, (n,) m and (n,) m.
    limit
        Least and largest length, m.

    Returns
    -------
    kernel, factor
        The estimated kernel, and the factor on the noise.
    """
    from scipy.optimize import minimize

    # Unknowns: logarithms of both lengths (m), of sigma (m) and of the factor on the noise
    pair = np.tril_indices(len(at))  # each pair once: correlations are symmetric
    difference = at[pair[0]] - at[pair[1]]  # m, of the two points of each pair
    # of sigma 1 mm to 1 m, of the factor 0.3 to 10
    low = np.log([limit[0], limit[0], 1e-3, 0.3])
    high = np.log([limit[1], limit[1], 1.0, 10.0])

    def kernel_and_noise_factor(unknowns: Array) -> tuple[Kernel, float]:
        """Turn the unknowns (4,), clipped to their limits, into a kernel and the noise's factor."""
        along, girth, sigma, factor_ = np.exp(np.clip(unknowns, low, high)).tolist()
        return replace(start, length=(along, girth), sigma=sigma), factor_

    def cost(unknowns: Array) -> float:
        """Compute minus the log likelihood of the values, plus a penalty outside of the limits."""
        kernel, factor_ = kernel_and_noise_factor(unknowns)
        correlation = np.zeros((len(at), len(at)))  # only its lower half is needed
        correlation[pair] = kernel.correlation(difference / np.array(kernel.length))
        outside = float(np.sum((unknowns - np.clip(unknowns, low, high)) ** 2))
        return outside - _log_likelihood(kernel.sigma**2 * correlation, values, noise * factor_)

    first = np.clip(np.log([*start.length, start.sigma, 1.0]), low, high)
    simplex = np.vstack(
        [first, first + 0.7 * np.where(first + 0.7 * np.eye(4) > high, -1, 1) * np.eye(4)]
    )
    # The search starts with a step of a factor of 2 in each unknown, downward at the upper limit
    found = minimize(
        cost,
        first,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": 0.03, "fatol": 0.05, "maxfev": 120},
    )
    return kernel_and_noise_factor(found.x)


def _log_likelihood(covariance: Array, values: Array, noise: Array) -> float:
    """Compute the log marginal likelihood of values (n,) with covariance (n, n) and noise (n,).

    [Ozog2016 eq. 3.1]. It is minus infinity where the covariance is not positive definite. Of the
    covariance the lower half is read.
    """
    try:
        lower = linalg.cholesky(covariance + np.diag(noise**2), lower=True)
    except linalg.LinAlgError:
        return -np.inf
    white = linalg.solve_triangular(lower, values, lower=True)
    return float(
        -0.5 * white @ white
        - np.log(np.diagonal(lower)).sum()
        - 0.5 * len(values) * np.log(2 * np.pi)
    )


class NotPositiveDefiniteError(StageError):
    """The matrix is no covariance."""


@dataclass(frozen=True, kw_only=True)
class CovarianceFactor:
    """The Cholesky factor L of a covariance matrix L L'."""

    lower: Array  # (n, n) L, above whose diagonal stand other numbers

    def solve(self, right: Array) -> Array:
        """Solve with the covariance for right-hand sides (n,) or (n, k)."""
        return np.asarray(linalg.cho_solve((self.lower, True), right))

    def explained_variance(self, cross: Array) -> Array:
        """Compute c' C^-1 c for the covariance C and each of the columns c (n, k).

        By half of a solve: it is the square of the norm of L^-1 c.
        """
        white = linalg.solve_triangular(self.lower, cross, lower=True)
        return np.asarray(np.einsum("nk,nk->k", white, white))


def factorise(matrix: sparse.csr_array) -> CovarianceFactor:
    """Factorise a covariance matrix of at most some MOST rows.

    By LAPACK's dense Cholesky. Also where a fiftieth of the matrix is not zero it is faster than a
    sparse factorisation, as the sigmas need a solve for each of some 10,000 points.

    Raises NotPositiveDefiniteError when the matrix is no covariance.
    """
    try:
        dense = matrix.toarray(order="F")  # in LAPACK's order, so that it needs no copy
        lower, _ = linalg.cho_factor(dense, lower=True, overwrite_a=True)
    except linalg.LinAlgError as error:
        raise NotPositiveDefiniteError(
            "the kernel's matrix is not positive definite", where="surface"
        ) from error
    return CovarianceFactor(lower=lower)
