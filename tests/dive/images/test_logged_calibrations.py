# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Calibrations that dive.toml leaves to the CameraInfo of the log."""

import numpy as np
import pytest

from hullrecon.dive.check.package_check import check_package
from hullrecon.dive.config.calibration import read_camera
from hullrecon.dive.config.load import load_config
from hullrecon.findings.finding import sentences
from hullrecon.steps.ingest import ingest_settings, request_of

KIND = "sensor_msgs/msg/CameraInfo"
LENS = (-0.1, 0.02, 0.001, -0.002, 0.003)
GIVEN = "camera.top.calibration=calibration/camera_top.yaml"


def info(kit, ros=2, k=(50.0, 0, 31.5, 0, 51.0, 23.5, 0, 0, 1), d=LENS, **more):
    upper = {
        name.upper() if ros == 1 else name: value
        for name, value in {
            "d": np.array(d, float),
            "k": np.array(k, float),
            "r": np.zeros(9),
            "p": np.zeros(12),
        }.items()
    }
    roi = kit.make(
        "sensor_msgs/msg/RegionOfInterest",
        ros,
        x_offset=0,
        y_offset=0,
        height=0,
        width=0,
        do_rectify=False,
    )
    given = {
        "height": 48,
        "width": 64,
        "distortion_model": "plumb_bob",
        "binning_x": 0,
        "binning_y": 0,
        "roi": roi,
    }
    return kit.make(KIND, ros, header=kit.header(0, ros), **{**given, **upper, **more})


def entries_of(kit, infos, ros=2):
    """The kit's dive with CameraInfo messages (topic, seconds, message) among the others, in order
    of time.
    """
    dive = kit.dive(ros)
    more = [
        type(dive[0])(topic, KIND, kit.start_ns + round(s * 1e9), message)
        for topic, s, message in infos
    ]
    return sorted([*dive, *more], key=lambda e: e.t_ns)


def check(package, *overrides):
    path = package / "dive.toml"
    path.write_text(path.read_text().replace('calibration = "calibration/camera_top.yaml"\n', ""))
    loaded = load_config(package, {}, overrides)
    return check_package(
        loaded,
        request_of(ingest_settings(loaded)),
    )


@pytest.mark.parametrize("form", ["mcap", "bag", "ros2"])
def test_the_camera_info_beside_the_images_is_the_calibration(package, kit, form):
    """As the YAML with the same numbers, though it comes after the first images, in each form of
    log.
    """
    ros = 1 if form == "bag" else 2
    infos = [("/camera_info", s, info(kit, ros)) for s in (1.2, 2.2)]
    entries = entries_of(kit, [*infos, ("/other/camera_info", 0.0, info(kit, ros, width=7))], ros)
    file = {"mcap": "logs/dive.mcap", "bag": "logs/dive.bag", "ros2": "logs/ros2"}[form]
    {"mcap": kit.mcap, "bag": kit.bag1, "ros2": kit.ros2}[form](package / file, entries)
    found = check(package, f'logs.files=["{file}"]')
    assert found.run_is_possible
    assert found.found.cameras["camera_top"] == read_camera(
        package / "calibration" / "camera_top.yaml"
    )
    assert len(found.found.images["camera_top"].t_ns) == 8
    assert (
        "note: camera_top: its calibration is the CameraInfo on /camera_info; see that it is that "
        "of the camera in water" in (found.lines())
    )
    assert not any(
        "/camera_info" in line for line in sentences(found.found.unused) if "/other" not in line
    )


def test_a_calibration_of_dive_toml_goes_before_that_of_the_log(package, kit):
    kit.mcap(
        package / "logs" / "dive.mcap",
        entries_of(kit, [("/camera_info", 0.0, info(kit, d=np.zeros(5)))]),
    )
    found = check(package, "camera.top.calibration=calibration/camera_top.yaml")
    assert found.found.cameras["camera_top"].k1 == -0.1


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"k": np.zeros(9)}, "the CameraInfo on /camera_info has no calibration: K is zero"),
        ({"width": 0}, "image_width is 0, not a number of pixels"),
        ({"d": [np.nan]}, "distortion_coefficients is not some finite numbers"),
        (
            {"distortion_model": "equidistant", "d": [0.1, 0, 0, 0]},
            "the distortion model equidistant is not read",
        ),
        (
            {"distortion_model": "rational_polynomial", "d": [0, 0, 0, 0, 0, 1, 0, 0]},
            "more than five distortion coefficients",
        ),
        (
            {"width": 128},
            "the images of camera_top have 64 x 48 pixels, its calibration is for 128 x 48",
        ),
    ],
)
def test_camera_info_without_calibration_is_refused_with_reason(package, kit, more, words):
    kit.mcap(
        package / "logs" / "dive.mcap", entries_of(kit, [("/camera_info", 0.0, info(kit, **more))])
    )
    (line,) = sentences(check(package).unusable)
    assert words in line
    assert check(package, GIVEN).unusable == []


def test_a_rational_model_whose_denominator_is_one_is_read(package, kit):
    more = {"distortion_model": "rational_polynomial", "d": [0.1, 0, 0, 0, 0, 0, 0, 0]}
    kit.mcap(
        package / "logs" / "dive.mcap", entries_of(kit, [("/camera_info", 0.0, info(kit, **more))])
    )
    assert check(package).found.cameras["camera_top"].k1 == 0.1


