# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses
import pickle

import numpy as np
import pytest
from vision.scene import camera_rig

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_mount
from hullrecon.vision.stereo.camera_rig import CameraRig

CAMERA = CameraModel(640, 512, 600.0, 620.0, 319.5, 255.5)
BELOW = from_mount([0.03, 0.04, 0.0, 1.0, -2.0, 3.0])


def test_the_baseline_is_the_distance_of_the_cameras() -> None:
    assert camera_rig(CAMERA, CAMERA, BELOW).baseline_m == pytest.approx(0.05)


def test_a_bottom_camera_without_a_pose_makes_no_stereo() -> None:
    assert not camera_rig(CAMERA, CAMERA, None).stereo
    assert camera_rig(CAMERA, CAMERA, BELOW).stereo


def test_a_pose_without_a_calibration_makes_no_stereo() -> None:
    rig = camera_rig(CAMERA, None, BELOW)
    assert rig.top_from_bottom is None
    np.testing.assert_array_equal(rig.from_top(Camera.BOTTOM), np.eye(4))
    with pytest.raises(ValueError, match="no bottom camera"):
        rig.model(Camera.BOTTOM)


def test_the_focal_length_is_the_mean_of_both_axes() -> None:
    other = dataclasses.replace(CAMERA, fx=500.0, fy=510.0)
    rig = camera_rig(CAMERA, other, BELOW)
    assert [rig.focal_px(camera) for camera in Camera] == [610.0, 505.0]


def test_points_go_from_the_top_camera_into_the_bottom_one() -> None:
    rig = camera_rig(CAMERA, CAMERA, BELOW)
    origin_of_bottom = np.append(BELOW.translation[0], 1.0)
    np.testing.assert_allclose(
        rig.from_top(Camera.BOTTOM) @ origin_of_bottom, [0, 0, 0, 1], atol=1e-15
    )


def test_a_rig_survives_the_way_to_another_process() -> None:
    found = pickle.loads(pickle.dumps(camera_rig(CAMERA, CAMERA, BELOW)))
    assert isinstance(found, CameraRig)
    assert found.baseline_m == pytest.approx(0.05)
    assert found.model(Camera.TOP) == CAMERA
