# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The rig against plain 4 x 4 matrices written out here."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from hullrecon.dive.config.schema import RIG_KEYS
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, exp, from_mount
from hullrecon.records.solution import Mounts
from hullrecon.records.trajectory import Returns, VehiclePath
from hullrecon.rig import Rig, rig_from_settings
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
def rig() -> Rig:
    return rig_from_settings(SETTINGS, {Camera.TOP: MODEL, Camera.BOTTOM: MODEL})


def test_cameras_sit_on_the_tray(rig: Rig) -> None:
    top, bottom = (rig.poses_along(PATH, camera).matrix() for camera in Camera)
    for k in range(len(PATH)):
        expected = tray(k) @ mount("camera.top.mount")
        np.testing.assert_allclose(top[k], expected, atol=1e-12)
        np.testing.assert_allclose(
            bottom[k], expected @ mount("camera.bottom.pose_in_top"), atol=1e-12
        )


def test_beam_ends_count_motion_between_node_and_ping(rig: Rig) -> None:
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


def test_the_sonar_turns_on_its_own_servo(rig: Rig) -> None:
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


def test_a_fixed_tray_stands_at_zero_in_the_vehicle(rig: Rig) -> None:
    still = VehiclePath(poses=Poses(np.array([[0, 0, 0, 1.0]]), np.zeros((1, 3))), tray=np.zeros(1))
    np.testing.assert_allclose(
        rig.poses_along(still, "tray").matrix()[0], shift(SETTINGS["tray.origin"]), atol=1e-15
    )


def test_adjusted_mounts_replace_those_of_the_package(rig: Rig) -> None:
    dvl, camera = exp(RNG.normal(size=(1, 6))), exp(RNG.normal(size=(1, 6)))
    moved = rig.with_mounts(Mounts(tray_from_dvl=dvl, tray_from_top=camera, top_from_bottom=None))
    assert moved.tray_from_dvl is dvl
    assert moved.tray_from_top is camera
    assert moved.top_from_bottom is rig.top_from_bottom


def test_sensors_that_were_not_carried_are_told_and_not_guessed() -> None:
    bare = rig_from_settings(dict.fromkeys(RIG_KEYS))
    assert bare.cameras == ()
    with pytest.raises(InputError, match="top camera has no mount"):
        bare.poses_along(PATH, Camera.TOP)
    with pytest.raises(InputError, match="sonar has no mount"):
        bare.sonar_poses(PATH.poses, np.zeros(5))
    told = rig_from_settings(SETTINGS, {Camera.TOP: MODEL})
    assert len(told.poses_along(PATH, Camera.TOP)) == len(PATH)
    assert len(told.sonar_poses(PATH.poses, np.zeros(5))) == 5


def test_one_camera_makes_a_mono_rig() -> None:
    mono = rig_from_settings(SETTINGS | {"camera.bottom.pose_in_top": None}, {Camera.TOP: MODEL})
    assert mono.cameras == (Camera.TOP,)
    with pytest.raises(InputError, match="bottom camera has no mount"):
        mono.poses_along(PATH, Camera.BOTTOM)


def test_a_camera_knows_its_column_its_files_and_its_table() -> None:
    assert [(c.column, c.key, c.section) for c in Camera] == [
        (0, "camera_top", "camera.top"),
        (1, "camera_bottom", "camera.bottom"),
    ]


BELOW = from_mount([0.03, 0.04, 0.0, 1.0, -2.0, 3.0])


def with_cameras(top: CameraModel, bottom: CameraModel | None, below: Poses | None) -> Rig:
    rig = rig_from_settings(
        SETTINGS, {Camera.TOP: top} | ({Camera.BOTTOM: bottom} if bottom else {})
    )
    return replace(rig, top_from_bottom=below)


def test_the_baseline_is_the_distance_of_the_cameras() -> None:
    assert with_cameras(MODEL, MODEL, BELOW).baseline_m == pytest.approx(0.05)


def test_a_bottom_camera_without_a_pose_makes_no_stereo() -> None:
    assert with_cameras(MODEL, MODEL, None).stereo_mount is None
    assert with_cameras(MODEL, MODEL, BELOW).stereo_mount is BELOW


def test_a_pose_without_a_calibration_makes_no_stereo() -> None:
    rig = with_cameras(MODEL, None, BELOW)
    assert rig.stereo_mount is None
    np.testing.assert_array_equal(rig.from_top(Camera.BOTTOM), np.eye(4))
    with pytest.raises(ValueError, match="no bottom camera"):
        rig.model(Camera.BOTTOM)


def test_the_focal_length_is_the_mean_of_both_axes() -> None:
    other = replace(MODEL, fx=500.0, fy=510.0)
    rig = with_cameras(MODEL, other, BELOW)
    assert [rig.focal_px(camera) for camera in Camera] == [50.0, 505.0]


def test_points_go_from_the_top_camera_into_the_bottom_one() -> None:
    rig = with_cameras(MODEL, MODEL, BELOW)
    origin_of_bottom = np.append(BELOW.translation[0], 1.0)
    np.testing.assert_allclose(
        rig.from_top(Camera.BOTTOM) @ origin_of_bottom, [0, 0, 0, 1], atol=1e-15
    )


def test_a_rig_survives_the_way_to_another_process() -> None:
    found = pickle.loads(pickle.dumps(with_cameras(MODEL, MODEL, BELOW)))
    assert isinstance(found, Rig)
    assert found.baseline_m == pytest.approx(0.05)
    assert found.model(Camera.TOP) == MODEL
