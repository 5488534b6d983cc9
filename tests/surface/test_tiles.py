# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Regression in tiles against the one regression that it stands for."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.surface import gaussian
from hullrecon.surface.gaussian import Kernel, Observations, cell_means, fit_robust

KERNEL = Kernel((6.0, 2.0), 0.03)
NOISE_M = 0.006


@pytest.fixture(scope="module")
def seen() -> Observations:
    """Six legs of 30 m, three beams each, over a field drawn from the kernel."""
    rng = np.random.default_rng(3)
    at = np.array(
        [
            (x, 0.6 * leg + beam)
            for leg in range(6)
            for beam in (-0.3, 0.0, 0.3)
            for x in np.arange(0, 30, 0.5)
        ]
    )
    at += rng.normal(0, 0.03, at.shape)
    field = np.linalg.cholesky(
        KERNEL.matrix(at, at).toarray() + 1e-10 * np.eye(len(at))
    ) @ rng.normal(size=len(at))
    offset = field + NOISE_M * rng.normal(size=len(at))
    return Observations(
        at=at, offset=offset, noise=np.full(len(at), NOISE_M), count=np.ones(len(at), np.int64)
    )


@pytest.fixture(scope="module")
def wanted() -> np.ndarray:
    return np.array([(x, y) for x in np.arange(0, 30, 0.3) for y in np.arange(0, 3, 0.2)])


def test_few_observations_are_one_regression(seen: Observations, wanted: np.ndarray) -> None:
    found, exact = (
        gaussian.regress(KERNEL, seen, wanted),
        fit_robust(KERNEL, seen.at, seen.offset, seen.noise),
    )
    assert found.tiles == 1
    np.testing.assert_array_equal(found.mean, exact.mean(wanted))
    np.testing.assert_array_equal(found.sigma, exact.sigma(wanted))


def test_tiles_agree_with_one_regression(seen: Observations, wanted: np.ndarray) -> None:
    exact = fit_robust(KERNEL, seen.at, seen.offset, seen.noise)
    found = gaussian.regress(KERNEL, seen, wanted, most=350)
    assert found.tiles >= 8
    off = np.abs(found.mean - exact.mean(wanted)) / exact.sigma(wanted)
    assert np.percentile(off, 95) < 0.4
    assert off.max() < 1.2
    assert np.abs(found.sigma / exact.sigma(wanted) - 1).max() < 0.08


def test_where_tiles_meet_there_is_no_step(seen: Observations) -> None:
    line = np.column_stack([np.arange(0.5, 29.5, 0.01), np.full(2900, 1.5)])
    found = gaussian.regress(KERNEL, seen, line, most=350)
    one = fit_robust(KERNEL, seen.at, seen.offset, seen.noise).mean(line)
    assert np.abs(np.diff(found.mean)).max() < 1.5 * np.abs(np.diff(one)).max()


def test_no_tile_takes_more_than_it_may(
    seen: Observations, wanted: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken = []

    def counted(kernel, at, values, noise):
        taken.append(len(at))
        return fit_robust(kernel, at, values, noise)

    monkeypatch.setattr(gaussian, "fit_robust", counted)
    gaussian.regress(KERNEL, seen, wanted, most=350)
    assert len(taken) >= 8
    assert max(taken) <= 350


def test_tile_far_from_observations_gives_the_prior(seen: Observations) -> None:
    far = np.array([[500.0, 1.0], [1000.0, 1.0]])
    found = gaussian.regress(KERNEL, seen, far, most=350)
    np.testing.assert_array_equal(found.mean, 0.0)
    np.testing.assert_allclose(found.sigma, KERNEL.sigma)


def test_points_of_one_cell_become_their_weighted_mean() -> None:
    at = np.array([[0.01, 0.01], [0.05, 0.03], [0.15, 0.01]])
    seen = cell_means(at, np.array([1.0, 2.0, 7.0]), np.array([0.1, 0.2, 0.1]), 0.1)
    assert seen.count.tolist() == [2, 1]
    assert np.allclose(seen.offset, [(4 * 1 + 2) / 5, 7])
    assert np.allclose(seen.at[0], [(4 * 0.01 + 0.05) / 5, (4 * 0.01 + 0.03) / 5])
    assert np.allclose(seen.noise, [1 / np.sqrt(125), 0.1])


def test_cells_on_either_side_of_zero_stay_apart() -> None:
    seen = cell_means(np.array([[-0.01, 0.0], [0.01, 0.0]]), np.array([0.0, 1.0]), np.ones(2), 0.1)
    assert seen.offset.tolist() == [0, 1]


def test_the_information_of_all_returns_is_kept() -> None:
    rng = np.random.default_rng(0)
    noise = rng.uniform(0.01, 0.1, 300)
    seen = cell_means(rng.uniform(-2, 2, (300, 2)), rng.normal(size=300), noise, 0.5)
    assert seen.count.sum() == 300
    assert np.isclose(np.sum(seen.noise**-2), np.sum(noise**-2))