def test_a_camera_info_of_the_whole_sensor_fits_binned_and_cropped_images(package, kit):
    region = {"x_offset": 20, "y_offset": 10, "width": 128, "height": 96, "do_rectify": False}
    more = {
        "width": 200,
        "height": 150,
        "k": (100.0, 0, 83.5, 0, 102.0, 57.5, 0, 0, 1),
        "binning_x": 2,
        "binning_y": 2,
        "roi": kit.make("sensor_msgs/msg/RegionOfInterest", **region),
    }
    kit.mcap(
        package / "logs" / "dive.mcap", entries_of(kit, [("/camera_info", 0.0, info(kit, **more))])
    )
    camera = check(package).found.cameras["camera_top"]
    assert (camera.width, camera.height, camera.fx, camera.fy) == (64, 48, 50.0, 51.0)
    assert (camera.cx, camera.cy) == (31.5, 23.5)


def test_binning_beside_a_calibration_of_the_images_size_changes_nothing(package, kit):
    more = {"binning_x": 2, "binning_y": 2}
    kit.mcap(
        package / "logs" / "dive.mcap", entries_of(kit, [("/camera_info", 0.0, info(kit, **more))])
    )
    found = check(package)
    camera = found.found.cameras["camera_top"]
    assert (camera.width, camera.fx, camera.cx) == (64, 50.0, 31.5)
    assert not found.unusable


def test_a_region_that_contradicts_its_calibrations_size_is_refused(package, kit):
    region = {"x_offset": 20, "y_offset": 10, "width": 64, "height": 48, "do_rectify": False}
    more = {"roi": kit.make("sensor_msgs/msg/RegionOfInterest", **region)}
    kit.mcap(
        package / "logs" / "dive.mcap", entries_of(kit, [("/camera_info", 0.0, info(kit, **more))])
    )
    (line,) = sentences(check(package).unusable)
    assert "roi, 64 x 48 pixels from 20, 10 on, lies outside of the 64 x 48 pixels" in line
    assert check(package, GIVEN).unusable == []


def test_a_calibration_that_changes_within_the_log_is_refused(package, kit):
    infos = [
        ("/camera_info", s, info(kit, d=(0.1 if s > 2 else 0.2, 0, 0, 0, 0)))
        for s in (0.0, 1.0, 3.0)
    ]
    kit.mcap(package / "logs" / "dive.mcap", entries_of(kit, infos))
    (line,) = sentences(check(package).unusable)
    assert line.startswith(
        "the CameraInfo on /camera_info changes within the log (camera.top.calibration)"
    )
    assert check(package, GIVEN).unusable == []


def test_two_calibrations_beside_one_camera_are_refused(package, kit):
    infos = [
        ("/camera_info", 0.0, info(kit)),
        ("/other_info", 0.5, info(kit, k=(60.0, 0, 31.5, 0, 51.0, 23.5, 0, 0, 1))),
    ]
    kit.mcap(package / "logs" / "dive.mcap", entries_of(kit, infos))
    assert "is another than that on /other_info" in sentences(check(package).unusable)[0]


def test_two_cameras_in_one_namespace_cannot_share_a_calibration(package, kit):
    entries = entries_of(kit, [("/camera_info", 0.0, info(kit))])
    below = [type(e)("/cam2", e.kind, e.t_ns, e.message) for e in entries if e.topic == "/cam"]
    kit.mcap(package / "logs" / "dive.mcap", [*entries, *below])
    found = check(package, "topics.camera_bottom=/cam2", "camera.bottom.time_offset=0")
    assert sentences(found.unusable)[0].startswith(
        "/camera_info lies beside the images of camera_top and camera_bottom"
    )
    other = GIVEN.replace("top.calibration", "bottom.calibration")
    assert check(package, "topics.camera_bottom=/cam2", GIVEN, other).unusable == []


def test_rectified_images_are_refused_with_raw_camera_info(package, kit, calibration):
    entries = entries_of(kit, [("/c/camera_info", 0.0, info(kit))])
    renamed = [
        type(e)("/c/image_rect", e.kind, e.t_ns, e.message) if e.topic == "/cam" else e
        for e in entries
    ]
    kit.mcap(package / "logs" / "dive.mcap", renamed)
    assert (
        "/c/image_rect is rectified"
        in sentences(check(package, "topics.camera_top=/c/image_rect").unusable)[0]
    )
    calibration(package / "calibration" / "rectified.yaml", distortion_coefficients="[0, 0, 0, 0]")
    rectified = "camera.top.calibration=calibration/rectified.yaml"
    assert check(package, "topics.camera_top=/c/image_rect", rectified).unusable == []


def test_where_neither_has_it_the_calibration_is_missing(package):
    found = check(package)
    (line,) = sentences(found.unusable)
    assert line.startswith(
        "camera.top.calibration is missing, and no CameraInfo was logged beside /cam (dive.toml)"
    )
    assert not found.run_is_possible


def test_of_a_missing_log_nothing_is_said_of_its_calibrations(package):
    found = check(package, 'logs.files=["logs/dive.mcap","logs/none.mcap"]')
    (line,) = sentences(found.unusable)
    assert line.startswith("the log none.mcap is missing")


def test_images_of_which_none_can_be_read_are_refused_with_why(package, kit):
    picture = kit.make(
        "sensor_msgs/msg/Image",
        header=kit.header(0),
        height=48,
        width=64,
        encoding="nv21",
        is_bigendian=0,
        step=64,
        data=np.zeros(64 * 72, np.uint8),
    )
    entries = [
        type(e)("/cam", "sensor_msgs/msg/Image", e.t_ns, picture) if e.topic == "/cam" else e
        for e in entries_of(kit, [("/camera_info", 0.0, info(kit))])
    ]
    kit.mcap(package / "logs" / "dive.mcap", entries)
    found = check(package)
    assert "the encoding 'nv21', which is not read (/cam)" in found.verdict
    assert not found.run_is_possible
