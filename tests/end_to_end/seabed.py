# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Writes the dive package of the real stereo seabed (stereo-haltbrekken, pairs 34 to 41) in
plain-file form.

python tests/end_to_end/seabed.py DATA/stereo-haltbrekken PACKAGE. The calibration is the one that
the data's SOURCE.md derives from the images themselves: two radial cameras and the rotation and
direction between them; the baseline is the owner's word.
"""

import shutil
import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

WIDTH, HEIGHT = 1360, 1024
PAIRS = range(34, 42)
FOCAL_LEFT, RADIAL_LEFT = 1594.0, 0.125
FOCAL_RIGHT, RADIAL_RIGHT = 1565.0, 0.112
RIGHT_FROM_LEFT_DEG = (1.49, -2.70, 4.58)  # rotation vector
DIRECTION = np.array([-0.982, -0.136, -0.133])
BASELINE_M = 0.305
START_S = 1408008600  # the data have no times: one pair a second from the morning of the dive

DIVE_TOML = """\
[dive]
name = "seabed"
vessel = "seabed, Trondheimsfjord"

[logs]
files = ["logs"]

[camera.top]
calibration = "calibration/camera_top.yaml"
mount = [0, 0, 0, 0, 0, 90]

[camera.bottom]
calibration = "calibration/camera_bottom.yaml"
pose_in_top = [{pose}]
"""

CAMERA_YAML = """\
image_width: {width}
image_height: {height}
camera_name: {name}
camera_matrix: {{rows: 3, cols: 3, data: [{f}, 0, {cx}, 0, {f}, {cy}, 0, 0, 1]}}
distortion_model: plumb_bob
distortion_coefficients: {{rows: 1, cols: 5, data: [{k}, 0, 0, 0, 0]}}
rectification_matrix: {{rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}}
projection_matrix: {{rows: 3, cols: 4, data: [{f}, 0, {cx}, 0, 0, {f}, {cy}, 0, 0, 0, 1, 0]}}
"""


def write(source, package):
    """The package of the pairs in `source`; the left camera is the top one."""
    (package / "logs" / "images").mkdir(parents=True)
    (package / "calibration").mkdir()
    for name, side, focal, radial in (
        ("camera_top", "Left", FOCAL_LEFT, RADIAL_LEFT),
        ("camera_bottom", "Right", FOCAL_RIGHT, RADIAL_RIGHT),
    ):
        rows = ["t,file"]
        for number in PAIRS:
            image = f"{side}CameraRun1_{number:02d}.jpg"
            shutil.copyfile(source / image, package / "logs" / "images" / image)
            rows.append(f"{START_S + number},images/{image}")
        (package / "logs" / f"{name}.csv").write_text("\n".join(rows) + "\n")
        yaml = CAMERA_YAML.format(
            width=WIDTH,
            height=HEIGHT,
            name=name,
            f=focal,
            k=radial,
            cx=WIDTH / 2 - 0.5,
            cy=HEIGHT / 2 - 0.5,
        )
        (package / "calibration" / f"{name}.yaml").write_text(yaml)
    (package / "dive.toml").write_text(
        DIVE_TOML.format(pose=", ".join(f"{v:.9g}" for v in right_in_left()))
    )


def right_in_left():
    """T_ct_cb as dive.toml's six numbers: the inverse of the motion that takes left coordinates to
    right ones.
    """
    right_from_left = Rotation.from_rotvec(np.radians(RIGHT_FROM_LEFT_DEG))
    shift = BASELINE_M * DIRECTION / np.linalg.norm(DIRECTION)
    left_from_right = right_from_left.inv()
    return np.r_[-left_from_right.apply(shift), np.degrees(left_from_right.as_euler("xyz"))]


if __name__ == "__main__":
    write(Path(sys.argv[1]), Path(sys.argv[2]))
