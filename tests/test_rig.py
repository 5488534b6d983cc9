# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The rig against plain 4 x 4 matrices written out here."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, exp
from hullrecon.records.solution import Mounts
from hullrecon.records.trajectory import Returns, VehiclePath
from hullrecon.rig import RIG_KEYS, SensorRig, rig_from_settings
from hullrecon.typing import Array

SETTINGS: dict[str, object] = {
    "tray.origin": (0.45, 0.0, 0.10),
    "pressure.origin": (0.1, 0.2, 0.3),
    "dvl.mount": (0.0, 0.0, 0.08, 0.0, 90.0, 0.0),
    "camera.top.mount": (0.0, 0.0, -0.05, 90.0, 0.0, 90.0),
    "camera.bottom.pose_in_top": (0.0, 0.10, 0.0, 1.0, 0.0, 0.0),
    "sonar.origin": (0.45, 0.0, 0.25),
    "sonar.mount": (0.0, 0.0, 0.02, 0.0, 80.0, 0.0),
}
MODEL = CameraModel(width=64, height=48, fx=50.0, fy=50.0, cx=31.5, cy=23.5)
RNG = np.random.default_rng(7)
PATH = VehiclePath(poses=exp(RNG.normal(size=(5, 6))), tray=RNG.normal(scale=0.3, size=5))


def turn(axis: int, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    out = np.eye(4)
    a, b = [(1, 2), (2, 0), (0, 1)][axis]
    out[a, a] = out[b, b] = c
    out[a, b], out[b, a] = -s, s
    return out


def shift(offset: object) -> Array:
    out = np.eye(4)
    out[:3, 3] = offset
    return out


def mount(key: str) -> Array:
    x, y, z, roll, pitch, yaw = SETTINGS[key]  # type: ignore[misc]
    return (
        shift([x, y, z])
        @ turn(2, np.radians(yaw))
        @ turn(1, np.radians(pitch))
        @ turn(0, np.radians(roll))
    )


def tray(k: int) -> Array:
    return PATH.poses.matrix()[k] @ shift(SETTINGS["tray.origin"]) @ turn(1, PATH.tray[k])


@pytest.fixture
def rig() -> SensorRig:
    return rig_from_settings(SETTINGS, {Camera.TOP: MODEL, Camera.BOTTOM: MODEL})


def test_cameras_sit_on_the_tray(rig: SensorRig) -> None:
    top, bottom = (rig.camera_poses(PATH, camera).matrix() for camera in Camera)
    for k in range(len(PATH)):
        expected = tray(k) @ mount("camera.top.mount")
        np.testing.assert_allclose(top[k], expected, atol=1e-12)
        np.testing.assert_allclose(
            bottom[k], expected @ mount("camera.bottom.pose_in_top"), atol=1e-12
        )


def test_the_ends_of_beams_count_the_motion_between_node_and_ping(rig: SensorRig) -> None:
    since = exp(RNG.normal(scale=0.1, size=(3, 6)))
    returns = Returns(
        t_ns=np.zeros(3, np.int64),
        node=np.array([4, 0, 2]),
        quaternion=since.quaternion,
        translation=since.translation,
        tray_offset=np.array([0.1, 0.0, -0.2]),
        beam=np.array([[0, 0, 1.0], [0.6, 0, 0.8], [0, -0.6, 0.8]]),
        range_m=np.array([1.0, 2.0, 3.0]),
        flagged=np.zeros(3, bool),
    )
    found = rig.dvl_points(returns, PATH)
    for row in range(3):
        k = returns.node[row]
        dvl = PATH.poses.matrix()[k] @ since.matrix()[row] @ shift(SETTINGS["tray.origin"])
        dvl = dvl @ turn(1, PATH.tray[k] + returns.tray_offset[row]) @ mount("dvl.mount")
        end = dvl @ np.r_[returns.beam[row] * returns.range_m[row], 1.0]
        np.testing.assert_allclose(found.points[row], end[:3], atol=1e-12)
        np.testing.assert_allclose(
            found.directions[row], dvl[:3, :3] @ returns.beam[row], atol=1e-12
        )


def test_the_sonar_turns_on_its_own_servo(rig: SensorRig) -> None:
    angle = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    found = rig.sonar_poses(PATH.poses, angle).matrix()
    for k in range(5):
        expected = (
            PATH.poses.matrix()[k]
            @ shift(SETTINGS["sonar.origin"])
            @ turn(1, angle[k])
            @ mount("sonar.mount")
        )
        np.testing.assert_allclose(found[k], expected, atol=1e-12)


def test_a_fixed_tray_stands_at_zero_in_the_vehicle(rig: SensorRig) -> None:
    still = VehiclePath(poses=Poses(np.array([[0, 0, 0, 1.0]]), np.zeros((1, 3))), tray=np.zeros(1))
    np.testing.assert_allclose(
        rig.tray_poses(still).matrix()[0], shift(SETTINGS["tray.origin"]), atol=1e-15
    )


def test_adjusted_mounts_replace_those_of_the_package(rig: SensorRig) -> None:
    dvl, camera = exp(RNG.normal(size=(1, 6))), exp(RNG.normal(size=(1, 6)))
    moved = rig.with_mounts(Mounts(tray_from_dvl=dvl, tray_from_top=camera, top_from_bottom=None))
    assert moved.tray_from_dvl is dvl
    assert moved.tray_from_top is camera
    assert moved.top_from_bottom is rig.top_from_bottom


def test_sensors_that_were_not_carried_are_told_and_not_guessed() -> None:
    bare = rig_from_settings(dict.fromkeys(RIG_KEYS))
    assert bare.cameras == ()
    with pytest.raises(InputError, match="top camera has no mount"):
        bare.camera_poses(PATH, Camera.TOP)
    with pytest.raises(InputError, match="sonar has no mount"):
        bare.sonar_poses(PATH.poses, np.zeros(5))


def test_one_camera_makes_a_mono_rig() -> None:
    mono = rig_from_settings(SETTINGS | {"camera.bottom.pose_in_top": None}, {Camera.TOP: MODEL})
    assert mono.cameras == (Camera.TOP,)
    with pytest.raises(InputError, match="bottom camera has no mount"):
        mono.camera_poses(PATH, Camera.BOTTOM)


def test_a_camera_knows_its_column_its_files_and_its_table() -> None:
    assert [(c.column, c.key, c.section) for c in Camera] == [
        (0, "camera_top", "camera.top"),
        (1, "camera_bottom", "camera.bottom"),
    ]
