# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs of points: nearest neighbour, joint compatibility, joint compatibility at random."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.association.methods import (
    distances_given,
    joint_compatibility,
    nearest_neighbours,
    randomised_compatibility,
)
from hullrecon.studies.association.point_sets import Hypothesis, PointSets, chi_square
from hullrecon.studies.association.trials import JCBB, NN, RJC, score, simulate_field


def random_sets(dimension: int) -> PointSets:
    rng = np.random.default_rng(dimension)
    n, m = 4, 3
    root = rng.standard_normal(((n + m) * dimension,) * 2)
    joint = root @ root.T + np.eye(len(root))
    cut = n * dimension
    return PointSets(
        first=rng.standard_normal((n, dimension)),
        second=rng.standard_normal((m, dimension)),
        first_covariance=joint[:cut, :cut],
        second_covariance=joint[cut:, cut:],
        cross_covariance=joint[:cut, cut:],
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_distance_grown_pair_by_pair_is_the_joint_one(dimension: int) -> None:
    sets = random_sets(dimension)
    pairs = [(3, 0), (1, 2), (0, 1)]
    hypothesis = Hypothesis(sets)
    for number, pair in enumerate(pairs):
        hypothesis.add(pair)
        alone = sets.joint_distance(pairs[: number + 1])
        assert hypothesis.squared_distance == pytest.approx(alone, rel=1e-9)
    hypothesis.drop()
    assert hypothesis.squared_distance == pytest.approx(sets.joint_distance(pairs[:2]))
    assert sets.squared_distances[3, 0] == pytest.approx(sets.joint_distance([(3, 0)]))


@pytest.mark.parametrize("dimension", [2, 3])
def test_known_pairs_update_the_rest_as_conditioning_does(dimension: int) -> None:
    sets, known = random_sets(dimension), ((0, 1), (3, 0))
    # what the known pairs add to another's joint distance is that pair's distance after them
    more = [sets.joint_distance([*known, (i, 2)]) - sets.joint_distance(known) for i in (1, 2)]
    given = distances_given(sets, known, np.array([[1, 2], [2, 2]]))
    np.testing.assert_allclose(given, more, rtol=1e-9)


def test_clear_points_are_paired_by_their_neighbours() -> None:
    rng = np.random.default_rng(0)
    field = simulate_field(20, rng, offset=0.05)
    found = nearest_neighbours(field.sets)
    assert set(found.pairs) <= field.true_pairs
    assert len(found.pairs) >= 17  # the gate leaves out one in twenty


def test_two_points_never_take_the_same_mate() -> None:
    sets = PointSets(
        first=np.zeros((1, 2)),
        second=np.array([[0.2, 0.0], [0.1, 0.0]]),
        first_covariance=np.eye(2),
        second_covariance=np.eye(4),
    )
    assert nearest_neighbours(sets).pairs == ((0, 1),)


def test_a_common_offset_is_told_from_wrong_pairs_jointly() -> None:
    """Off by 0.4 of the spacing, neighbours mislead and joint compatibility does not."""
    rng = np.random.default_rng(1)
    fields = [simulate_field(20, rng) for _ in range(12)]
    assert score(fields, NN).recall <= 0.90
    joint = score(fields, JCBB)
    assert joint.recall >= 0.98
    assert joint.false == 0.0


def test_points_in_space_are_paired_jointly() -> None:
    rng = np.random.default_rng(2)
    fields = [simulate_field(14, rng, dimension=3, strangers=0.15) for _ in range(4)]
    joint = score(fields, JCBB)
    assert joint.recall >= 0.95
    assert joint.false == 0.0


def test_random_sets_find_as_much_in_a_tenth_of_the_work() -> None:
    rng = np.random.default_rng(7)
    fields = [simulate_field(60, rng, offset=0.8, strangers=0.1)]
    joint, drawn = score(fields, JCBB), score(fields, RJC)
    assert drawn.recall >= 0.98 * joint.recall
    assert drawn.tests <= joint.tests / 10
    assert drawn.false == 0.0


def test_draws_end_where_the_points_are_clear() -> None:
    """The first draw pairs nearly all points, so one more is enough."""
    rng = np.random.default_rng(5)
    field = simulate_field(20, rng, offset=0.2)
    found = randomised_compatibility(field.sets, rng)
    assert found.tests <= 2 * 20
    assert set(found.pairs) <= field.true_pairs


def test_a_stranger_is_left_out() -> None:
    rng = np.random.default_rng(3)
    field = simulate_field(8, rng, offset=0.2, strangers=0.25)
    found = joint_compatibility(field.sets)
    assert set(found.pairs) <= field.true_pairs
    assert len(found.pairs) >= 7


def test_a_search_that_is_cut_short_says_so() -> None:
    rng = np.random.default_rng(4)
    field = simulate_field(20, rng, offset=1.0, strangers=0.3)
    assert not joint_compatibility(field.sets, most_tests=50).complete


def test_sets_without_points_have_no_pairs() -> None:
    sets = PointSets(
        first=np.zeros((0, 2)),
        second=np.ones((2, 2)),
        first_covariance=np.zeros((0, 0)),
        second_covariance=np.eye(4),
    )
    rng = np.random.default_rng(0)
    assert joint_compatibility(sets).pairs == ()
    assert nearest_neighbours(sets).pairs == ()
    assert randomised_compatibility(sets, rng).pairs == ()


def test_bound_is_that_of_the_tables() -> None:
    assert chi_square(0.95, 2) == pytest.approx(5.991, abs=1e-3)
    assert chi_square(0.95, 3) == pytest.approx(7.815, abs=1e-3)
