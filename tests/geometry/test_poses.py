# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import roll_pitch_yaw

QUICK = settings(max_examples=30, deadline=None, derandomize=True)

numbers = st.floats(-10, 10, allow_nan=False)
vectors = st.lists(numbers, min_size=3, max_size=3)
# within half a turn
turns = st.lists(st.floats(-1.7, 1.7, allow_nan=False), min_size=3, max_size=3)


def assert_same(a: Poses, b: Poses) -> None:
    assert np.allclose(a.matrix(), b.matrix(), atol=1e-9)


def test_a_mount_of_90_degrees_pitch_sends_x_down_and_z_forward() -> None:
    dvl = poses.from_mount([1, 2, 3, 0, 90, 0])
    assert np.allclose(dvl.apply([[0, 0, 1]]), [[2, 2, 3]])
    assert np.allclose(dvl.apply([[1, 0, 0]]), [[1, 2, 2]])


def test_yaw_is_applied_last() -> None:
    turned = poses.from_rpy([0, 0, 0], [0, np.pi / 2, np.pi / 2])
    assert np.allclose(turned.apply([[1, 0, 0]]), [[0, 0, -1]], atol=1e-12)
    assert np.allclose(turned.apply([[0, 0, 1]]), [[0, 1, 0]], atol=1e-12)


def test_a_positive_tray_angle_tilts_the_tray_up() -> None:
    forward = poses.tray_poses([0.45, 0, 0.1], [0.2]).apply([[1.0, 0, 0]])
    assert forward[0, 2] == pytest.approx(0.1 - np.sin(0.2))  # z is down


@QUICK
@given(vectors, turns)
def test_log_and_exp_undo_each_other(shift: list[float], turn: list[float]) -> None:
    six = np.array([*shift, *turn])
    assert np.allclose(poses.exp(six).log()[0], six, atol=1e-9)


@QUICK
@given(vectors, turns, vectors)
def test_a_pose_and_its_inverse_leave_points_where_they_are(
    shift: list[float], turn: list[float], point: list[float]
) -> None:
    pose = poses.exp([[*shift, *turn]])
    assert np.allclose(pose.inverse().apply(pose.apply([point])), [point], atol=1e-9)
    assert_same(pose @ pose.inverse(), poses.identity())


@QUICK
@given(st.tuples(vectors, turns), st.tuples(vectors, turns), vectors)
def test_composition_is_one_after_the_other(
    first: tuple, second: tuple, point: list[float]
) -> None:
    a, b = (poses.exp([[*shift, *turn]]) for shift, turn in (first, second))
    assert np.allclose((a @ b).apply([point]), a.apply(b.apply([point])), atol=1e-9)
    assert_same(poses.from_matrix(a.matrix() @ b.matrix()), a @ b)


def test_pose_of_j_in_i_brings_points_to_i_not_to_j_as_printed() -> None:
    """[Ozog2016 App. A] prints X_j = R X_i + t, with R and t of j in i."""
    i_from_j = poses.from_rpy([2.0, 0, 0], [0, 0, np.pi / 2])
    in_j = np.array([[1.0, 0, 0]])  # ahead of j, which looks along y of i
    in_i = np.array([[2.0, 1, 0]])
    assert np.allclose(i_from_j.apply(in_j), in_i)
    assert np.allclose(i_from_j.inverse().apply(in_i), in_j)
    printed = i_from_j.rotation.as_matrix()[0] @ in_i[0] + i_from_j.translation[0]
    assert np.allclose(printed, [1, 2, 0])


def test_one_pose_meets_many() -> None:
    many = poses.exp(np.eye(6)[:4])
    one = poses.from_mount([1, 0, 0, 0, 0, 90])
    for k in range(4):
        assert_same((many @ one)[k], many[k] @ one)
        assert_same((one @ many)[k], one @ many[k])


def test_angles_come_back_as_roll_pitch_yaw() -> None:
    rpy = np.array([[0.1, -0.4, 2.0], [-0.2, 0.3, -3.0]])
    assert np.allclose(roll_pitch_yaw(poses.from_rpy(np.zeros((2, 3)), rpy).rotation), rpy)


def test_interpolation_goes_half_way_and_holds_the_ends() -> None:
    ends = poses.from_rpy([[0, 0, 0], [2, 4, 6]], [[0, 0, 0], [0, 0, 1.0]])
    found = poses.interpolate(np.array([100, 200]), ends, np.array([50, 150, 175, 300]))
    assert np.allclose(found.translation, [[0, 0, 0], [1, 2, 3], [1.5, 3, 4.5], [2, 4, 6]])
    assert np.allclose(roll_pitch_yaw(found.rotation)[:, 2], [0, 0.5, 0.75, 1])


