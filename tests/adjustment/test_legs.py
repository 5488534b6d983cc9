# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which legs images tie together."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.adjustment.results.legs import split_legs, tie_legs

T0 = 1_777_887_000 * 10**9  # 09:30:00 UTC


def back_and_forth(
    legs: int, length_m: float, nodes: int = 50, turned_deg: float = 0.0
) -> np.ndarray:
    """Legs along x, half a metre apart, with some sway."""
    rng = np.random.default_rng(1)
    x = np.concatenate(
        [np.linspace(0, length_m, nodes)[:: 1 if k % 2 == 0 else -1] for k in range(legs)]
    )
    y = np.repeat(0.5 * np.arange(legs), nodes)
    turn = np.radians(turned_deg)
    path = np.column_stack(
        [np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, 0 * x]
    )
    return path + rng.normal(0, 0.05, path.shape)


@pytest.mark.parametrize("turned_deg", [0, 30, 90, 200])
@pytest.mark.parametrize("legs", [1, 2, 5])
def test_a_leg_ends_where_the_vehicle_turns_back(legs, turned_deg):
    leg = split_legs(back_and_forth(legs, 12.0, turned_deg=turned_deg))
    assert leg.max() == legs - 1
    assert (np.diff(leg) >= 0).all()
    # the turns are found to a few nodes
    wrong = leg != np.repeat(np.arange(legs), 50)
    assert wrong.sum() <= 3 * (legs - 1)


def test_a_halt_and_a_step_back_do_not_end_a_leg():
    x = np.concatenate(
        [np.linspace(0, 6, 30), np.full(5, 6.0), np.linspace(6, 5, 5), np.linspace(5, 14, 40)]
    )
    assert split_legs(np.column_stack([x, 0 * x, 0 * x])).max() == 0


def test_no_path_and_a_path_of_one_node_have_no_turn():
    assert len(split_legs(np.zeros((0, 3)))) == 0
    assert split_legs(np.zeros((1, 3))).tolist() == [0]


def seen(nodes_by_landmark: dict[int, list[int]]) -> tuple[np.ndarray, np.ndarray]:
    pairs = [(node, landmark) for landmark, nodes in nodes_by_landmark.items() for node in nodes]
    return tuple(np.array(column) for column in zip(*pairs, strict=True))


def test_legs_share_the_landmarks_that_both_see():
    # landmarks 0 to 19 on legs 1 and 2, 20 to 29 on leg 2 (twice) and 3, 40 on leg 3 alone; ids
    # need not be dense
    views = (
        {k: [5, 60] for k in range(20)}
        | {k: [70, 71, 120] for k in range(20, 30)}
        | {40: [130, 131]}
    )
    ties = tie_legs(back_and_forth(3, 12.0), [seen(views)])
    assert ties.shared.tolist() == [[20, 20, 0], [20, 30, 10], [0, 10, 11]]


def test_a_leg_that_shares_too_little_is_named_with_its_start():
    views = {k: [5, 60] for k in range(20)} | {k: [70, 120] for k in range(20, 30)}
    ties = tie_legs(back_and_forth(3, 12.0), [seen(views)])
    t_ns = T0 + np.arange(150) * 10**9
    sentence = ties.describe_untied(t_ns)
    assert sentence is not None
    start = int(np.flatnonzero(ties.leg == 2)[0])
    assert sentence.startswith(
        f"Leg 3 (from 09:{30 + start // 60}:{start % 60:02d}) of 3: fewer than 12 landmarks are "
        "shared"
    )


def test_legs_that_are_tied_and_a_single_leg_are_not_spoken_of():
    tied = tie_legs(back_and_forth(2, 12.0), [seen({k: [5, 60] for k in range(12)})])
    single = tie_legs(back_and_forth(1, 12.0), [seen({k: [5, 6] for k in range(12)})])
    t_ns = T0 + np.arange(100) * 10**9
    assert tied.describe_untied(t_ns) is None
    assert single.describe_untied(t_ns[:50]) is None


def test_a_leg_without_landmarks_is_not_called_untied():
    ties = tie_legs(back_and_forth(3, 12.0), [seen({k: [5, 60] for k in range(12)})])
    assert ties.shared[2].tolist() == [0, 0, 0]
    assert ties.untied.tolist() == []


def test_the_table_has_a_row_a_leg_and_counts_each_pair_once():
    views = {k: [5, 60] for k in range(20)} | {k: [70, 120] for k in range(20, 30)}
    t_ns = T0 + np.arange(150) * 10**9
    rows = tie_legs(back_and_forth(3, 12.0), [seen(views)]).table(t_ns)
    assert [row["leg"] for row in rows] == [1, 2, 3]
    assert [row["shared_with"] for row in rows] == [{"2": 20}, {"3": 10}, {}]
    assert sum(row["nodes"] for row in rows) == 150
    assert rows[0]["from_ns"] == T0
    assert rows[-1]["to_ns"] == T0 + 149 * 10**9
