# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os

import cv2
import numpy as np
import pytest

from hullrecon.dive.config.calibration import read_camera
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel


def test_a_camera_info_file_becomes_a_camera(calibration, tmp_path):
    camera = read_camera(calibration(tmp_path / "c.yaml"))
    assert (camera.width, camera.height) == (64, 48)
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (50.0, 51.0, 31.5, 23.5)
    assert (camera.k1, camera.k2, camera.p1, camera.p2, camera.k3) == (
        -0.1,
        0.02,
        0.001,
        -0.002,
        0.003,
    )


def test_four_coefficients_or_none_are_enough(calibration, tmp_path):
    camera = read_camera(
        calibration(tmp_path / "c.yaml", distortion_coefficients="[0.1, 0.2, 0.3, 0.4]")
    )
    assert (camera.k1, camera.p2, camera.k3) == (0.1, 0.4, 0.0)
    (tmp_path / "c.yaml").write_text(
        "image_width: 4\nimage_height: 3\ncamera_matrix: [1, 0, 2, 0, 1, 1, 0, 0, 1]\n"
    )
    assert read_camera(tmp_path / "c.yaml").k1 == 0.0


def test_a_rational_model_whose_denominator_is_one_is_read(calibration, tmp_path):
    more = {
        "distortion_model": "rational_polynomial",
        "distortion_coefficients": "[0.1, 0, 0, 0, 0, 0, 0, 0]",
    }
    assert read_camera(calibration(tmp_path / "c.yaml", **more)).k1 == 0.1


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"image_width": "-4"}, "image_width is -4"),
        ({"image_height": "tall"}, "image_height is 'tall'"),
        ({"camera_matrix": "[1, 2]"}, "camera_matrix is not 9"),
        ({"camera_matrix": "[x]"}, "camera_matrix holds no numbers"),
        ({"camera_matrix": "[0, 0, 2, 0, 1, 1, 0, 0, 1]"}, "focal lengths 0 and 1"),
        ({"camera_matrix": "[.nan, 0, 2, 0, 1, 1, 0, 0, 1]"}, "finite"),
        ({"camera_matrix": "[1, 0.5, 2, 0, 1, 1, 0, 0, 1]"}, "skew"),
        ({"distortion_model": "equidistant"}, "equidistant is not read"),
        ({"camera_model": "fisheye"}, "fisheye is not read"),
        ({"distortion_coefficients": "[0, 0, 0, 0, 0, 1, 0, 0]"}, "more than five"),
        ({"distortion_coefficients": "[0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0]"}, "tilted"),
        ({"camera_matrix": "[50, 0, 0, 0, 51, 0, 31.5, 23.5, 1]"}, "is it transposed, as MATLAB"),
        ({"camera_matrix": "[0, 51, 23.5, 50, 0, 31.5, 0, 0, 1]"}, "two rows swapped"),
        ({"camera_matrix": "[50, 0, 31.5, 0.5, 51, 23.5, 0, 0, 1]"}, "skew"),
        ({"camera_matrix": "[50, 0, 31.5, 0, 51, 23.5, 0, 0, 2]"}, "last row 0 0 2, not 0 0 1"),
        ({"camera_matrix": "[50, 0, 0, 0, 51, 0, 0, 0, 1]"}, "as Metashape's does"),
        ({"camera_matrix": "[50, 0, -0.6, 0, 51, 1.2, 0, 0, 1]"}, "as Metashape's does"),
        ({"camera_matrix": "[2.8, 0, 31.5, 0, 2.8, 23.5, 0, 0, 1]"}, "are they millimetres"),
        ({"camera_matrix": "[0.78, 0, 0.5, 0, 0.8, 0.5, 0, 0, 1]"}, "shares of the image's size"),
        ({"camera_matrix": "[50, 0, 23.5, 0, 51, 31.5, 0, 0, 1]"}, "width and height of the calib"),
        ({"camera_matrix": "[50, 0, 51, 0, 31.5, 23.5, 0, 0, 1]"}, "cx = 31.5 and cy = 23.5"),
        ({"distortion_coefficients": "[0.1, 0.02, 0.3]"}, "may be k1 k2 p1 or k1 k2 k3"),
        ({"distortion_coefficients": "[-6.5, 3.5, 0.06, -0.04, 0]"}, "folds the picture"),
        ({"roi": "{x_offset: 10, width: 64}"}, "roi, 64 x 48 pixels from 10, 0 on, lies outside"),
    ],
)
def test_what_is_no_pinhole_is_refused_with_its_key(calibration, tmp_path, more, words):
    with pytest.raises(InputError, match=words.replace("[", r"\[")):
        read_camera(calibration(tmp_path / "c.yaml", **more))
    # plumb_bob, row by row, in pixels, at the size of the images
    assert read_camera(calibration(tmp_path / "c.yaml")).fx == 50.0


