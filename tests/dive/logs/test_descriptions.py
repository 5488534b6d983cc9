# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.dive.config.calibration import read_camera
from hullrecon.dive.logs.messages.descriptions import (
    calibration_yaml,
    frame_tree,
    locate_frame,
    mount_of,
)
from hullrecon.geometry.poses import Poses, from_mount


def transform(parent, child, shift=(0.0, 0.0, 0.0), rotation=None):
    x, y, z, w = (Rotation.identity() if rotation is None else rotation).as_quat()
    return SimpleNamespace(
        header=SimpleNamespace(frame_id=parent),
        child_frame_id=child,
        transform=SimpleNamespace(
            translation=SimpleNamespace(x=shift[0], y=shift[1], z=shift[2]),
            rotation=SimpleNamespace(x=x, y=y, z=z, w=w),
        ),
    )


def tree(*transforms):
    return frame_tree([SimpleNamespace(transforms=[t]) for t in transforms])


def test_transform_without_header_is_left_out():
    headless = transform("base_link", "lost")
    del headless.header.frame_id
    assert tree(headless, transform("base_link", "dvl")).keys() == {"dvl"}
    assert frame_tree([SimpleNamespace(other=1)]) == {}


def test_a_sensor_s_frame_is_turned_into_the_vehicle_s_axes():
    """base_link is forward, port, up (REP 103); the vehicle forward, starboard, down."""
    frames = tree(
        transform("base_link", "frame", (0.2, 0.1, 0.3)),
        transform("frame", "dvl", (0.05, 0.0, 0.0)),
    )
    pose = locate_frame("/dvl", frames).vehicle
    np.testing.assert_allclose(pose.translation[0], [0.25, -0.1, -0.3])
    np.testing.assert_allclose(pose.rotation.apply([0, 0, 1])[0], [0, 0, -1], atol=1e-12)


def test_forward_looking_camera_has_the_mount_of_the_template():
    # REP 103: x right, y down, z ahead
    optical = Rotation.from_matrix([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    mount = mount_of(
        locate_frame("camera", tree(transform("base_link", "camera", (0.4, 0, 0), optical))).vehicle
    )
    assert mount[:3] == [0.4, 0.0, 0.0]
    ahead = from_mount([0, 0, 0, 90.0, 0.0, 90.0]).rotation
    assert (from_mount(mount).rotation * ahead.inv()).magnitude()[0] < 1e-6


@pytest.mark.parametrize("pitch", [-90, -30, 0, 90])
@pytest.mark.parametrize("roll", [0, 25, 180])
def test_a_mount_gives_back_its_pose_at_any_pitch(roll, pitch):
    rotation = Rotation.from_euler("ZYX", [40, pitch, roll], degrees=True)
    found = from_mount(mount_of(Poses(rotation.as_quat()[None], np.array([[1.0, 2.0, 3.0]]))))
    assert (found.rotation * rotation.inv()).magnitude()[0] < 1e-5
    np.testing.assert_allclose(found.translation[0], [1, 2, 3])


def test_a_frame_without_a_way_to_the_vehicle_has_no_mount():
    assert locate_frame("dvl", tree(transform("map", "dvl"))).vehicle is None
    assert (
        locate_frame("a", tree(transform("b", "a"), transform("a", "b"))).vehicle is None
    )  # a circle
    assert locate_frame("dvl", {}).vehicle is None


def test_transforms_of_no_rotation_or_no_number_are_left_out():
    bad = transform("base_link", "dvl")
    bad.transform.rotation.w = 7.0
    assert tree(bad, transform("base_link", "imu", (np.nan, 0, 0))) == {}


def info(kit, **more):
    given = {
        "header": kit.header(0),
        "height": 480,
        "width": 640,
        "distortion_model": "plumb_bob",
        "d": np.array([-0.1, 0.02, 0, 0, 0]),
        "k": np.array([500.0, 0, 320, 0, 501, 240, 0, 0, 1]),
        "r": np.zeros(9),
        "p": np.zeros(12),
        "binning_x": 0,
        "binning_y": 0,
        "roi": kit.make(
            "sensor_msgs/msg/RegionOfInterest",
            x_offset=0,
            y_offset=0,
            height=0,
            width=0,
            do_rectify=False,
        ),
    }
    return kit.make("sensor_msgs/msg/CameraInfo", **{**given, **more})


def test_a_camera_info_becomes_the_yaml_that_is_read(kit, tmp_path):
    path = tmp_path / "camera_top.yaml"
    path.write_text(calibration_yaml(info(kit), "/camera/camera_info"))
    camera = read_camera(path)
    assert (camera.width, camera.height, camera.fx, camera.fy, camera.cx) == (
        640,
        480,
        500,
        501,
        320,
    )
    assert (camera.k1, camera.k2) == (-0.1, 0.02)
    assert "calibration in water" in path.read_text()


@pytest.mark.parametrize("more", [{"k": np.zeros(9)}, {"width": 0}, {"d": np.array([np.nan])}])
def test_a_camera_info_that_is_not_filled_in_becomes_none(kit, more):
    assert calibration_yaml(info(kit, **more), "/c") is None


def test_a_hostile_distortion_model_reaches_no_file(kit):
    assert "evil" not in calibration_yaml(info(kit, distortion_model="evil: [\n"), "/c")
