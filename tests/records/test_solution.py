# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.records.solution import DeviationField

# 3 x 2 nodes from (1, -1) on, half a metre along and two metres of girth apart
FIELD = DeviationField(
    origin=np.array([1.0, -1.0]),
    step=np.array([0.5, 2.0]),
    value=np.array([[0.0, 0.04], [0.01, 0.05], [0.02, 0.10]]),
    sigma=np.array([[0.1, 0.1], [0.2, 0.2], [0.4, 0.4]]),
)


def test_the_field_is_its_own_value_at_the_nodes() -> None:
    nodes = np.array([[1.0, -1], [1.5, 1], [2.0, 1]])
    np.testing.assert_allclose(FIELD.value_at(nodes), [0.0, 0.05, 0.10])
    np.testing.assert_allclose(FIELD.sigma_at(nodes), [0.1, 0.2, 0.4])


def test_the_field_is_bilinear_inside_a_cell() -> None:
    # a quarter along, three quarters over the girth of the second cell, by hand
    want = 0.75 * (0.25 * 0.01 + 0.75 * 0.05) + 0.25 * (0.25 * 0.02 + 0.75 * 0.10)
    assert FIELD.value_at(np.array([[1.625, 0.5]]))[0] == pytest.approx(want)


def test_the_field_is_held_beyond_its_ends() -> None:
    np.testing.assert_allclose(FIELD.value_at(np.array([[9.0, 9.0], [-9.0, -9.0], [1.5, 7.0]])), [0.10, 0.0, 0.05])


def test_a_point_off_the_chart_has_no_value_and_is_not_covered() -> None:
    off = np.array([[np.nan, 0.0]])
    assert np.isnan(FIELD.value_at(off)[0])
    assert not FIELD.covers(off)[0]


def test_the_grid_covers_what_lies_between_its_outer_nodes() -> None:
    at = np.array([[1.0, -1.0], [2.0, 1.0], [1.2, 0.0], [2.01, 0.0], [1.5, -1.01]])
    np.testing.assert_array_equal(FIELD.covers(at), [True, True, True, False, False])


def test_a_field_of_one_node_is_that_value_everywhere() -> None:
    one = DeviationField(origin=np.zeros(2), step=np.ones(2), value=np.array([[0.03]]), sigma=np.array([[0.01]]))
    np.testing.assert_allclose(one.value_at(np.array([[0.0, 0.0], [4.0, -2.0]])), 0.03)
