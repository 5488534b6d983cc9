# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.geometry.neighbours import Around, count_within, nearest

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
