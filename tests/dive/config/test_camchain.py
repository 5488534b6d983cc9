# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The camchain that Kalibr writes."""

import numpy as np
import pytest

from hullrecon.dive.config.calibration import read_camera, read_pose_in_top
from hullrecon.dive.config.mounts import choose_mounts
from hullrecon.dive.config.schema import DEFAULT_MOUNTS, FROM_LOG
from hullrecon.dive.logs.fixed_frames import RIG, FixedSensor
from hullrecon.errors import InputError
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_mount

POSE_IN_TOP = (0.001, 0.1, -0.001, 0.15, -0.1, 0.12)
SIDES = {"camera_top": "/upper/image_raw/compressed", "camera_bottom": "/lower/image_raw"}


def camchain(path, first="/upper/image_raw", second="/lower/image_raw", **more):
    """Write a chain from the camera named first to the second, where the upper one is named."""
    upper_first = "upper" in first
    pose = from_mount(POSE_IN_TOP)
    step = (pose.inverse() if upper_first else pose).rotation.as_matrix()[0]
    shift = (pose.inverse() if upper_first else pose).translation[0]
    rows = np.vstack([np.c_[step, shift], [0, 0, 0, 1]]).tolist()
    entries = {"camera_model": "pinhole", "distortion_model": "radtan", **more}
    lines = []
    for k, topic in enumerate((first, second)):
        lines += [f"cam{k}:", f"  rostopic: {topic}", "  resolution: [640, 512]"]
        lines += [f"  intrinsics: [{500 + k}.0, 502.0, 320.0, 250.0]"]
        lines += [f"  {name}: {value}" for name, value in entries.items()]
        lines += ["  distortion_coeffs: [-0.1, 0.02, 0.001, -0.002]"]
    path.write_text("\n".join([*lines, "  T_cn_cnm1:", *(f"  - {row}" for row in rows), ""]))
    return path


def test_each_camera_of_a_camchain_is_read(tmp_path):
    path = camchain(tmp_path / "camchain.yaml")
    top, bottom = (read_camera(path, camera) for camera in Camera)
    assert (top.width, top.height, top.fx, bottom.fx) == (640, 512, 500.0, 501.0)
    assert (top.fy, top.cx, top.cy) == (502.0, 320.0, 250.0)
    assert top.distortion().tolist() == [-0.1, 0.02, 0.001, -0.002, 0.0]


def test_the_rostopic_says_which_camera_is_the_upper_one(tmp_path):
    path = camchain(tmp_path / "camchain.yaml", first="/lower/image_raw", second="/upper/image_raw")
    assert read_camera(path, Camera.TOP, SIDES["camera_top"]).fx == 501.0
    assert read_pose_in_top(path, SIDES) == pytest.approx(POSE_IN_TOP, abs=1e-6)


def test_the_chains_pose_is_that_of_the_lower_camera_in_the_upper(tmp_path):
    pose = read_pose_in_top(camchain(tmp_path / "camchain.yaml"), {})
    assert pose == pytest.approx(POSE_IN_TOP, abs=1e-6)
    left = dict.fromkeys(DEFAULT_MOUNTS, FROM_LOG)
    mounts = choose_mounts(left, {RIG: FixedSensor(frame="camchain.yaml", pose=pose)})
    assert mounts["camera.bottom.pose_in_top"].value == pose
    assert "camchain.yaml" in mounts["camera.bottom.pose_in_top"].source


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"distortion_model": "equidistant"}, "cam0 has the distortion model 'equidistant'"),
        ({"camera_model": "omni"}, "cam0 has the camera model 'omni'"),
    ],
)
def test_other_models_of_a_camchain_are_refused_by_their_name(tmp_path, more, words):
    path = camchain(tmp_path / "camchain.yaml", **more)
    with pytest.raises(InputError, match=words) as caught:
        read_camera(path)
    assert caught.value.remedy == "calibrate with pinhole-radtan"
    assert read_camera(camchain(path)).fx > 0
