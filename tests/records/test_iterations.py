# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hullrecon.records.iterations import broken, count, reached_cost

ROUNDS = np.array([1, 1, 1, 2, 2])


def test_the_cost_reached_is_that_of_the_last_step_taken():
    accepted = np.array([True, False, True, True, False])
    assert reached_cost(np.array([9.0, 12.0, 4.0, 3.0, 8.0]), accepted).tolist() == [9, 9, 4, 3, 3]


def test_starts_of_rounds_are_no_iterations():
    assert count(ROUNDS) == 3
    assert count(np.ones(5, np.int64)) == 4


def test_a_curve_has_a_gap_where_a_round_begins():
    at, values = broken(np.arange(5), np.array([9.0, 8, 7, 90, 80]), ROUNDS)
    np.testing.assert_array_equal(at, [0, 1, 2, np.nan, 3, 4])
    np.testing.assert_array_equal(values, [9, 8, 7, np.nan, 90, 80])
    assert broken(np.arange(3), np.arange(3), np.ones(3, np.int64))[1].tolist() == [0, 1, 2]


@given(st.lists(st.tuples(st.floats(0, 1e6), st.booleans()), min_size=1, max_size=30))
def test_the_cost_reached_is_what_a_walk_along_the_rows_finds(
    rows: list[tuple[float, bool]],
) -> None:
    expected, held = [], rows[0][0]  # the first row is the start of the solve
    for cost, accepted in rows:
        held = cost if accepted else held
        expected.append(held)
    cost, accepted = (np.array(column) for column in zip(*rows, strict=True))
    assert reached_cost(cost, accepted).tolist() == expected


@given(st.lists(st.integers(1, 6), max_size=6))
def test_every_round_counts_its_rows_but_the_first(lengths: list[int]) -> None:
    rounds = np.repeat(np.arange(len(lengths)), lengths)
    assert count(rounds) == sum(length - 1 for length in lengths)


@given(st.lists(st.integers(1, 6), min_size=1, max_size=6), st.integers(0, 10**6))
def test_broken_curve_has_gap_between_rounds(lengths: list[int], seed: int) -> None:
    rounds = np.repeat(np.arange(1, len(lengths) + 1), lengths)
    cost = np.random.default_rng(seed).uniform(0, 9, len(rounds))
    at, values = broken(np.arange(len(rounds)), cost, rounds)
    assert np.array_equal(np.isnan(at), np.isnan(values))
    pieces = np.split(values, np.flatnonzero(np.isnan(values)))
    assert [np.count_nonzero(~np.isnan(piece)) for piece in pieces] == lengths
    np.testing.assert_array_equal(values[~np.isnan(values)], cost)
    np.testing.assert_array_equal(at[~np.isnan(at)], np.arange(len(rounds)))


def test_whole_numbers_are_broken_too():
    at, values = broken(np.array([1, 2]), np.array([5, 6], np.int64), np.array([1, 2]))
    np.testing.assert_array_equal(at, [1, np.nan, 2])
    np.testing.assert_array_equal(values, [5, np.nan, 6])