def test_a_key_that_lacks_is_asked_for_until_it_is_there(tmp_path):
    path = tmp_path / "c.yaml"
    size = "image_width: 64\nimage_height: 48\n"
    path.write_text(f"{size}fx: 50\nfy: 51\ncx: 31.5\ncy: 23.5\n")
    with pytest.raises(InputError, match="it has no camera_matrix") as refused:
        read_camera(path)
    assert "camera_matrix (fx 0 cx, 0 fy cy, 0 0 1)" in refused.value.remedy
    path.write_text(f"{size}camera_matrix: [50, 0, 31.5, 0, 51, 23.5, 0, 0, 1]\n")
    assert read_camera(path).cx == 31.5


@pytest.mark.parametrize("name", ["radtan", "Plumb Bob"])
def test_other_names_of_plumb_bob_are_read(calibration, tmp_path, name):
    assert read_camera(calibration(tmp_path / "c.yaml", distortion_model=name)).k1 == -0.1


@pytest.mark.parametrize(
    "matrix",
    [
        "[50, 0, 31.5, 0, 51, -22, 0, 0, 1]",  # cropped or rectified: off the middle one way
        "[50, 0, 70, 0, 51, 50, 0, 0, 1]",  # the upper left quarter of a sensor
        "[25, 0, 31.5, 0, 50, 23.5, 0, 0, 1]",  # binned across alone
        "[37.5, 0, 31.5, 0, 50, 23.5, 0, 0, 1]",  # wide pixels of video
    ],
)
def test_an_unusual_camera_is_read_as_it_is(calibration, tmp_path, matrix):
    camera = read_camera(calibration(tmp_path / "c.yaml", camera_matrix=matrix))
    numbers = [float(v) for v in matrix.strip("[]").split(",")]
    assert [camera.fx, camera.cx, camera.fy, camera.cy] == [numbers[k] for k in (0, 2, 4, 5)]


def test_a_rational_lens_becomes_the_plumb_bob_that_is_as_good(calibration, tmp_path):
    k = [0.1, 0.02, 0.001, -0.001, 0.002, 0.3, 0.03, 0.01, 1e-4, 0.0, -1e-4, 0.0]
    more = {
        "image_width": "640",
        "image_height": "512",
        "camera_matrix": "[700, 0, 320, 0, 702, 250, 0, 0, 1]",
        "distortion_model": "rational_polynomial",
        "distortion_coefficients": str(k),
    }
    camera = read_camera(calibration(tmp_path / "c.yaml", **more))
    rays = np.random.default_rng(1).uniform([-0.44, -0.34], [0.44, 0.34], (500, 2))
    matrix = np.array([[700, 0, 320], [0, 702, 250], [0, 0, 1.0]])
    points = np.c_[rays, np.ones(len(rays))]
    by_opencv = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, np.array(k))[0][:, 0]
    assert np.abs(camera.distort(rays) - by_opencv).max() < 0.05


