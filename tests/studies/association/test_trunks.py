# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Trunks of trees in a laser's half circle."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.association.trunk_study import error_m, find_at
from hullrecon.studies.association.trunks import REACH_M, find_trunks, fit_trunk, scan_trees

HERE = np.zeros(3)


def errors(distance: float, widened: bool) -> list[float]:
    rng = np.random.default_rng(0)
    found = []
    for _ in range(80):
        tree = np.array([[distance, rng.uniform(-1, 1), rng.uniform(0.15, 0.5)]])
        ranges = scan_trees(HERE, tree, 0.01, rng)
        found += [error_m(trunk, tree[0]) for trunk in find_trunks(ranges, widened)]
    assert len(found) == 80
    return found


@pytest.mark.parametrize("distance", [5.0, 10.0, 15.0])
def test_middle_of_a_trunk_is_found_to_five_centimetres(distance: float) -> None:
    assert np.median(errors(distance, widened=True)) < 0.05


def test_outer_beams_as_tangents_make_trunks_too_thin() -> None:
    assert np.median(errors(15.0, widened=False)) > 1.5 * np.median(errors(15.0, widened=True))


@pytest.mark.parametrize("distance", [8.0, 30.0])
def test_best_estimate_errs_as_much_as_it_expects(distance: float) -> None:
    errors = find_at(distance, 150, np.random.default_rng(4))
    expected = np.sqrt(errors.mean_square_m2.mean())
    assert np.sqrt((errors.best_m**2).mean()) == pytest.approx(expected, rel=0.2)
    assert np.median(errors.best_m) < 0.6 * np.median(errors.widened_m)


def test_best_estimate_is_exact_where_beams_are_many_and_noise_is_small() -> None:
    tree = np.array([[3.5, 0.4, 0.45]])
    ranges = scan_trees(HERE, tree, 1e-6, np.random.default_rng(0))
    found = fit_trunk(ranges, find_trunks(ranges)[0].beams, 1e-3)
    assert found.middle_m == pytest.approx(tree[0, :2], abs=1e-3)


def test_trees_too_near_or_too_far_are_left_out() -> None:
    rng = np.random.default_rng(1)
    trees = np.array([[2.0, 0.0, 0.2], [0.0, 20.0, 0.4], [45.0, -20.0, 0.5]])
    trunks = find_trunks(scan_trees(HERE, trees, 0.0, rng))
    assert [round(trunk.range_m) for trunk in trunks] == [20]
    assert trunks[0].bearing_rad == pytest.approx(np.pi, abs=0.02)


def test_a_tree_behind_the_car_is_not_seen() -> None:
    rng = np.random.default_rng(1)
    assert (scan_trees(HERE, np.array([[-10.0, 0.0, 0.4]]), 0.0, rng) == REACH_M).all()


def test_two_trees_side_by_side_are_two() -> None:
    rng = np.random.default_rng(1)
    trees = np.array([[10.0, -0.6, 0.3], [12.0, 0.6, 0.3]])
    assert len(find_trunks(scan_trees(HERE, trees, 0.01, rng))) == 2
