# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os

import pytest

from hullrecon.dive.config.calibration import read_camera
from hullrecon.errors import InputError


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
        ({"distortion_coefficients": "[0, 0, 0, 0, 0, 1, 0, 0]"}, "more than five"),
    ],
)
def test_what_is_no_pinhole_is_refused_with_its_key(calibration, tmp_path, more, words):
    with pytest.raises(InputError, match=words.replace("[", r"\[")):
        read_camera(calibration(tmp_path / "c.yaml", **more))


@pytest.mark.parametrize("content", [b"a: [", b"- 1\n- 2\n", b"\xff\xfe\x00", b"", b"a: b: c"])
def test_a_file_that_is_no_table_is_refused_by_name(tmp_path, content):
    (tmp_path / "c.yaml").write_bytes(content)
    with pytest.raises(InputError, match=r"c\.yaml"):
        read_camera(tmp_path / "c.yaml")


def test_a_missing_file_is_refused_by_name(tmp_path):
    with pytest.raises(InputError, match=r"c\.yaml is missing"):
        read_camera(tmp_path / "c.yaml")


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