def test_binning_and_roi_crop_and_scale_the_camera(calibration, tmp_path):
    """A point of the sensor is where REP 104 has it: cropped first, then binned."""
    whole = read_camera(calibration(tmp_path / "whole.yaml"))
    part = read_camera(
        calibration(
            tmp_path / "part.yaml",
            binning_x="2",
            binning_y="2",
            roi="{x_offset: 10, y_offset: 4, height: 40, width: 50, do_rectify: false}",
        )
    )
    assert (part.width, part.height) == (25, 20)
    rays = np.array([[0.1, -0.2], [-0.3, 0.1]])
    # the centres of the first two pixels across, 0 and 1, are binned into one at 0
    expected = (whole.distort(rays) - [10, 4] - 0.5) / 2
    assert part.distort(rays) == pytest.approx(expected)


def test_the_names_of_opencv_and_of_the_message_are_read(tmp_path):
    path = tmp_path / "opencv.yml"
    store = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    store.write("imageWidth", 64)
    store.write("imageHeight", 48)
    store.write("cameraMatrix", np.array([[50, 0, 31.5], [0, 51, 23.5], [0, 0, 1.0]]))
    store.write("distCoeffs", np.array([[-0.1, 0.02, 0.001, -0.002, 0.003]]))
    store.release()
    message = tmp_path / "message.yaml"
    message.write_text(
        "height: 48\nwidth: 64\nk: [50, 0, 31.5, 0, 51, 23.5, 0, 0, 1]\n"
        "d: [-0.1, 0.02, 0.001, -0.002, 0.003]\nbinning_x: 0\nroi: {x_offset: 0, width: 0}\n"
    )
    of_rows = tmp_path / "rows.yaml"
    of_rows.write_text(
        "image_height: 48\nimage_width: 64\n"
        "camera_matrix: [[50, 0, 31.5], [0, 51, 23.5], [0, 0, 1]]\n"
        "distortion_coefficients: [[-0.1, 0.02, 0.001, -0.002, 0.003]]\n"
    )
    for camera in (read_camera(path), read_camera(message), read_camera(of_rows)):
        assert camera == CameraModel(
            64, 48, 50.0, 51.0, 31.5, 23.5, -0.1, 0.02, 0.001, -0.002, 0.003
        )


@pytest.mark.parametrize("content", [b"a: [", b"- 1\n- 2\n", b"\xff\xfe\x00", b"", b"a: b: c"])
def test_a_file_that_is_no_table_is_refused_by_name(tmp_path, content):
    (tmp_path / "c.yaml").write_bytes(content)
    with pytest.raises(InputError, match=r"c\.yaml"):
        read_camera(tmp_path / "c.yaml")


def test_a_missing_file_is_refused_by_name(calibration, tmp_path):
    with pytest.raises(InputError, match=r"c\.yaml is missing"):
        read_camera(tmp_path / "c.yaml")
    assert read_camera(calibration(tmp_path / "there.yaml")).fx == 50.0


def test_the_calibrations_of_the_simulated_dive_are_read(data):
    camera = read_camera(data / "dive-a" / "calibration" / "camera_top.yaml")
    assert (camera.width, camera.height, camera.fx) == (640, 512, 658.7216182)


def test_a_yaml_that_is_nested_without_end_is_refused(tmp_path):
    (tmp_path / "x.yaml").write_text("[" * 3000)
    with pytest.raises(InputError, match=r"x\.yaml is not YAML"):
        read_camera(tmp_path / "x.yaml")


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"image_width": "0x" + "f" * 6000}, "image_width is a number of thousands of digits"),
        ({"image_width": "[&a [1, 2], *a]"}, "image_width is"),
        (
            {"image_width": "[" + ", ".join(["x"] * 900) + "]"},
            r"image_width is \['x', .*\.\.\., not a number",
        ),
        ({"distortion_model": "0x" + "f" * 6000}, "distortion model a number of thousands"),
        ({"distortion_model": "x" * 5000}, r"distortion model x+\.\.\. is"),
        (
            {"camera_matrix": "[1" + "0" * 400 + ", 0, 1, 0, 1, 1, 0, 0, 1]"},
            "camera_matrix holds no numbers",
        ),
        ({"image_width": "30000", "image_height": "30000"}, "30000 x 30000 pixels are too large"),
    ],
)
def test_huge_values_are_refused_in_a_short_line(tmp_path, calibration, more, message):
    with pytest.raises(InputError, match=message) as caught:
        read_camera(calibration(tmp_path / "x.yaml", **more))
    assert len(str(caught.value)) < 500
    assert "\n" not in str(caught.value)


