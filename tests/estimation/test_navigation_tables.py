# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Navigation's records as the tables of a native problem."""

from dataclasses import replace

import numpy as np
import pytest
from navigation.linked_dive import STEP_SIGMA, simulate
from scipy.spatial.transform import Rotation

from hullrecon.estimation.navigation_tables import (
    attitude_table,
    gauge_prior,
    mount_prior_table,
    odometry_table,
    tray_table,
    velocity_table,
)
from hullrecon.geometry.poses import Poses, exp, from_mount, identity
from hullrecon.records.trajectory import Attitude
from hullrecon.rig import mount_prior


@pytest.fixture(scope="module")
def dive():
    return simulate(3, per_leg=6)


def test_attitude_holds_depth_roll_and_pitch_in_this_order(dive):
    table = attitude_table(dive.attitude)
    np.testing.assert_array_equal(table.node, np.arange(12))
    np.testing.assert_array_equal(table.measured[:, 0], dive.attitude.depth)
    np.testing.assert_array_equal(table.measured[:, 2], dive.attitude.pitch)


def test_the_weight_of_depths_leaves_roll_and_pitch_alone(dive):
    one, two = attitude_table(dive.attitude), attitude_table(dive.attitude, depth_weight=2.0)
    np.testing.assert_allclose(two.sigma, one.sigma * [2, 1, 1])


def test_tray_table_has_angle_and_direction_of_every_node():
    table = tray_table(np.array([0.1, 0.2]), np.array([1.0, -1.0]), 0.01, np.zeros(2))
    assert table.node.tolist() == [0, 1]
    assert table.measured.tolist() == [0.1, 0.2]
    assert table.direction.tolist() == [1.0, -1.0]
    assert table.sigma.tolist() == [0.01, 0.01]


def test_unread_tray_has_sigma_of_possible_turn():
    table = tray_table(np.array([0.1, 0.2]), np.array([1.0, -1.0]), 0.03, np.array([0.0, 0.4]))
    np.testing.assert_allclose(table.sigma, [0.03, 0.4011], atol=1e-4)


def test_odometry_is_whitened_by_its_covariance(dive):
    table = odometry_table(
        dive.odometry, np.zeros(12), dive.rig.tray_from_dvl, dive.trajectory.poses()
    )
    np.testing.assert_allclose(table.sqrt_information[4], np.diag(1 / STEP_SIGMA))
    np.testing.assert_array_equal(table.measured[:, :3], dive.odometry.translation)
    np.testing.assert_array_equal(table.measured[:, 3:], dive.odometry.quaternion)


def test_a_step_was_reckoned_with_the_mean_of_its_two_angles(dive):
    tray = np.linspace(0, 1.1, 12)
    table = odometry_table(
        dive.odometry, tray, from_mount([0, 0, 0.08, 0, 90, 0]), dive.trajectory.poses()
    )
    np.testing.assert_allclose(table.tray, 0.05 + 0.1 * np.arange(11))
    np.testing.assert_allclose(table.mount[:3], [0, 0, 0.08])


def test_a_wrong_scale_stretches_the_motion_as_the_path_has_it(dive):
    longer = Poses(dive.trajectory.quaternion, 2 * dive.trajectory.translation)
    once, twice = (
        odometry_table(dive.odometry, np.zeros(12), dive.rig.tray_from_dvl, path).by_navigation[
            :, :3, 0
        ]
        for path in (dive.trajectory.poses(), longer)
    )
    np.testing.assert_allclose(twice - once, dive.odometry.translation, atol=1e-9)


def whitened(prior, start, step):
    """Rows of a pose that is off by (translation in g, rotation vector in g)."""
    moved = Poses(
        (Rotation.from_rotvec(step[3:]) * start.rotation).as_quat(), start.translation + step[:3]
    )
    back = start.rotation.as_matrix()[0].T
    local = np.r_[
        back @ (moved.translation - start.translation)[0],
        (start.rotation.inv() * moved.rotation).as_rotvec()[0],
    ]
    return np.linalg.norm(prior.sqrt_information[0] @ local)


