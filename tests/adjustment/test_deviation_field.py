# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from hullrecon.adjustment.problem.deviation_field import (
    DeviationGrid,
    as_rows,
    grid_over,
    hold_combinations,
    prior_rows,
)

LENGTH = (3.0, 1.5)


def covariance_from(grid, sigma, node):
    """Column of the prior covariance of one node."""
    rows = prior_rows(grid, sigma, LENGTH)
    unit = np.zeros(grid.size)
    unit[node] = 1.0
    return splu((rows.T @ rows).tocsc()).solve(unit)


def test_the_basis_reproduces_a_bilinear_function():
    grid = DeviationGrid(np.array([-1.0, 2.0]), np.array([0.5, 0.25]), (9, 7))
    along, girth = np.meshgrid(
        grid.origin[0] + 0.5 * np.arange(9), grid.origin[1] + 0.25 * np.arange(7), indexing="ij"
    )
    field = 0.3 + 0.1 * along - 0.2 * girth + 0.05 * along * girth
    at = np.array([[0.13, 2.61], [2.2, 3.4], [-1.0, 2.0], [3.0, 3.5]])
    expected = 0.3 + 0.1 * at[:, 0] - 0.2 * at[:, 1] + 0.05 * at[:, 0] * at[:, 1]
    np.testing.assert_allclose(grid.value(field, at), expected, atol=1e-8)


def test_weights_sum_to_one_and_hold_the_edge_outside():
    grid = DeviationGrid(np.zeros(2), np.ones(2), (3, 3))
    index, weight = grid.basis(np.array([[-5.0, 1.0], [7.0, 7.0], [np.nan, 0.5]]))
    np.testing.assert_allclose(weight.sum(1), 1.0)
    assert index.min() >= 0
    assert index.max() < grid.size
    assert grid.value(np.arange(9.0), np.array([[7.0, 7.0]]))[0] == pytest.approx(8.0, abs=1e-6)


def test_the_prior_has_the_sigma_asked_for_in_the_interior():
    grid = grid_over(np.array([[0.0, 0.0], [20.0, 10.0]]), LENGTH)
    middle = (grid.shape[0] // 2) * grid.shape[1] + grid.shape[1] // 2
    assert np.sqrt(covariance_from(grid, 0.02, middle)[middle]) == pytest.approx(0.02, rel=0.02)


def test_prior_is_correlated_as_its_lengths_say():
    # Matern 3/2 has fallen to (1 + sqrt 12) exp(-sqrt 12) = 0.14 at two lengths
    grid = grid_over(np.array([[0.0, 0.0], [24.0, 12.0]]), LENGTH)
    row, column = grid.shape[0] // 2, grid.shape[1] // 2
    field = covariance_from(grid, 1.0, row * grid.shape[1] + column).reshape(grid.shape)
    steps_along, steps_girth = (
        round(2 * LENGTH[0] / grid.step[0]),
        round(2 * LENGTH[1] / grid.step[1]),
    )
    assert field[row + steps_along, column] / field[row, column] == pytest.approx(0.14, abs=0.04)
    assert field[row, column + steps_girth] / field[row, column] == pytest.approx(0.14, abs=0.04)


def test_the_grid_reaches_one_length_beyond_the_points():
    grid = grid_over(np.array([[0.0, -1.0], [6.0, 2.0]]), LENGTH)
    far = grid.origin + grid.step * (np.array(grid.shape) - 1)
    np.testing.assert_allclose(grid.origin, [-3.0, -2.5])
    assert (far >= [9.0, 3.5]).all()


def test_combinations_that_are_known_condition_the_field():
    """By the dense formula. The fourth depends on the first two, and the fifth is none."""
    grid = DeviationGrid(np.zeros(2), np.ones(2), (9, 5))
    prior = prior_rows(grid, 0.02, LENGTH)
    known = np.random.default_rng(0).normal(size=(5, grid.size))
    known[3:] = 10 * known[0] - known[1], np.zeros(grid.size)
    rows, added = hold_combinations(as_rows(prior), grid, known, 0.02)
    assert added == 3 * 8
    dense = csr_array((rows.value, rows.index, rows.start)).toarray()
    found = np.linalg.inv(dense.T @ dense)[: grid.size, : grid.size]
    before = np.linalg.inv((prior.T @ prior).toarray())
    across = before @ known[:3].T
    expected = before - across @ np.linalg.solve(known[:3] @ across, across.T)
    np.testing.assert_allclose(found, expected, atol=1e-4 * before.max())
