# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from hullrecon.records.iterations import broken, count, reached

ROUNDS = np.array([1, 1, 1, 2, 2])


def test_the_cost_reached_is_that_of_the_last_step_taken():
    accepted = np.array([True, False, True, True, False])
    assert reached(np.array([9.0, 12.0, 4.0, 3.0, 8.0]), accepted).tolist() == [9, 9, 4, 3, 3]


def test_starts_of_rounds_are_no_iterations():
    assert count(ROUNDS) == 3
    assert count(np.ones(5, np.int64)) == 4


def test_a_curve_has_a_gap_where_a_round_begins():
    at, values = broken(np.arange(5), np.array([9.0, 8, 7, 90, 80]), ROUNDS)
    np.testing.assert_array_equal(at, [0, 1, 2, np.nan, 3, 4])
    np.testing.assert_array_equal(values, [9, 8, 7, np.nan, 90, 80])
    assert broken(np.arange(3), np.arange(3), np.ones(3, np.int64))[1].tolist() == [0, 1, 2]
