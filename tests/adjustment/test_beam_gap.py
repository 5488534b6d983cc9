# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.adjustment.hull_pose.beam_gap import gap_beyond_beams

WALL_M = 1.2


def beams(factor: float, shift_m: float = 0.0):
    """Beams from places along a wall at x = WALL_M, with landmarks on it and some before it."""
    rng = np.random.default_rng(1)
    origin = np.column_stack([np.full(200, 0.0), rng.uniform(0, 5, 200), rng.uniform(0, 1, 200)])
    direction = np.column_stack([np.ones(200), rng.uniform(-0.5, 0.5, (200, 2))])
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    reach_m = WALL_M / direction[:, 0] + 0.01 * rng.standard_normal(200)
    measured_m = factor * reach_m + shift_m
    landmarks = np.column_stack(
        [np.full(4000, WALL_M), rng.uniform(-1, 6, 4000), rng.uniform(-1, 2, 4000)]
    )
    landmarks[::10, 0] -= 0.2  # an object
    return origin + measured_m[:, None] * direction, direction, measured_m, landmarks


def test_ranges_that_end_on_the_landmarks_show_no_gap():
    assert gap_beyond_beams(*beams(1.0)) is None
    assert gap_beyond_beams(*beams(1.0, shift_m=0.03)) is None


@pytest.mark.parametrize("factor", [0.85, 0.92, 1.08])
def test_ranges_that_are_too_short_or_long_show_their_share(factor):
    gap_m, share = gap_beyond_beams(*beams(factor))
    assert share == pytest.approx(1 / factor - 1, abs=0.02)
    assert gap_m == pytest.approx((1 - factor) * 1.3, abs=0.04)


def test_beams_beside_the_landmarks_tell_nothing():
    ends, directions, reach_m, landmarks = beams(0.9)
    assert gap_beyond_beams(ends, directions, reach_m, landmarks + 9.0 * np.eye(3)[2]) is None
    assert gap_beyond_beams(ends, directions, reach_m, landmarks[:0]) is None
