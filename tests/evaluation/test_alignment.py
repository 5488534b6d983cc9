# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hullrecon.evaluation.scoring.alignment import STILL, rigid, rms, rms_length, scale_after

POINTS = np.random.default_rng(3).standard_normal((20, 3))


@given(st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-10, 10)] * 3))
def test_a_rigid_motion_is_found_again(turn: tuple[float, ...], shift: tuple[float, ...]) -> None:
    rotation = Rotation.from_rotvec(turn).as_matrix()
    moved = POINTS @ rotation.T + shift
    motion = rigid(POINTS, moved)
    np.testing.assert_allclose(motion.rotation, rotation, atol=1e-9)
    np.testing.assert_allclose(motion.apply(POINTS), moved, atol=1e-9)


def test_a_mirror_image_is_not_taken_for_a_rotation() -> None:
    motion = rigid(POINTS, POINTS * [1, 1, -1])
    assert np.linalg.det(motion.rotation) == pytest.approx(1)


def test_a_straight_line_still_gives_a_rotation() -> None:
    line = np.outer(np.arange(5.0), [1.0, 0, 0])
    motion = rigid(line, np.add(line, [0, 1, 0]))
    assert np.linalg.det(motion.rotation) == pytest.approx(1)
    np.testing.assert_allclose(motion.apply(line), np.add(line, [0, 1, 0]), atol=1e-12)


def test_scale_is_that_of_true_over_ours() -> None:
    turn = Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix()
    true = 1.02 * POINTS @ turn.T + [5, 6, 7]
    assert scale_after(POINTS, true, rigid(POINTS, true)) == pytest.approx(1.02)


def test_no_motion_moves_nothing() -> None:
    np.testing.assert_array_equal(STILL.apply(POINTS), POINTS)


def test_rms_by_hand() -> None:
    assert rms(np.array([3.0, 4.0])) == pytest.approx(math.sqrt(12.5))
    assert rms_length(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 5.0]])) == pytest.approx(5)
    assert math.isnan(rms(np.zeros(0)))
