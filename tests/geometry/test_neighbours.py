# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hullrecon.geometry.neighbours import MANY, Around, count_within, nearest

SEEDS = st.integers(0, 10**6)

LINE = np.array([[0.0, 0], [1, 0], [3, 0]])


def test_the_nearest_come_first() -> None:
    distance, row = nearest(LINE, np.array([[0.8, 0.0]]), 3)
    assert row.tolist() == [[1, 0, 2]]
    assert np.allclose(distance, [[0.2, 0.8, 2.2]])


def test_what_is_out_of_reach_is_infinite_and_has_no_row() -> None:
    distance, row = nearest(LINE, np.array([[0.8, 0.0]]), 2, reach=0.5)
    assert row.tolist() == [[1, 3]]
    assert np.isinf(distance[0, 1])


def test_one_tree_answers_for_many_places() -> None:
    around = Around(LINE)
    assert around(np.array([0.4, 0]), 0.7).tolist() == [0, 1]
    assert around(np.array([9.0, 9]), 0.7).tolist() == []
    assert around.ball(LINE[1:2], 2.0).tolist() == [0, 1, 2]


def test_neighbours_within_reach_are_counted() -> None:
    assert count_within(LINE, np.array([[0.5, 0], [9, 9]]), 0.6).tolist() == [2, 0]


def test_many_places_are_answered_as_few_are() -> None:
    wanted = np.random.default_rng(1).uniform(-1, 4, (MANY + 1, 2))
    halves = [nearest(LINE, half, 2, 1.0) for half in np.split(wanted, [MANY // 2])]
    for found, parts in zip(nearest(LINE, wanted, 2, 1.0), zip(*halves, strict=True), strict=True):
        np.testing.assert_array_equal(found, np.concatenate(parts))
    assert count_within(LINE, wanted, 1.0).max() == 2


@given(SEEDS, st.integers(1, 6), st.floats(0.1, 3.0))
def test_neighbours_are_those_of_all_distances_sorted(seed: int, count: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    points, wanted = rng.normal(size=(9, 3)), rng.normal(size=(4, 3))
    every = np.linalg.norm(wanted[:, None] - points, axis=2)
    order = np.argsort(every, axis=1)[:, :count]
    expected = np.take_along_axis(every, order, axis=1)
    within = expected < reach
    distance, row = nearest(points, wanted, count, reach)
    np.testing.assert_allclose(distance, np.where(within, expected, np.inf))
    np.testing.assert_array_equal(row, np.where(within, order, len(points)))
    np.testing.assert_array_equal(count_within(points, wanted, reach), (every <= reach).sum(axis=1))


@given(SEEDS, st.floats(0.1, 3.0))
def test_around_a_place_are_all_within_reach_in_their_order(seed: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    points, center = rng.normal(size=(20, 2)), rng.normal(size=2)
    expected = np.flatnonzero(np.linalg.norm(points - center, axis=1) <= reach)
    np.testing.assert_array_equal(Around(points)(center, reach), expected)


@given(SEEDS, st.floats(0.1, 2.0))
def test_ball_holds_all_within_reach_of_any_point(seed: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    points, some = rng.normal(size=(30, 3)), rng.normal(size=(4, 3))
    around = Around(points)
    assert set(around.ball(some, reach)) >= {row for place in some for row in around(place, reach)}


def test_more_neighbours_than_points_leave_the_rest_empty() -> None:
    distance, row = nearest(LINE, np.array([[0.0, 0.0]]), 5)
    assert row.tolist() == [[0, 1, 2, 3, 3]]
    assert np.isinf(distance[0, 3:]).all()