def test_a_single_pose_is_held_everywhere() -> None:
    only = poses.from_mount([1, 2, 3, 0, 0, 0])
    assert np.allclose(
        poses.interpolate(np.array([5]), only, np.array([1, 9])).translation, [[1, 2, 3], [1, 2, 3]]
    )


def test_an_empty_batch_composes_to_an_empty_one() -> None:
    none = poses.identity(0)
    assert len(none @ none) == 0
    assert none.matrix().shape == (0, 4, 4)


@pytest.mark.parametrize("seed", range(4))
def test_composition_is_the_product_of_matrices(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = (poses.exp(rng.normal(0, 1, (5, 6))) for _ in range(2))
    np.testing.assert_allclose((a @ b).matrix(), a.matrix() @ b.matrix(), atol=1e-12)
    np.testing.assert_allclose(
        (a @ a.inverse()).matrix(), np.tile(np.eye(4), (5, 1, 1)), atol=1e-12
    )


def test_a_pose_of_one_broadcasts_on_either_side() -> None:
    rng = np.random.default_rng(8)
    one, many = poses.exp(rng.normal(0, 1, (1, 6))), poses.exp(rng.normal(0, 1, (4, 6)))
    np.testing.assert_allclose((one @ many).matrix(), one.matrix() @ many.matrix(), atol=1e-12)
    np.testing.assert_allclose((many @ one).matrix(), many.matrix() @ one.matrix(), atol=1e-12)


def test_rows_are_taken_by_number_mask_and_slice() -> None:
    many = poses.exp(np.random.default_rng(9).normal(0, 1, (4, 6)))
    assert len(many[2]) == 1
    np.testing.assert_array_equal(
        many[np.array([True, False, True, False])].translation, many.translation[[0, 2]]
    )
    np.testing.assert_array_equal(many[1:].quaternion, many.quaternion[1:])


def test_each_point_is_moved_by_the_pose_of_its_row() -> None:
    rng = np.random.default_rng(3)
    two, rows = poses.exp(rng.standard_normal((2, 6))), np.array([1, 0, 1])
    points = rng.standard_normal((3, 3))
    np.testing.assert_array_equal(two.apply_rows(rows, points), two[rows].apply(points))


def test_exp_gives_back_what_log_was_taken_of() -> None:
    vectors = np.random.default_rng(10).normal(0, 0.8, (20, 6))
    np.testing.assert_allclose(poses.exp(vectors).log(), vectors, atol=1e-12)


def test_vectors_are_position_and_quaternion() -> None:
    batch = poses.from_rpy([[1, 2, 3], [4, 5, 6]], [[0.1, 0.2, 0.3], [0, 0, 0]])
    assert batch.vectors()[1].tolist() == [4, 5, 6, 0, 0, 0, 1]
    np.testing.assert_array_equal(batch.vectors()[0], poses.pose_vector(batch[0]))
    assert_same(poses.pose_from_vector(batch.vectors()[0]), batch[0])


def test_six_numbers_of_a_mount_are_metres_and_degrees() -> None:
    found = poses.from_mount([1.0, 2.0, 3.0, 0.0, 0.0, 90.0])
    np.testing.assert_allclose(found.apply([[1.0, 0, 0]]), [[1.0, 3.0, 3.0]], atol=1e-12)


def test_a_tray_turns_about_y_through_its_origin() -> None:
    found = poses.tray_poses([0.5, 0.0, 0.1], [0.0, np.pi / 2])
    np.testing.assert_allclose(
        found.apply(np.tile([1.0, 0, 0], (2, 1))), [[1.5, 0, 0.1], [0.5, 0, -0.9]], atol=1e-12
    )


def test_interpolation_of_one_pose_holds_it() -> None:
    one = poses.from_mount([1.0, 2.0, 3.0, 10.0, 0.0, 0.0])
    found = poses.interpolate(np.array([5]), one, np.array([0, 5, 9]))
    np.testing.assert_array_equal(found.translation, np.tile([1.0, 2.0, 3.0], (3, 1)))


def test_up_is_told_in_any_frame_by_its_pose_in_g() -> None:
    assert np.allclose(poses.up_in(poses.from_mount([1, 2, 3, 180, 0, 40])), [0, 0, 1])
    assert np.allclose(poses.up_in(poses.from_mount([0, 0, 0, -90, 0, 0])), [0, 1, 0])
