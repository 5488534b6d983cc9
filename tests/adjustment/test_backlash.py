# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from hullrecon.adjustment.problem.weighting import estimate_sides


def square_wave(n, period):
    return np.where((np.arange(n) // period) % 2 == 0, 1.0, -1.0)


def test_the_side_of_the_play_is_found_in_noise():
    rng = np.random.default_rng(0)
    side = square_wave(400, 37)
    excess = np.radians(0.5 * side + 0.12 * rng.standard_normal(400) + 0.3)
    assert np.mean(estimate_sides(excess, np.ones(400)) == side) > 0.99


def test_a_single_outlier_does_not_flip_the_side():
    excess = np.radians(np.r_[np.full(50, -0.5), np.full(50, 0.5)])
    excess[20] = np.radians(0.5)
    found = estimate_sides(excess + 1e-5 * np.sin(np.arange(100)), np.ones(100))
    assert found[20] == -1
    assert (found[50:] == 1).all()


def test_without_play_the_logged_direction_is_kept():
    rng = np.random.default_rng(1)
    direction = square_wave(300, 10)
    np.testing.assert_array_equal(
        estimate_sides(np.radians(0.1) * rng.standard_normal(300), direction), direction
    )


def test_few_nodes_keep_the_logged_direction():
    direction = np.array([1.0, -1.0, 1.0])
    np.testing.assert_array_equal(
        estimate_sides(np.array([0.01, -0.01, 0.01]), direction), direction
    )
