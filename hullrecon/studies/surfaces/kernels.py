# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The kernels of [Ozog2016 3.2.2.2] that the product does not use."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from scipy import sparse

from hullrecon.surface.gaussian import Kernel, NotPositiveDefiniteError, compact
from hullrecon.typing import Array


class RadialKernel(Kernel):
    """The Melkumyan-Ramos function of the radius, as printed: not positive definite in general."""

    NAME: ClassVar[str] = "radial"
    NORM: ClassVar[float] = 2.0

    def correlation(self, gap: Array) -> Array:
        """Compute correlations (k,) at gaps (k, 2) in units of the lengths."""
        return compact(np.linalg.norm(gap, axis=1))

    def covariance(self, at: Array) -> sparse.csr_array:
        """Compute the covariances (n, n) of points (n, 2) with each other.

        Raises NotPositiveDefiniteError where they are none, even if noise would hide it.
        """
        matrix = self.matrix(at, at)
        _require_covariance(matrix, self.sigma)
        return matrix


class WendlandKernel(Kernel):
    """Wendland's C2 function of the radius."""

    NAME: ClassVar[str] = "wendland"
    NORM: ClassVar[float] = 2.0

    def correlation(self, gap: Array) -> Array:
        """Compute correlations (k,) at gaps (k, 2) in units of the lengths."""
        return wendland(np.linalg.norm(gap, axis=1))


def wendland(r: Array) -> Array:
    """Evaluate Wendland's C2 function [Wendland1995], positive definite up to 3-D."""
    return np.asarray(np.maximum(0.0, 1 - r) ** 4 * (4 * r + 1))


def _require_covariance(matrix: sparse.csr_array, sigma_m: float) -> None:
    from scipy.sparse.linalg import eigsh

    n = matrix.shape[0]
    small = n <= 400
    least = (
        np.linalg.eigvalsh(matrix.toarray())[0]
        if small
        else eigsh(matrix, k=1, which="SA", tol=1e-4, v0=np.ones(n))[0][0]
    )
    if least < -1e-9 * n * sigma_m**2:
        raise NotPositiveDefiniteError(
            f"the radial kernel is no covariance on these points (least eigenvalue {least:.2g} m2)",
            where="surface",
            remedy="use the product's kernel or Wendland's",
        )