def attitude(nodes, depth_sigma_m=0.01, nodes_per_reading=1.0):
    """As an IMU and a pressure sensor measure it at that many nodes."""
    return Attitude(
        node=np.arange(nodes),
        depth=np.zeros(nodes),
        roll=np.zeros(nodes),
        pitch=np.zeros(nodes),
        sigma=np.tile([depth_sigma_m, 1e-3, 1e-3], (nodes, 1)),
        nodes_per_reading=np.full(nodes, nodes_per_reading),
        tray_direction=np.ones(5),
        tray_sigma=np.zeros(5),
    )


@pytest.mark.parametrize(
    "measured", ["depth and attitude", "coarse depth and attitude", "attitude", "nothing"]
)
def test_gauge_fixes_what_no_sensor_measures(measured):
    start = exp([[5.0, -3.0, 2.0, 0.3, -0.2, 1.1]])
    levels = {
        "depth and attitude": attitude(5),
        "coarse depth and attitude": attitude(5, depth_sigma_m=2.0, nodes_per_reading=25.0),
        "attitude": attitude(5, depth_sigma_m=1e3, nodes_per_reading=0.0),
        "nothing": attitude(0),
    }
    prior = gauge_prior(start, levels[measured])
    assert prior.node.tolist() == [0]
    np.testing.assert_allclose(prior.value[0, :3], start.translation[0])
    for axis in (0, 1):
        assert whitened(prior, start, 1e-4 * np.eye(6)[axis]) == pytest.approx(1, rel=1e-6)
    assert whitened(prior, start, 1e-5 * np.eye(6)[5]) == pytest.approx(1, rel=1e-4)
    depth, roll = (
        whitened(prior, start, step * np.eye(6)[axis]) for axis, step in ((2, 1e-4), (3, 1e-5))
    )
    assert depth == pytest.approx(1e-5 if "depth" in measured else 1, rel=1e-3)
    assert roll == pytest.approx(1 if measured == "nothing" else 1e-5, rel=1e-3)


def test_only_the_first_of_many_poses_is_held():
    prior = gauge_prior(exp(np.zeros((5, 6))), attitude(5))
    assert prior.value.shape == (1, 7)
    assert prior.sqrt_information.shape == (1, 6, 6)


def test_a_mount_that_is_held_or_was_not_carried_has_no_prior():
    mount, prior = identity(), mount_prior(identity(), (0.01,) * 6)
    assert mount_prior_table(None, None, None) is None
    assert mount_prior_table(mount, None, mount) is None
    assert mount_prior_table(mount, prior, None) is None
    table = mount_prior_table(mount, prior, mount)
    np.testing.assert_array_equal(table.value, [0, 0, 0, 0, 0, 0, 1])
    assert table.sqrt_information is prior


def test_where_the_dvl_was_silent_the_velocity_goes_on(dive):
    """Steps 4 to 6 were bridged; the steps beside them say how fast the vehicle came and went."""
    covariance = dive.odometry.covariance.copy()
    covariance[4:7, [0, 1, 2], [0, 1, 2]] = 0.3**2
    t_ns = (1e9 * 0.5 * np.arange(12)).astype(np.int64)
    table = velocity_table(replace(dive.odometry, covariance=covariance), t_ns)
    assert np.column_stack([table.first, table.second, table.third]).tolist() == [
        [3, 4, 5],
        [4, 5, 6],
        [5, 6, 7],
        [6, 7, 8],
    ]
    np.testing.assert_allclose(table.before, 0.5)
    np.testing.assert_allclose(table.sigma[:, :3], np.sqrt(0.01 * 1.0 / 3))
    assert (table.sigma[:, 3:] > 10).all()


def test_heard_dvl_gives_no_velocity_rows(dive):
    half_a_second = (1e9 * 0.5 * np.arange(12)).astype(np.int64)
    assert len(velocity_table(dive.odometry, half_a_second).first) == 0
    covariance = dive.odometry.covariance.copy()
    covariance[5, [0, 1, 2], [0, 1, 2]] = 5.0**2
    minute = half_a_second + 60 * 10**9 * (np.arange(12) > 5)
    assert len(velocity_table(replace(dive.odometry, covariance=covariance), minute).first) == 0
