# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Exact Gaussian process regression with sparse kernels [Ozog2016 3.2.2.2]."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from hullrecon.surface.regression.factor import Factor, NotPositiveDefiniteError, factorise
from hullrecon.surface.regression.kernels import Kernel
from hullrecon.typing import Array

CHUNK = 2000  # columns of a variance solved at once: bounds memory at n x 2000


@dataclass(frozen=True, kw_only=True)
class Regression:
    """A fitted field of offsets. at (n, 2) chart points; noise (n,) m, one sigma of each
    observation, 1/sqrt(beta) in O.
    """

    kernel: Kernel
    at: Array
    noise: Array
    weights: Array
    factor: Factor

    def mean(self, wanted: Array) -> Array:
        """Return predicted values [Ozog2016 eq. 3.2] at (m, 2)."""
        return np.asarray(self.kernel.matrix(wanted, self.at) @ self.weights)

    def sigma(self, wanted: Array, noise: float = 0.0) -> Array:
        """Return sigmas [Ozog2016 eq. 3.3] at (m, 2): of the surface; with the noise of a return,
        of the next return.
        """
        parts = [
            self._explained_variance(wanted[i : i + CHUNK]) for i in range(0, len(wanted), CHUNK)
        ]
        variance = np.concatenate([np.zeros(0), *parts])
        return np.asarray(np.sqrt(np.maximum(0.0, self.kernel.sigma**2 - variance) + noise**2))

    def _explained_variance(self, wanted: Array) -> Array:
        cross = self.kernel.matrix(self.at, wanted).toarray()
        return np.asarray(np.einsum("nm,nm->m", cross, self.factor.solve(cross)))


def fit(kernel: Kernel, at: Array, values: Array, noise: Array) -> Regression:
    """Return a zero-mean field conditioned on values (n,) m at (n, 2) with noise (n,) m.

    Raises NotPositiveDefiniteError when the kernel is no covariance on these points, even if noise
    would hide it.
    """
    return _condition(kernel, _covariance(kernel, at), at, values, noise)


def _covariance(kernel: Kernel, at: Array) -> sparse.csr_array:
    covariance = kernel.matrix(at, at)
    if kernel.form == "radial":
        _require_covariance(kernel, covariance)
    return covariance


def _condition(
    kernel: Kernel, covariance: sparse.csr_array, at: Array, values: Array, noise: Array
) -> Regression:
    solver = factorise(covariance + sparse.diags_array(noise**2).tocsr())
    return Regression(
        kernel=kernel, at=at, noise=noise, weights=solver.solve(values), factor=solver
    )


def fit_robust(
    kernel: Kernel, at: Array, values: Array, noise: Array, threshold: float = 2.0, rounds: int = 4
) -> Regression:
    """Return the regression with outliers weighed down.

    Beyond `threshold` sigmas of the surface an observation loses weight by the square of how much
    farther it lies.
    """
    covariance = _covariance(kernel, at)
    result = _condition(kernel, covariance, at, values, noise)
    for _ in range(rounds):
        off = np.abs(values - covariance @ result.weights) / noise
        result = _condition(
            kernel, covariance, at, values, noise * np.maximum(1.0, off / threshold)
        )
    return result


def maximise_likelihood(
    start: Kernel, at: Array, values: Array, noise: Array, limit: tuple[float, float]
) -> tuple[Kernel, float]:
    """Return the field's lengths and sigma and a factor on the noise by marginal likelihood;
    lengths stay within `limit` m.
    """
    from scipy.optimize import minimize

    gap = at[:, None, :] - at[None, :, :]
    low = np.log([limit[0], limit[0], 1e-3, 0.3])
    high = np.log([limit[1], limit[1], 1.0, 10.0])

    def read(x: Array) -> tuple[Kernel, float]:
        along, girth, sigma, factor_ = np.exp(np.clip(x, low, high))
        return replace(start, length=(float(along), float(girth)), sigma=float(sigma)), float(
            factor_
        )

    def cost(x: Array) -> float:
        kernel, factor_ = read(x)
        correlation = kernel.correlation((gap / np.array(kernel.length)).reshape(-1, 2)).reshape(
            len(at), len(at)
        )
        outside = float(np.sum((x - np.clip(x, low, high)) ** 2))
        return outside - _log_likelihood(kernel.sigma**2 * correlation, values, noise * factor_)

    first = np.clip(np.log([*start.length, start.sigma, 1.0]), low, high)
    simplex = np.vstack(
        [first, first + 0.7 * np.where(first + 0.7 * np.eye(4) > high, -1, 1) * np.eye(4)]
    )
    found = minimize(
        cost,
        first,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": 0.03, "fatol": 0.05, "maxfev": 120},
    )
    return read(found.x)


def _log_likelihood(covariance: Array, values: Array, noise: Array) -> float:
    """Log marginal likelihood [Ozog2016 eq. 3.1]; minus infinity where the kernel is no covariance
    on these points.
    """
    from scipy import linalg

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


def _require_covariance(kernel: Kernel, matrix: sparse.csr_array) -> None:
    from scipy.sparse.linalg import eigsh

    n = matrix.shape[0]
    small = n <= 400
    least = (
        np.linalg.eigvalsh(matrix.toarray())[0]
        if small
        else eigsh(matrix, k=1, which="SA", tol=1e-4, v0=np.ones(n))[0][0]
    )
    if least < -1e-9 * n * kernel.sigma**2:
        raise NotPositiveDefiniteError(
            f"the radial kernel is no covariance on these points (least eigenvalue {least:.2g} m2)",
            where="surface",
            remedy="use the product or the wendland kernel",
        )
