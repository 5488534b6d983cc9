# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The calibration files of a simulated dive: one camera_info YAML a camera."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.synthetic.dive import Dive


def cameras_of(dive: Dive) -> dict[str, CameraModel]:
    """Return the cameras that the dive carries, by name."""
    if dive.spec.cameras.carried == "none":
        return {}
    bottom = dive.rig.camera_bottom
    return {
        "camera_top": dive.rig.camera_top,
        **({"camera_bottom": bottom} if bottom is not None else {}),
    }


def camera_info(name: str, camera: CameraModel) -> str:
    """Return the YAML that ROS's camera_calibration writes."""
    k = ", ".join(f"{v:.9g}" for v in camera.matrix().ravel())
    p = ", ".join(f"{v:.9g}" for v in np.hstack([camera.matrix(), np.zeros((3, 1))]).ravel())
    d = ", ".join(f"{v:.9g}" for v in camera.distortion())
    return f"""image_width: {camera.width}
image_height: {camera.height}
camera_name: {name}
camera_matrix:
  rows: 3
  cols: 3
  data: [{k}]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [{d}]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [{p}]
"""
