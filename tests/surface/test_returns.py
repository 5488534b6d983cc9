# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry import poses
from hullrecon.records.trajectory import Returns
from hullrecon.surface.returns import pose_sigma_along, return_points


def _one_return(beam: list[float], range_m: float, offset: list[float], tray_offset: float = 0.0) -> Returns:
    return Returns(
        t_ns=np.array([0]), node=np.array([1]), quaternion=np.array([[0.0, 0, 0, 1]]), translation=np.array([offset]),
        tray_offset=np.array([tray_offset]), beam=np.array([beam]), range_m=np.array([range_m]), flagged=np.array([False]),
    )  # fmt: skip


STILL = poses.identity(2)
NO_TRAY = np.zeros(2)


def test_a_beam_ends_at_its_range_along_its_direction() -> None:
    hit = return_points(_one_return([0, 0, 1], 1.5, [0, 0, 0]), STILL, NO_TRAY, np.zeros(3), poses.identity())
    assert np.allclose(hit, [[0, 0, 1.5]])


def test_the_node_the_motion_since_and_the_levers_add_up() -> None:
    nodes = poses.from_rpy([[9.0, 9, 9], [1, 2, 3]], [[0, 0, 0], [0, 0, np.pi / 2]])
    mount = poses.from_mount([0, 0, 0.08, 0, 90, 0])  # the beam's z looks forward
    hit = return_points(_one_return([0, 0, 1], 2.0, [0.1, 0, 0]), nodes, NO_TRAY, np.array([0.45, 0, 0.1]), mount)
    # forward of the vehicle, 0.1 + 0.45 + 2.0 m, turned to y; down 0.1 + 0.08
    assert np.allclose(hit, [[1.0, 2 + 2.55, 3 + 0.18]])


def test_a_tray_that_tilts_up_lifts_a_forward_beam() -> None:
    beam = _one_return([1, 0, 0], 1.0, [0, 0, 0], tray_offset=0.1)
    hit = return_points(beam, STILL, np.array([0.0, 0.2]), np.zeros(3), poses.identity())
    assert np.allclose(hit, [[np.cos(0.3), 0, -np.sin(0.3)]])  # z is down


def test_a_position_sigma_counts_along_the_normal_only() -> None:
    covariance = np.diag([0.04, 0.01, 0.09, 0, 0, 0])[None]
    sigma = pose_sigma_along(np.array([[0.0, 1, 0]]), np.array([[0, 2.0, 0]]), covariance, np.eye(3)[None])
    assert np.allclose(sigma, 0.1)


def test_an_attitude_sigma_moves_a_point_off_the_normal_by_its_lever() -> None:
    covariance = np.diag([0, 0, 0, 0, 0, 0.01**2])[None]  # heading
    ahead = pose_sigma_along(np.array([[0.0, 1, 0]]), np.array([[3.0, 0, 0]]), covariance, np.eye(3)[None])
    along_normal = pose_sigma_along(np.array([[0.0, 1, 0]]), np.array([[0, 3.0, 0]]), covariance, np.eye(3)[None])
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
        moved = poses.Poses((pose.rotation * poses.exp([[0, 0, 0, *w[3:]]]).rotation).as_quat(), pose.translation + w[:3])
        return float((moved.apply(point_v) @ normal.T).item())

    gradient = np.array([(along(h) - along(-h)) / 2e-6 for h in 1e-6 * np.eye(6)])
    assert sigma[0] == pytest.approx(np.sqrt(gradient @ root @ root.T @ gradient), rel=1e-6)
