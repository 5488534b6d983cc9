# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Filters against the batch, and the update that the thesis prints."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.submaps.ekf_slam import update_state
from hullrecon.studies.submaps.filter_study import linear_problem
from hullrecon.studies.submaps.filters import (
    Gaussian,
    LinearStep,
    filter_information,
    filter_steps,
    predict,
    smooth,
    solve_batch,
    update,
)

Problem = tuple[Gaussian, list[LinearStep]]


@pytest.fixture(scope="module")
def problem() -> Problem:
    return linear_problem(3, steps=15)


def test_kalman_filter_is_the_batch_for_the_last_state(problem: Problem) -> None:
    last, batch = filter_steps(*problem)[-1], solve_batch(*problem)[-1]
    np.testing.assert_allclose(last.mean, batch.mean, atol=1e-10)
    np.testing.assert_allclose(last.covariance, batch.covariance, atol=1e-10)


def test_information_filter_is_the_batch_for_the_last_state(problem: Problem) -> None:
    last, batch = filter_information(*problem), solve_batch(*problem)[-1]
    np.testing.assert_allclose(last.mean(), batch.mean, atol=1e-9)
    np.testing.assert_allclose(np.linalg.inv(last.matrix), batch.covariance, atol=1e-9)


def test_smoother_is_the_batch_for_every_state(problem: Problem) -> None:
    smoothed = smooth(filter_steps(*problem), problem[1])
    for state, batch in zip(smoothed, solve_batch(*problem), strict=True):
        np.testing.assert_allclose(state.mean, batch.mean, atol=1e-9)
        np.testing.assert_allclose(state.covariance, batch.covariance, atol=1e-9)


@pytest.fixture(scope="module")
def observed() -> tuple[Gaussian, Gaussian, np.ndarray, np.ndarray, np.ndarray]:
    """Move a state that is observed as a whole, and solve both by least squares."""
    rng = np.random.default_rng(1)
    root = rng.standard_normal((2, 2))
    state = Gaussian(mean=np.array([1.0, 2.0]), covariance=root @ root.T + np.eye(2))
    move, seen, noise = np.array([[1.0, 0.5], [0.0, 1.0]]), np.array([2.5, 1.0]), 0.5 * np.eye(2)
    predicted = predict(state, move @ state.mean, move, 0.2 * np.eye(2))
    weight, other = np.linalg.inv(predicted.covariance), np.linalg.inv(noise)
    covariance = np.linalg.inv(weight + other)
    solved = Gaussian(
        mean=covariance @ (weight @ predicted.mean + other @ seen), covariance=covariance
    )
    return predicted, solved, seen, noise, state.covariance


def test_update_is_least_squares_and_not_as_printed(observed) -> None:  # type: ignore[no-untyped-def]
    predicted, solved, seen, noise, _ = observed
    updated = update(predicted, seen - predicted.mean, np.eye(2), noise)
    np.testing.assert_allclose(updated.mean, solved.mean, atol=1e-12)
    np.testing.assert_allclose(updated.covariance, solved.covariance, atol=1e-12)
    spread = predicted.covariance + noise
    gain = predicted.covariance @ np.linalg.inv(spread)
    printed = predicted.covariance - gain @ spread @ predicted.covariance
    assert np.linalg.eigvalsh(printed).min() < 0


def test_innovation_needs_the_predicted_covariance_not_as_printed(observed) -> None:  # type: ignore[no-untyped-def]
    predicted, solved, seen, noise, before = observed
    gain = predicted.covariance @ np.linalg.inv(before + noise)  # S of the step before
    mean = predicted.mean + gain @ (seen - predicted.mean)
    assert np.abs(mean - solved.mean).max() > 0.05


def test_innovation_by_the_motion_as_printed_misses_the_mean() -> None:
    """[Aulinas2011 eq. 3.10] prints the motion's f for the observation's h."""
    start = Gaussian(mean=np.array([1.0, 2.0]), covariance=np.diag([0.5, 0.2]))
    move, seen, noise = np.array([[1.0, 0.5], [0.0, 1.0]]), np.diag([2.0, -1.0]), 0.1 * np.eye(2)
    step = LinearStep(
        by_state=move,
        offset=np.zeros(2),
        motion_noise=0.2 * np.eye(2),
        observation=seen,
        observed=np.array([4.3, -1.8]),
        observation_noise=noise,
    )
    solved = solve_batch(start, [step])[-1].mean
    np.testing.assert_allclose(filter_steps(start, [step])[-1].mean, solved, atol=1e-12)
    predicted = predict(start, move @ start.mean, move, step.motion_noise)
    printed = update(predicted, step.observed - move @ predicted.mean, seen, noise)
    assert np.abs(printed.mean - solved).max() > 0.5


def test_innovation_squared_is_chi_square_by_the_predicted_covariance_alone() -> None:
    rng = np.random.default_rng(2)
    covariance, seen, noise = np.diag([4.0, 1.0]), np.array([[1.0, 0.5]]), np.array([[0.25]])
    spread = seen @ covariance @ seen.T + noise
    predicted, updated = [], []
    for _ in range(2_000):
        innovation = seen @ rng.multivariate_normal(np.zeros(2), covariance)
        innovation = innovation + rng.normal(0.0, 0.5, 1)
        mean, after = np.zeros(2), covariance.copy()
        predicted.append(update_state(mean, after, covariance @ seen.T, spread, innovation))
        updated.append((innovation**2 / (seen @ after @ seen.T + noise)).item())
    # of one degree of freedom, the mean of 2,000 has a sigma of sqrt(2 / 2000) = 0.03
    assert np.mean(predicted) == pytest.approx(1.0, abs=0.12)
    assert np.mean(updated) > 5


def test_large_maps_are_updated_as_josephs_form_does() -> None:
    rng = np.random.default_rng(2)
    root = rng.standard_normal((7, 7))
    state = Gaussian(mean=rng.standard_normal(7), covariance=root @ root.T)
    jacobian, noise = rng.standard_normal((3, 7)), 0.3 * np.eye(3)
    innovation = rng.standard_normal(3)
    expected = update(state, innovation, jacobian, noise)
    mean, covariance = state.mean.copy(), state.covariance.copy()
    carried = covariance @ jacobian.T
    spread = jacobian @ carried + noise
    nis = update_state(mean, covariance, carried, spread, innovation)
    np.testing.assert_allclose(mean, expected.mean, atol=1e-10)
    np.testing.assert_allclose(covariance, expected.covariance, atol=1e-10)
    assert nis == pytest.approx(innovation @ np.linalg.solve(spread, innovation))
