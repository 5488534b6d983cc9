# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from hullrecon.surface import gaussian as module
from hullrecon.surface.gaussian import NotPositiveDefiniteError, factorise


def _banded(n: int) -> sparse.csr_array:
    return sparse.csr_array(
        sparse.diags_array([-np.ones(n - 1), 2.5 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    )


@pytest.mark.parametrize("small", [0, 1000])
def test_dense_and_sparse_factors_solve(small: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SMALL", small)
    matrix = _banded(60)
    right = np.arange(120.0).reshape(60, 2)
    solver = factorise(matrix)
    assert np.allclose(matrix @ solver.solve(right), right)


@pytest.mark.parametrize("small", [0, 1000])
def test_an_indefinite_matrix_is_refused_by_name(
    small: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "SMALL", small)
    matrix = _banded(60) - 3.0 * sparse.eye_array(60)
    with pytest.raises(NotPositiveDefiniteError, match="not positive definite"):
        factorise(sparse.csr_array(matrix))


def test_a_singular_matrix_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SMALL", 0)
    with pytest.raises(NotPositiveDefiniteError):
        factorise(sparse.csr_array(sparse.diags_array([np.r_[np.ones(9), 0.0]], offsets=[0])))
