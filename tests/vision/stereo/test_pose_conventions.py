# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stereo poses written by other conventions, told by matches."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.vision.stereo.pose_conventions import fitting_conventions

LENS = CameraModel(800, 600, 820.0, 822.0, 405.0, 295.0, k1=-0.06)
LENSES = (LENS, replace(LENS, fx=790.0, fy=792.0, cx=380.0))
TRUE = from_mount((0.004, 0.12, -0.01, 2.0, -3.0, 1.0))  # top_from_bottom
KEY = "camera.bottom.pose_in_top"


def matches(noise_px=0.1):
    random = np.random.default_rng(3)
    points = random.uniform([-0.4, -0.3, 1.2], [0.4, 0.3, 1.8], (400, 3))
    seen = (LENSES[0].project(points), LENSES[1].project(TRUE.inverse().apply(points)))
    return [pixels + noise_px * random.standard_normal(pixels.shape) for pixels in seen]


def with_angles(angles):
    return Poses(Rotation.from_euler("ZYX", angles).as_quat(), TRUE.translation)


ANGLES = TRUE.rotation.as_euler("ZYX")
WRITTEN = {
    f"invert {KEY}": TRUE.inverse(),
    f"turn the signs of x, y and z of {KEY}": Poses(TRUE.quaternion, -TRUE.translation),
    f"invert the rotation of {KEY} (its matrix is transposed)": Poses(
        TRUE.rotation.inv().as_quat(), TRUE.translation
    ),
    f"invert the rotation of {KEY} (its matrix is transposed), and turn the signs of x, y and z": (
        Poses(TRUE.rotation.inv().as_quat(), -TRUE.translation)
    ),
    f"exchange x and y of {KEY}": Poses(TRUE.quaternion, TRUE.translation[:, [1, 0, 2]]),
    f"exchange y and z of {KEY}": Poses(TRUE.quaternion, TRUE.translation[:, [0, 2, 1]]),
    f"give roll, pitch, yaw of {KEY} in degrees": with_angles(np.radians(ANGLES)),
    f"give the angles of {KEY} as roll, pitch, yaw": with_angles(ANGLES[:, ::-1]),
}


@pytest.mark.parametrize("remedy", WRITTEN)
def test_pose_of_another_convention_is_read_as_meant(remedy):
    (convention,) = fitting_conventions(LENSES, WRITTEN[remedy], *matches(), limit_px=0.2)
    assert convention.remedy == remedy
    assert convention.top_from_bottom.translation == pytest.approx(TRUE.translation)
    assert (convention.top_from_bottom.rotation * TRUE.rotation.inv()).magnitude() < 1e-6


def test_exchanged_cameras_are_told_by_their_lenses():
    (convention,) = fitting_conventions(LENSES, TRUE, *matches()[::-1], limit_px=0.2)
    assert convention.remedy.startswith("exchange the topics")


def test_turned_camera_is_no_other_convention():
    turned = TRUE @ from_mount((0, 0, 0, 0, 1.0, 0))
    assert fitting_conventions(LENSES, turned, *matches(), limit_px=0.2) == []
