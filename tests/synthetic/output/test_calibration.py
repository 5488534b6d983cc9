# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.dive_toml import camera_info


def test_camera_info_reads_as_ros_writes_it(dive: Dive) -> None:
    text = camera_info("camera_top", dive.rig.camera_top)
    lines = [line.strip() for line in text.splitlines()]
    assert lines[:3] == ["image_width: 240", "image_height: 192", "camera_name: camera_top"]
    rows = [
        [float(v) for v in line[7:-1].split(",")] for line in lines if line.startswith("data: [")
    ]
    np.testing.assert_allclose(rows[0], dive.rig.camera_top.matrix().ravel(), rtol=1e-8)
    np.testing.assert_allclose(rows[1], dive.rig.camera_top.distortion(), rtol=1e-8)
