# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Attitude and depth by other messages than Imu and FluidPressure; messages as their packages
define them.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.dive.logs.read_streams import read_streams
from hullrecon.dive.logs.readers.mcap import McapLog
from hullrecon.dive.logs.readers.protocol import Channel
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.logs.samples import DepthSample, ImuSample
from hullrecon.dive.logs.streams.imu import imu_samples
from hullrecon.dive.logs.streams.pressure import PressureModel, pressure_samples
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

T = 1_777_887_000_123_456_789
LOST = np.full(3, np.nan)
MODEL = PressureModel(1025.0, 9.81, 101325.0)
UP = PressureModel(1025.0, 9.81, 101325.0, "up")


def depth_of(sensor_type, message, model=MODEL, notes=None):
    samples = TYPES["pressure"][sensor_type](message, T, "pressure")
    return pressure_samples(samples, model, [] if notes is None else notes).depth.tolist()


def pose(kit, z=-3.5, quaternion=(0.0, 0.0, 0.0, 1.0)):
    x, y, q, w = map(float, quaternion)
    return kit.make(
        "geometry_msgs/msg/Pose",
        position=kit.make("geometry_msgs/msg/Point", x=1.0, y=2.0, z=z),
        orientation=kit.make("geometry_msgs/msg/Quaternion", x=x, y=y, z=q, w=w),
    )


def odometry(kit, **more):
    inner = kit.make(
        "geometry_msgs/msg/PoseWithCovariance", pose=pose(kit, **more), covariance=np.zeros(36)
    )
    twist = kit.make(
        "geometry_msgs/msg/Twist", linear=kit.vector(0.1, 0.2, 0.3), angular=kit.vector(0, 0, 0)
    )
    velocity = kit.make(
        "geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)
    )
    return kit.make(
        "nav_msgs/msg/Odometry", header=kit.header(T), child_frame_id="", pose=inner, twist=velocity
    )


def test_a_pose_s_z_is_up_and_so_a_depth_with_the_other_sign(kit):
    plain = kit.make("geometry_msgs/msg/PoseStamped", header=kit.header(T), pose=pose(kit))
    assert depth_of("geometry_msgs/msg/PoseStamped", plain) == [3.5]
    assert depth_of("nav_msgs/msg/Odometry", odometry(kit)) == [3.5]


def test_number_is_a_depth_and_vfr_hud_an_altitude(kit):
    assert depth_of("std_msgs/msg/Float64", kit.make("std_msgs/msg/Float64", data=2.25)) == [2.25]
    shown = {
        "airspeed": 0.0,
        "groundspeed": 0.1,
        "heading": 30,
        "throttle": 0.0,
        "altitude": -4.5,
        "climb": 0.0,
    }
    message = kit.make("mavros_msgs/msg/VfrHud", header=kit.header(T), **shown)
    assert depth_of("mavros_msgs/msg/VfrHud", message) == [4.5]


def test_sign_of_depth_can_be_given_and_wrong_sign_is_refused(kit):
    number = kit.make("std_msgs/msg/Float64", data=-2.25)
    assert depth_of("std_msgs/msg/Float64", number, UP) == [2.25]
    with pytest.raises(InputError, match=r'pressure\.z_axis = "up"'):
        depth_of("std_msgs/msg/Float64", number, MODEL)


def test_ds_depth_is_read_and_its_gap_value_is_damage():
    kind = "ds_sensor_msgs/msg/DepthPressure"
    assert depth_of(
        kind, SimpleNamespace(pressure=5.0, pressure_unit=3, tare=-9999.0, depth=12.5)
    ) == [12.5]
    with pytest.raises(DamagedError, match="without a depth"):
        depth_of(kind, SimpleNamespace(depth=-9999.0))


def test_a_depth_number_takes_the_time_of_logging(kit, tmp_path):
    entry = type(kit.dive()[0])
    log = kit.mcap(
        tmp_path / "x.mcap",
        [entry("/depth", "std_msgs/msg/Float64", T, kit.make("std_msgs/msg/Float64", data=1.5))],
    )
    found = read_streams([McapLog(log)], {"/depth": ("pressure",)}, lambda *_: None)
    assert found.samples["pressure"] == [DepthSample(T, 1.5, is_up=False)]
    assert "/depth: 1 messages have no stamp; their logging time was used" in sentences(found.notes)


def test_one_odometry_gives_velocity_attitude_and_depth(kit, tmp_path):
    entry = type(kit.dive()[0])
    log = kit.mcap(
        tmp_path / "x.mcap", [entry("/odometry", "nav_msgs/msg/Odometry", T, odometry(kit, z=-2.0))]
    )
    found = read_streams([McapLog(log)], {"/odometry": ("dvl", "imu", "pressure")}, lambda *_: None)
    assert found.samples["dvl"][0].velocity.tolist() == [0.1, 0.2, 0.3]
    assert found.samples["imu"][0].quaternion.tolist() == [0, 0, 0, 1]
    assert np.isnan(found.samples["imu"][0].rates).all()
    assert found.samples["pressure"][0].height == -2.0
    assert {c.topic: n for c, n in found.counts.items()} == {"/odometry": 1}


def test_types_of_a_log_without_definitions_are_known(kit):
    for kind in ("dvl_msgs/msg/DVL", "mavros_msgs/msg/VfrHud", "acoustic_msgs/msg/SonarImage"):
        # and not: of a type without a definition
        with pytest.raises(DamagedError, match="cannot be decoded"):
            decode(Channel("/t", kind, "cdr"), b"\0\1\0\0")


def attitude(rotation, of_dvl=False):
    return ImuSample(T, rotation.as_quat(), LOST, np.array([0.0, 0.0, -9.81]), of_dvl)


def test_imu_mount_turns_attitude_into_the_vehicles():
    truth = Rotation.from_euler("ZYX", [30, 10, 5], degrees=True)
    # yaw 90, roll 180: upside down, its x to starboard
    mount = Rotation.from_euler("ZYX", [90, 0, 180], degrees=True)
    found = imu_samples([attitude(truth * mount)], "ned", [], (180.0, 0.0, 90.0))
    assert (Rotation.from_quat(found.quaternion[0]).inv() * truth).magnitude() < 1e-9
    np.testing.assert_allclose(found.acceleration[0], mount.apply([0, 0, -9.81]), atol=1e-12)


def test_dvl_attitude_needs_its_mount_and_is_noted():
    truth = Rotation.from_euler("ZYX", [30, 10, 5], degrees=True)
    ahead = Rotation.from_euler("ZYX", [0, 90, 0], degrees=True)
    with pytest.raises(
        InputError, match="the only attitude is that of the DVL's own sensors"
    ) as caught:
        imu_samples([attitude(truth * ahead, of_dvl=True)], "ned", [])
    assert caught.value.where == "imu.mount_deg"
    notes = []
    found = imu_samples([attitude(truth * ahead, of_dvl=True)], "enu", notes, (0.0, 90.0, 0.0))
    assert (Rotation.from_quat(found.quaternion[0]).inv() * truth).magnitude() < 1e-9
    assert "compass near a steel hull" in notes[0].sentence


def test_a_depth_by_the_dvl_s_own_sensor_is_said_to_be_one():
    notes = []
    assert pressure_samples(
        [DepthSample(T, 9.0, is_up=False, of_dvl=True)], MODEL, notes
    ).depth.tolist() == [9.0]
    assert "the DVL's own sensor" in notes[-1].sentence
