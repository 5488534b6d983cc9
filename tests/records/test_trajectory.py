# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tracks and paths of the vehicle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.geometry.frames import Frame
from hullrecon.geometry.meshes.mesh import face_areas
from hullrecon.geometry.poses import exp
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Trajectory, VehiclePath, VehicleTrack

QUICK = settings(max_examples=40, deadline=None, derandomize=True)
SEEDS = st.integers(0, 10**6)


def trajectory(seed: int = 0, n: int = 5) -> Trajectory:
    rng = np.random.default_rng(seed)
    poses, root = exp(rng.normal(size=(n, 6))), rng.normal(size=(n, 6, 6))
    return Trajectory(
        t_ns=np.cumsum(rng.integers(1, 10**9, n)),
        quaternion=poses.quaternion,
        translation=poses.translation,
        covariance=root @ root.transpose(0, 2, 1),
        tray=rng.normal(size=n),
        image=rng.integers(-1, 9, (n, 2)),
    )


def track(seed: int = 0, n: int = 5) -> VehicleTrack:
    return trajectory(seed, n).track()


def test_a_dead_reckoned_track_is_the_trajectory_in_the_global_frame() -> None:
    before = trajectory()
    after = before.track()
    assert after.frame is Frame.GLOBAL
    assert all(getattr(after, name) is getattr(before, name) for name in ("t_ns", "tray", "covariance", "image"))
    np.testing.assert_array_equal(after.poses.translation, before.translation)
    np.testing.assert_array_equal(before.poses().quaternion, before.quaternion)


def test_the_path_of_a_track_is_its_poses_and_its_tray() -> None:
    whole = track()
    assert whole.path.poses is whole.poses
    assert whole.path.tray is whole.tray
    assert len(whole.path) == 5


@pytest.mark.parametrize("rows", [slice(1, 4), np.array([3, 0, 3]), np.array([True, False, False, True, True])])
def test_rows_of_a_path_keep_pose_and_tray_together(rows: object) -> None:
    path = track().path
    some = path[rows]  # type: ignore[index]
    assert isinstance(some, VehiclePath)
    assert len(some) == 3
    np.testing.assert_array_equal(some.tray, path.tray[rows])  # type: ignore[index]
    np.testing.assert_array_equal(some.poses.matrix(), path.poses.matrix()[rows])  # type: ignore[index]


@QUICK
@given(SEEDS)
def test_sigma_towards_an_axis_is_that_axis_sigma(seed: int) -> None:
    found = track(seed)
    for axis in range(3):
        along = np.tile(np.eye(3)[axis], (5, 1))
        np.testing.assert_allclose(found.sigma_towards(along), found.sigma[:, axis], rtol=1e-12)


@QUICK
@given(SEEDS)
def test_sigma_towards_lies_between_the_axes_of_the_ellipsoid(seed: int) -> None:
    found = track(seed)
    directions = np.random.default_rng(seed).normal(size=(5, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    sigma, (least, _, most) = found.sigma_towards(directions), np.linalg.eigvalsh(found.covariance[:, :3, :3]).T
    assert (sigma**2 >= least * (1 - 1e-9)).all()
    assert (sigma**2 <= most * (1 + 1e-9)).all()
    np.testing.assert_allclose(found.sigma_towards(-directions), sigma)


def test_the_principal_axes_have_the_principal_sigmas() -> None:
    found = track(3)
    values, vectors = np.linalg.eigh(found.covariance[:, :3, :3])
    for k in range(3):
        np.testing.assert_allclose(found.sigma_towards(vectors[:, :, k]), np.sqrt(values[:, k]))


@QUICK
@given(SEEDS)
def test_the_vehicle_at_a_node_is_the_node(seed: int) -> None:
    found = track(seed)
    order = np.random.default_rng(seed).permutation(5)
    np.testing.assert_allclose(found.vehicle_at(found.t_ns[order]).matrix(), found.poses.matrix()[order], atol=1e-12)


def test_the_vehicle_is_held_before_the_first_node_and_after_the_last() -> None:
    found = track()
    outside = found.vehicle_at(np.array([0, found.t_ns[-1] + 10**12]))
    np.testing.assert_allclose(outside.matrix(), found.poses.matrix()[[0, -1]], atol=1e-12)


def test_half_way_between_nodes_the_vehicle_has_gone_half_the_way() -> None:
    found = replace(track(n=2), t_ns=np.array([100, 300]))
    half = found.vehicle_at(np.array([200]))
    np.testing.assert_allclose(half.translation[0], found.poses.translation.mean(axis=0))
    step = found.poses[0].rotation.inv() * half.rotation
    whole = found.poses[0].rotation.inv() * found.poses[1].rotation
    np.testing.assert_allclose((step * step).as_matrix(), whole.as_matrix(), atol=1e-12)


def test_a_surface_gives_its_mesh_alone() -> None:
    corner = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0]])
    surface = Surface(
        vertices=corner, faces=np.array([[0, 1, 2]], np.int32), deviation=np.zeros(3), sigma=np.ones(3), support=np.ones(3, int)
    )
    assert face_areas(surface.mesh()).tolist() == [3.0]
