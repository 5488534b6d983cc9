# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry import poses
from hullrecon.geometry.frames import Frame
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.surface.from_returns import move_to_hull_frame, pose_sigma_along


def test_a_position_sigma_counts_along_the_normal_only() -> None:
    covariance = np.diag([0.04, 0.01, 0.09, 0, 0, 0])[None]
    sigma = pose_sigma_along(
        np.array([[0.0, 1, 0]]), np.array([[0, 2.0, 0]]), covariance, np.eye(3)[None]
    )
    assert np.allclose(sigma, 0.1)


def test_an_attitude_sigma_moves_a_point_off_the_normal_by_its_lever() -> None:
    covariance = np.diag([0, 0, 0, 0, 0, 0.01**2])[None]  # heading
    ahead = pose_sigma_along(
        np.array([[0.0, 1, 0]]), np.array([[3.0, 0, 0]]), covariance, np.eye(3)[None]
    )
    along_normal = pose_sigma_along(
        np.array([[0.0, 1, 0]]), np.array([[0, 3.0, 0]]), covariance, np.eye(3)[None]
    )
    assert np.allclose(ahead, 0.03)
    assert np.allclose(along_normal, 0.0)


def test_the_sigma_equals_numeric_propagation(rng: np.random.Generator) -> None:
    pose = poses.exp(rng.normal(size=(1, 6)))
    point_v, normal = rng.normal(size=(1, 3)), rng.normal(size=(1, 3))
    normal /= np.linalg.norm(normal)
    root = 1e-2 * rng.normal(size=(6, 6))
    lever = pose.rotation.apply(point_v)
    sigma = pose_sigma_along(normal, lever, (root @ root.T)[None], pose.rotation.as_matrix())

    def along(w: np.ndarray) -> float:
        moved = poses.Poses(
            (pose.rotation * poses.exp([[0, 0, 0, *w[3:]]]).rotation).as_quat(),
            pose.translation + w[:3],
        )
        return float((moved.apply(point_v) @ normal.T).item())

    gradient = np.array([(along(h) - along(-h)) / 2e-6 for h in 1e-6 * np.eye(6)])
    assert sigma[0] == pytest.approx(np.sqrt(gradient @ root @ root.T @ gradient), rel=1e-6)


def test_a_track_is_moved_to_the_hull_with_the_sigma_of_the_guess() -> None:
    quarter_turn = poses.from_mount([10.0, 0, 0, 0, 0, 90])  # x of M points along y of g
    track = VehicleTrack(
        t_ns=np.arange(2),
        poses=poses.from_rpy([[10.0, 3, 1], [9.0, 3, 1]], np.zeros((2, 3))),
        tray=np.zeros(2),
        covariance=np.tile(np.diag([0.04, 0.01, 0.0, 1e-4, 0, 0]), (2, 1, 1)),
        image=np.full((2, 2), -1),
        frame=Frame.GLOBAL,
    )
    moved = move_to_hull_frame(track, quarter_turn, np.array([0.3, 0.5, 0.1]))
    assert moved.frame is Frame.HULL
    assert np.allclose(moved.poses.translation, [[3, 0, 1], [3, 1, 1]])
    assert np.allclose(moved.covariance, np.diag([0.01 + 0.09, 0.04 + 0.25, 0.01, 1e-4, 0, 0]))
