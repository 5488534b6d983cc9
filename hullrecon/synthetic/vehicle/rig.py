# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How the simulated vehicle carries its sensors: by its dive.toml, and truly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses, exp, from_mount
from hullrecon.synthetic.spec import DiveSpec

Six = tuple[float, float, float, float, float, float]

TRAY_ORIGIN = (0.45, 0.0, 0.10)
SONAR_ORIGIN = (0.45, 0.0, 0.25)
TRANSPONDER = (-0.3, 0.15, -0.25)  # of USBL, in the vehicle
DVL_MOUNT: Six = (0.0, 0.0, 0.08, 0.0, 90.0, 0.0)
CAMERA_MOUNT: Six = (0.0, 0.0, -0.05, 90.0, 0.0, 90.0)
BOTTOM_IN_TOP: Six = (0.001, 0.1, -0.001, 0.15, -0.1, 0.12)
SONAR_MOUNT: Six = (0.0, 0.0, 0.0, 0.0, 90.0, 0.0)
SONAR_ELEVATION_DEG = 14.0
LAMP_IN_TOP = np.array([0.16, -0.26, 0.02])  # metres in camera_top
BEAMS = np.array(
    [[-0.5, 0.0, 0.75**0.5], [0.5, 0.0, 0.75**0.5], [0.0, 0.5, 0.75**0.5], [0.0, -0.5, 0.75**0.5]]
)


@dataclass(frozen=True, kw_only=True)
class TrueRig:
    """The true mounts (one pose each) and cameras."""

    tray_from_dvl: Poses
    tray_from_top: Poses
    top_from_bottom: Poses
    servo_from_sonar: Poses
    camera_top: CameraModel
    camera_bottom: CameraModel | None  # None on a mono rig


def true_rig(spec: DiveSpec) -> TrueRig:
    """Draw the true mounts: nominal but for millimetres and tenths of a degree."""
    random = spec.random("rig")
    width, height = spec.cameras.image_width, spec.cameras.image_height
    f = 1.03 * width
    top = CameraModel(
        width, height, f, 1.0012 * f, 0.507 * width, 0.493 * height, -0.065, 0.035, 0.0006, -0.0004
    )
    bottom = CameraModel(
        width,
        height,
        0.993 * f,
        0.9942 * f,
        0.495 * width,
        0.509 * height,
        -0.061,
        0.03,
        -0.0003,
        0.0005,
    )
    return TrueRig(
        tray_from_dvl=from_mount(DVL_MOUNT) @ _slip(random, 0.002, 0.2),
        tray_from_top=from_mount(CAMERA_MOUNT) @ _slip(random, 0.003, 0.25),
        top_from_bottom=from_mount(BOTTOM_IN_TOP),
        servo_from_sonar=from_mount(SONAR_MOUNT),
        camera_top=top,
        camera_bottom=bottom if spec.cameras.carried == "stereo" else None,
    )


def _slip(random: np.random.Generator, shift_m: float, turn_deg: float) -> Poses:
    return exp(
        np.concatenate(
            [shift_m * random.standard_normal(3), np.radians(turn_deg) * random.standard_normal(3)]
        )
    )