def test_fifo_or_huge_calibration_is_refused_in_one_line(tmp_path):
    os.mkfifo(tmp_path / "fifo.yaml")
    with pytest.raises(InputError, match=r"fifo\.yaml cannot be read: it is a FIFO, not a file"):
        read_camera(tmp_path / "fifo.yaml")
    with (tmp_path / "large.yaml").open("wb") as stream:
        stream.truncate(1 << 30)
    with pytest.raises(InputError, match=r"large\.yaml cannot be read: it holds more than 4 MiB"):
        read_camera(tmp_path / "large.yaml")


def test_an_alias_bomb_as_calibration_is_refused(tmp_path):
    lines = [
        "a0: &a0 [x, x]",
        *(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]" for k in range(1, 9)),
        "image_width: *a8",
    ]
    (tmp_path / "x.yaml").write_text("\n".join(lines))
    with pytest.raises(InputError, match="is not YAML: its aliases"):
        read_camera(tmp_path / "x.yaml")


@pytest.mark.parametrize(
    ("text", "whose"),
    [
        ("<?xml version='1.0'?>\n<opencv_storage>\n", "OpenCV's XML"),
        ("<calibration>\n  <projection>frame</projection>\n  <f>412</f>\n", "Metashape's XML"),
        ("# Camera list\n1 OPENCV 400 320 412 412 200 160 0 0 0 0\n", "COLMAP's cameras.txt"),
        ('{"IntrinsicMatrix": [[412, 0, 0]], "ImageSize": [320, 400]}', "MATLAB's"),
        ("# oST version 5.0 parameters\n\n[image]\n", "ost.txt"),
        ("%YAML:1.0\n---\nM1: !!opencv-matrix\n  rows: 3\n", "OpenCV's of a stereo pair"),
        ('%YAML:1.0\nCamera.type: "PinHole"\nCamera.fx: 412.0\n', "ORB-SLAM's settings"),
        ("PK\x03\x04", "NumPy's archive"),
        ("model_type: PINHOLE\nprojection_parameters:\n   fx: 412.0\n", "VINS-Mono's"),
        ('{"polymorphic_name": "libCalib::CameraModelOpenCV"}', "calib.io's"),
        ('{"value0": {"intrinsics": [{"camera_type": "kb4"}]}}', "Basalt's"),
        ("/**:\n  ros__parameters:\n    image_width: 400\n", "a ROS 2 node's parameters"),
    ],
)
def test_calibration_of_another_program_is_named(calibration, tmp_path, text, whose):
    (tmp_path / "c.txt").write_text(text)
    with pytest.raises(InputError, match=whose) as refused:
        read_camera(tmp_path / "c.txt")
    assert str(refused.value.remedy).startswith("write a camera_info YAML")
    assert read_camera(calibration(tmp_path / "c.yaml")).fx == 50.0


@pytest.mark.parametrize("topic", ["/top/image_rect", "/zed/left/image_rect_color/compressed"])
def test_rectified_pictures_are_not_rectified_once_more(calibration, tmp_path, topic):
    path = calibration(tmp_path / "c.yaml")
    with pytest.raises(InputError, match=f"{topic} holds rectified pictures"):
        read_camera(path, topic=topic)
    assert read_camera(path, topic="/rectangle/image_raw").k1 == -0.1
    flat = calibration(tmp_path / "flat.yaml", distortion_coefficients="[0, 0, 0, 0, 0]")
    assert read_camera(flat, topic=topic).fx == 50.0
