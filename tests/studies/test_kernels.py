# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.surfaces.kernels import RadialKernel, WendlandKernel, wendland
from hullrecon.surface.gaussian import Kernel, NotPositiveDefiniteError, compact, fit

FORMS = (Kernel, RadialKernel, WendlandKernel)


def test_melkumyan_and_ramos_function_at_points_worked_out_by_hand() -> None:
    # r = 1/2: (2 - 1)/3 * 1/2 + 0; r = 1/4: (2 + 0)/3 * 3/4 + 1/(2 pi)
    assert np.allclose(
        compact(np.array([0.0, 0.25, 0.5, 1.0, 2.0])), [1, 0.5 + 1 / (2 * np.pi), 1 / 6, 0, 0]
    )


def test_wendlands_function_at_points_worked_out_by_hand() -> None:
    assert np.allclose(wendland(np.array([0.0, 0.5, 1.0, 3.0])), [1, 3 / 16, 0, 0])


@pytest.mark.parametrize("form", FORMS)
def test_the_sparse_matrix_equals_the_function_at_every_pair(
    form: type[Kernel], rng: np.random.Generator
) -> None:
    kernel = form((3.0, 0.7), 0.2)
    a, b = rng.uniform(0, 4, (40, 2)), rng.uniform(0, 4, (25, 2))
    gap = ((a[:, None] - b[None]) / [3.0, 0.7]).reshape(-1, 2)
    dense = 0.04 * kernel.correlation(gap).reshape(40, 25)
    sparse = kernel.matrix(a, b)
    assert np.allclose(sparse.toarray(), dense, atol=1e-15)
    assert sparse.nnz < a.shape[0] * b.shape[0]


@pytest.mark.parametrize("form", FORMS)
def test_the_covariance_ends_at_the_length(form: type[Kernel]) -> None:
    kernel = form((2.0, 1.0), 1.0)
    beyond = kernel.matrix(np.zeros((1, 2)), np.array([[2.01, 0.0], [0.0, 1.01], [1.9, 0.0]]))
    assert beyond.toarray()[0, :2].tolist() == [0, 0]
    assert beyond.toarray()[0, 2] > 0


@pytest.mark.parametrize("form", [Kernel, WendlandKernel])
def test_product_and_wendland_are_covariances(form: type[Kernel], rng: np.random.Generator) -> None:
    at = rng.uniform(0, 3, (120, 2))
    assert np.linalg.eigvalsh(form((1.5, 1.0), 1.0).matrix(at, at).toarray())[0] > -1e-12


@pytest.mark.parametrize("side", [19, 24])
def test_the_printed_radial_kernel_is_refused_where_it_is_no_covariance(side: int) -> None:
    at = 0.2 * np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(
        -1, 2
    ).astype(float)
    with pytest.raises(NotPositiveDefiniteError, match="radial"):
        fit(RadialKernel((1.0, 1.0), 0.1), at, np.zeros(len(at)), np.full(len(at), 0.5))


def test_the_printed_radial_kernel_works_where_it_is_a_covariance() -> None:
    at = np.array([[0.0, 0], [0.5, 0], [5, 5]])
    result = fit(RadialKernel((1.0, 1.0), 0.1), at, np.array([0.1, 0.1, 0]), np.full(3, 0.01))
    assert result.mean(at)[0] == pytest.approx(0.1, abs=0.01)
