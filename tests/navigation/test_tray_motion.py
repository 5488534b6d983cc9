# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
from vision.scene import camera_rig

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import from_rpy
from hullrecon.navigation.dead_reckoning.exposures import CameraTiming, exposures_of
from hullrecon.navigation.sensors.tray_motion import tray_motion
from hullrecon.navigation.stereo_odometry.stereo_path import no_returns
from hullrecon.records.sensors import DvlPings, ImageIndex, ImuSamples, JointSamples
from hullrecon.records.trajectory import Trajectory

T_NS = 10**15 + 100_000_000 * np.arange(50)
MODEL = CameraModel(400, 320, 350.0, 350.0, 199.0, 160.0)
RIG = replace(
    camera_rig(MODEL, tray_origin=(0.4, 0.0, 0.1)),
    tray_from_dvl=from_rpy([0.1, 0.0, 0.0], np.radians([0.0, 90.0, 0.0])),
)


def logs(rate, turn_of_tray=0.0):
    n = len(T_NS)
    dvl = DvlPings(
        t_ns=T_NS,
        velocity=np.tile([0.0, 0.3, 0.0], (n, 1)),
        velocity_sigma=np.full(n, 0.003),
        ranges=np.full((n, 4), 1.0),
        beams=np.eye(4, 3),
    )
    imu = ImuSamples(
        t_ns=T_NS,
        quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (n, 1)),
        angular_velocity=np.tile(rate, (n, 1)),
        acceleration=np.full((n, 3), np.nan),
    )
    tray = JointSamples(t_ns=T_NS, angle=turn_of_tray * 1e-9 * (T_NS - T_NS[0]))
    return dvl, imu, tray


def test_turn_moves_tray_beside_dvl_by_its_lever():
    found = tray_motion(*logs([0.0, 0.0, 0.2]), RIG, T_NS[20:21])[0]
    # the DVL, 0.1 m ahead, is moved sideways by the turn: the tray is slower by that
    np.testing.assert_allclose(found, [0.0, 0.3 - 0.2 * 0.1, 0.0, 0.0, 0.0, 0.2], atol=1e-9)


def test_tray_that_turns_in_vehicle_turns():
    found = tray_motion(*logs([0.0, 0.0, 0.0], 0.05), RIG, T_NS[20:21])[0]
    np.testing.assert_allclose(found[3:], [0.0, 0.05, 0.0], atol=1e-9)


def test_motion_where_nothing_was_read_is_unknown():
    found = tray_motion(*logs([0.0, 0.0, 0.0]), RIG, T_NS[-1:] + 3 * 10**9)
    assert np.isnan(found).all()


def index(t_ns):
    n = len(t_ns)
    zeros = np.zeros(n, np.int64)
    return ImageIndex(
        t_ns=t_ns, file=np.full(n, ""), offset=zeros, size=zeros, usable=np.ones(n, bool)
    )


def exposures(late_ns, timing=CameraTiming()):  # noqa: B008  frozen
    n = len(T_NS)
    forward = np.zeros((n, 3))
    forward[:, 0] = 0.3e-9 * (T_NS - T_NS[0])
    trajectory = Trajectory(
        t_ns=T_NS,
        quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (n, 1)),
        translation=forward,
        covariance=np.zeros((n, 6, 6)),
        tray=np.zeros(n),
        image=np.stack([np.arange(n), np.arange(n)], axis=1),
    )
    images = (index(T_NS), index(T_NS + late_ns))
    path_at = trajectory.track().path_at
    return exposures_of(trajectory, no_returns(), images, timing, path_at, RIG)


def test_images_at_their_nodes_have_no_exposures():
    assert exposures(0) is None


@pytest.mark.parametrize("stamped_s", [0.0, 0.012])
def test_delay_adds_to_what_stamps_say(stamped_s):
    found = exposures(round(1e9 * stamped_s), CameraTiming(bottom_after_stamp_s=0.02))
    np.testing.assert_allclose(found.late_s, np.tile([0.0, 0.02 + stamped_s], (50, 1)), atol=1e-9)
    np.testing.assert_allclose(found.twist[25], [0.3, 0, 0, 0, 0, 0], atol=1e-6)
