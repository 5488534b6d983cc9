# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from hullrecon.surface.gaussian import (
    Kernel,
    NotPositiveDefiniteError,
    factorise,
    fit,
    fit_robust,
    maximise_likelihood,
)

KERNEL = Kernel((2.0, 1.0), 0.1)


def _draw(kernel: Kernel, at: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    covariance = kernel.matrix(at, at).toarray() + 1e-12 * np.eye(len(at))
    return np.linalg.cholesky(covariance) @ rng.normal(size=len(at))


def test_mean_and_variance_equal_the_textbook_formulas(rng: np.random.Generator) -> None:
    at, wanted = rng.uniform(0, 4, (30, 2)), rng.uniform(0, 4, (7, 2))
    values, noise = rng.normal(0, 0.1, 30), np.full(30, 0.02)
    result = fit(KERNEL, at, values, noise)
    K = KERNEL.matrix(at, at).toarray() + 0.0004 * np.eye(30)
    k = KERNEL.matrix(at, wanted).toarray()
    assert np.allclose(result.mean(wanted), k.T @ np.linalg.solve(K, values))
    assert np.allclose(
        result.sigma(wanted) ** 2, 0.01 - np.einsum("nm,nm->m", k, np.linalg.solve(K, k))
    )


def test_the_next_return_is_less_certain_than_the_surface(rng: np.random.Generator) -> None:
    at = rng.uniform(0, 4, (30, 2))
    result = fit(KERNEL, at, np.zeros(30), np.full(30, 0.02))
    assert np.allclose(result.sigma(at, noise=0.02) ** 2 - result.sigma(at) ** 2, 0.0004)


def test_far_from_observations_the_prior_returns() -> None:
    result = fit(KERNEL, np.zeros((1, 2)), np.array([0.5]), np.array([0.01]))
    assert result.mean(np.array([[5.0, 5.0]]))[0] == 0
    assert result.sigma(np.array([[5.0, 5.0]]))[0] == pytest.approx(0.1)


def test_one_observation_pulls_by_its_weight() -> None:
    # signal and noise alike: half of it
    result = fit(KERNEL, np.zeros((1, 2)), np.array([0.3]), np.array([0.1]))
    assert result.mean(np.zeros((1, 2)))[0] == pytest.approx(0.15)


def test_no_place_asked_about_gives_no_sigma() -> None:
    result = fit(KERNEL, np.zeros((1, 2)), np.array([0.3]), np.array([0.1]))
    assert result.sigma(np.zeros((0, 2))).shape == (0,)


def test_a_wild_observation_hardly_moves_the_robust_surface(rng: np.random.Generator) -> None:
    at = rng.uniform(0, 2, (80, 2))
    values = rng.normal(0, 0.005, 80)
    values[40] = 0.5
    plain = fit(KERNEL, at, values, np.full(80, 0.005)).mean(at[40:41])
    robust = fit_robust(KERNEL, at, values, np.full(80, 0.005)).mean(at[40:41])
    assert abs(plain[0]) > 0.1
    assert abs(robust[0]) < 0.5 * abs(plain[0])


def test_likelihood_finds_true_lengths_and_noise(
    rng: np.random.Generator,
) -> None:
    truth = Kernel((4.0, 1.5), 0.05)
    at = rng.uniform(0, [6, 4], (300, 2))
    values = _draw(truth, at, rng) + rng.normal(0, 0.01, 300)
    found, scale = maximise_likelihood(
        Kernel((8.0, 3.0), 0.02), at, values, np.full(300, 0.005), (0.3, 60.0)
    )
    # 0.5: the spread over seeds of a patch two lengths wide
    assert found.length[0] == pytest.approx(4.0, rel=0.5)
    assert found.length[1] == pytest.approx(1.5, rel=0.5)
    assert found.sigma == pytest.approx(0.05, rel=0.5)
    assert scale == pytest.approx(2.0, rel=0.2)


def test_lengths_stay_within_their_limits(rng: np.random.Generator) -> None:
    at = rng.uniform(0, 2, (60, 2))
    found, _ = maximise_likelihood(KERNEL, at, 0.3 * at[:, 0], np.full(60, 0.001), (0.5, 3.0))
    assert 0.5 <= found.length[0] <= 3.0 + 1e-9
    assert 0.5 <= found.length[1] <= 3.0 + 1e-9


def _banded(n: int) -> sparse.csr_array:
    return sparse.csr_array(
        sparse.diags_array([-np.ones(n - 1), 2.5 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    )


def test_a_factor_solves_and_gives_the_explained_variance() -> None:
    matrix = _banded(60)
    right = np.arange(120.0).reshape(60, 2)
    factor = factorise(matrix)
    assert np.allclose(matrix @ factor.solve(right), right)
    explained = np.diag(right.T @ np.linalg.inv(matrix.toarray()) @ right)
    assert np.allclose(factor.explained_variance(right), explained)


def test_an_indefinite_matrix_is_refused_by_name() -> None:
    matrix = _banded(60) - 3.0 * sparse.eye_array(60)
    with pytest.raises(NotPositiveDefiniteError, match="not positive definite"):
        factorise(sparse.csr_array(matrix))


def test_a_singular_matrix_is_refused() -> None:
    with pytest.raises(NotPositiveDefiniteError):
        factorise(sparse.csr_array(sparse.diags_array([np.r_[np.ones(9), 0.0]], offsets=[0])))
