# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import cross_matrix, roll_pitch_yaw

QUICK = settings(max_examples=60, deadline=None, derandomize=True)

numbers = st.floats(-10, 10, allow_nan=False)
vectors = st.lists(numbers, min_size=3, max_size=3)
turns = st.lists(st.floats(-1.7, 1.7, allow_nan=False), min_size=3, max_size=3)  # within half a turn


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
def test_a_pose_and_its_inverse_leave_points_where_they_are(shift: list[float], turn: list[float], point: list[float]) -> None:
    pose = poses.exp([[*shift, *turn]])
    assert np.allclose(pose.inverse().apply(pose.apply([point])), [point], atol=1e-9)
    assert_same(pose @ pose.inverse(), poses.identity())


@QUICK
@given(st.tuples(vectors, turns), st.tuples(vectors, turns), vectors)
def test_composition_is_one_after_the_other(first: tuple, second: tuple, point: list[float]) -> None:
    a, b = (poses.exp([[*shift, *turn]]) for shift, turn in (first, second))
    assert np.allclose((a @ b).apply([point]), a.apply(b.apply([point])), atol=1e-9)
    assert_same(poses.from_matrix(a.matrix() @ b.matrix()), a @ b)


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
    assert np.allclose(poses.interpolate(np.array([5]), only, np.array([1, 9])).translation, [[1, 2, 3], [1, 2, 3]])


SEEDS = st.integers(0, 10**6)


def some(seed: int, n: int) -> Poses:
    return poses.exp(np.random.default_rng(seed).normal(size=(n, 6)))


@QUICK
@given(SEEDS)
def test_composition_is_associative_and_its_inverse_runs_backwards(seed: int) -> None:
    a, b, c = some(seed, 4), some(seed + 1, 4), some(seed + 2, 4)
    assert_same((a @ b) @ c, a @ (b @ c))
    assert_same((a @ b).inverse(), b.inverse() @ a.inverse())
    assert_same(a @ poses.identity(4), a)
    assert_same(poses.identity() @ a, a)


@QUICK
@given(SEEDS)
def test_poses_are_the_matrices_that_move_points(seed: int) -> None:
    a, points = some(seed, 5), np.random.default_rng(seed).normal(size=(5, 3))
    moved = np.einsum("nij,nj->ni", a.matrix(), np.hstack([points, np.ones((5, 1))]))
    np.testing.assert_allclose(a.apply(points), moved[:, :3], atol=1e-12)
    assert_same(poses.from_matrix(a.matrix()), a)
    np.testing.assert_allclose(a.inverse().matrix(), np.linalg.inv(a.matrix()), atol=1e-9)
    one = a[0].apply(points)  # one pose for all points
    np.testing.assert_allclose(one, points @ a.matrix()[0, :3, :3].T + a.translation[0], atol=1e-12)


@QUICK
@given(SEEDS, st.lists(st.floats(-1e-5, 1e-5), min_size=3, max_size=3))
def test_a_small_rotation_is_perturbed_on_the_right(seed: int, w: list[float]) -> None:
    turned = some(seed, 1) @ poses.exp([[0, 0, 0, *w]])
    expected = some(seed, 1).matrix()[0, :3, :3] @ (np.eye(3) + cross_matrix(np.array(w)))
    np.testing.assert_allclose(turned.matrix()[0, :3, :3], expected, atol=1e-9)
    np.testing.assert_array_equal(turned.translation, some(seed, 1).translation)


@pytest.mark.parametrize("index", [2, -1, slice(1, 4), np.array([3, 0, 0]), np.array([True, False, True, False, False])])
def test_rows_are_those_of_the_matrices(index: object) -> None:
    batch = some(8, 5)
    np.testing.assert_array_equal(batch[index].matrix(), batch.matrix()[index].reshape(-1, 4, 4))  # type: ignore[index]


def test_a_pose_vector_is_place_and_quaternion() -> None:
    only = some(9, 1)
    assert_same(poses.of_seven(np.r_[only.translation[0], only.quaternion[0]]), only)


@QUICK
@given(SEEDS)
def test_interpolation_passes_through_the_nodes_and_turns_evenly_between(seed: int) -> None:
    rng = np.random.default_rng(seed)
    nodes, t = some(seed, 4), np.cumsum(rng.integers(10, 1000, 4))
    np.testing.assert_allclose(poses.interpolate(t, nodes, t).matrix(), nodes.matrix(), atol=1e-12)
    wanted = np.linspace(t[1], t[2], 5)
    found = poses.interpolate(t, nodes, wanted.astype(np.int64))
    share = (wanted.astype(np.int64) - t[1]) / (t[2] - t[1])
    np.testing.assert_allclose(
        found.translation, nodes.translation[1] + share[:, None] * (nodes.translation[2] - nodes.translation[1]), atol=1e-9
    )
    whole = (nodes[1].rotation.inv() * nodes[2].rotation).magnitude()[0]
    np.testing.assert_allclose((nodes[1].rotation.inv() * found.rotation).magnitude(), share * whole, atol=1e-7)


@QUICK
@given(SEEDS)
def test_interpolation_does_not_depend_on_the_frame_of_the_poses(seed: int) -> None:
    nodes, other, t = some(seed, 3), some(seed + 5, 1), np.array([0, 100, 250])
    wanted = np.random.default_rng(seed).integers(-50, 300, 7)
    assert_same(poses.interpolate(t, other @ nodes, wanted), other @ poses.interpolate(t, nodes, wanted))


def test_two_nodes_at_one_instant_do_not_divide_by_nothing() -> None:
    nodes = some(3, 3)
    found = poses.interpolate(np.array([0, 5, 5]), nodes, np.array([5]))
    assert np.isfinite(found.matrix()).all()
