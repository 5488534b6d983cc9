# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Factors of a symmetric positive definite matrix: dense when it is small or full, sparse else."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from hullrecon.errors import StageError
from hullrecon.typing import Array

SMALL = 1500  # rows; below, LAPACK beats the sparse factor whatever the fill


class Factor(Protocol):
    log_determinant: float

    def solve(self, right: Array) -> Array:
        """Return a^-1 times (n,) or (n, k)."""


class NotPositiveDefiniteError(StageError):
    """The matrix is no covariance."""


def factorise(matrix: sparse.csr_array) -> Factor:
    """Return the factor. Raises NotPositiveDefiniteError when a pivot is not positive."""
    n = matrix.shape[0]
    if n <= SMALL or matrix.nnz > 0.3 * n * n:
        return _Dense(matrix)
    return _Sparse(matrix)


class _Dense:
    def __init__(self, matrix: sparse.csr_array) -> None:
        try:
            self._factor = linalg.cho_factor(matrix.toarray(), lower=True)
        except linalg.LinAlgError as error:
            raise _indefinite() from error
        self.log_determinant = float(2 * np.log(np.diagonal(self._factor[0])).sum())

    def solve(self, right: Array) -> Array:
        return np.asarray(linalg.cho_solve(self._factor, right))


class _Sparse:
    """SuperLU held to the diagonal: the pivots of U are then those of L D L^T."""

    def __init__(self, matrix: sparse.csr_array) -> None:
        try:
            self._factor = splu(
                matrix.tocsc(),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise _indefinite() from error
        pivots = self._factor.U.diagonal()
        if not np.array_equal(self._factor.perm_r, self._factor.perm_c) or pivots.min() <= 0:
            raise _indefinite()
        self.log_determinant = float(np.log(pivots).sum())

    def solve(self, right: Array) -> Array:
        return np.asarray(self._factor.solve(right))


def _indefinite() -> NotPositiveDefiniteError:
    return NotPositiveDefiniteError(
        "the kernel's matrix is not positive definite",
        where="surface",
        remedy="use the product or the wendland kernel",
    )
