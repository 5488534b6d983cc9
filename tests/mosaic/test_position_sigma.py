# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A sonar at the origin that looks along z at a point 2 m ahead; the surface's normal looks back at
it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, from_mount, identity
from hullrecon.mosaic.position_sigma import PingUncertainty, position_sigma

AHEAD = np.array([[[0.0, 0.0, 2.0]]])
BACK = np.array([[[0.0, 0.0, -1.0]]])
STILL = PingUncertainty(
    sonar=identity(),
    vehicle=identity(),
    pose_covariance=np.zeros((1, 6, 6)),
    servo_from_sonar=identity(),
    mount_sigma=np.zeros(6),
)


def test_half_a_degree_of_mount_moves_a_point_by_its_lever() -> None:
    sure = replace(STILL, mount_sigma=np.r_[0, 0, 0, np.radians([0.5, 0.5, 0.5])])
    every, mount = position_sigma(sure, AHEAD, BACK)
    assert every[0, 0] == pytest.approx(2 * np.radians(0.5))
    assert mount[0, 0] == every[0, 0]


def test_motion_along_normal_adds_no_position_sigma() -> None:
    along = replace(STILL, mount_sigma=np.array([0.0, 0.0, 0.03, 0.0, 0.0, 0.1]))
    assert position_sigma(along, AHEAD, BACK)[0][0, 0] == pytest.approx(0.0, abs=1e-12)


def test_pose_and_mount_add_up_in_squares() -> None:
    covariance = np.diag([0.03**2, 0, 0, 0, 0, 0])[None]
    both = replace(STILL, pose_covariance=covariance, mount_sigma=np.array([0.04, 0, 0, 0, 0, 0]))
    every, mount = position_sigma(both, AHEAD, BACK)
    assert every[0, 0] == pytest.approx(0.05)
    assert mount[0, 0] == pytest.approx(0.04)


def test_the_mounts_shift_is_along_the_servos_axes() -> None:
    turned = from_mount([0.0, 0.0, 0.0, 0.0, 90.0, 0.0])  # the servo's x is the sonar's z
    shifted = replace(STILL, servo_from_sonar=turned, mount_sigma=np.array([0.05, 0, 0, 0, 0, 0]))
    assert position_sigma(shifted, AHEAD, BACK)[0][0, 0] == pytest.approx(0.0, abs=1e-12)


def test_sigma_equals_the_spread_of_drawn_poses_and_mounts() -> None:
    rng = np.random.default_rng(3)
    hull_from_vehicle = Poses(
        Rotation.from_rotvec([0.2, -0.4, 0.9]).as_quat()[None], np.array([[3.0, 1.0, -2.0]])
    )
    vehicle_from_servo, servo_from_sonar = (
        from_mount([0.4, 0.0, 0.2, 5, 10, 0]),
        from_mount([0.02, 0.1, 0, 20, 70, -10]),
    )
    root = 0.01 * rng.normal(size=(6, 6))
    mount_sigma = np.array([0.01, 0.02, 0.03, 0.01, 0.02, 0.005])
    sonar = hull_from_vehicle @ vehicle_from_servo @ servo_from_sonar
    inside, normal = np.array([0.2, -0.3, 1.7]), np.array([0.6, 0.0, 0.8])
    pings = PingUncertainty(
        sonar=sonar,
        vehicle=hull_from_vehicle,
        pose_covariance=(root @ root.T)[None],
        servo_from_sonar=servo_from_sonar,
        mount_sigma=mount_sigma,
    )
    sigma = position_sigma(pings, sonar.apply(inside[None])[None], normal[None, None])[0][0, 0]
    drawn = []
    for _ in range(6000):
        pose, mount = root @ rng.normal(size=6), mount_sigma * rng.normal(size=6)
        turned = servo_from_sonar.rotation * Rotation.from_rotvec(mount[3:])
        in_servo = turned.apply(inside) + servo_from_sonar.translation + mount[:3]
        turn = hull_from_vehicle.rotation * Rotation.from_rotvec(pose[3:])
        drawn.append(
            turn.apply(vehicle_from_servo.apply(in_servo))
            + hull_from_vehicle.translation
            + pose[:3]
        )
    spread = np.cov(np.concatenate(drawn).T)
    flat = (np.eye(3) - np.outer(normal, normal)) @ spread @ (np.eye(3) - np.outer(normal, normal))
    assert sigma == pytest.approx(np.sqrt(np.linalg.eigvalsh(flat)[-1]), rel=0.04)


def test_a_point_that_was_not_met_has_no_sigma() -> None:
    assert np.isnan(position_sigma(STILL, np.full((1, 1, 3), np.nan), BACK)[0][0, 0])
