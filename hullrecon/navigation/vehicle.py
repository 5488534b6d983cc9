# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the sensors of navigation sit and how well they are known, as numbers."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array


@dataclass(frozen=True)
class Vehicle:
    """tray_origin, pressure_origin (3,) m in vehicle; T_s_d, one pose. Sigmas, one each for the whole dive: mount (6,) m and
    rad, scale, heading drift rad/s, roll and pitch bias rad, depth bias m, tray slop rad; white: roll, pitch rad, depth m."""

    tray_origin: Array
    pressure_origin: Array
    T_s_d: Poses
    sigma_mount: Array
    sigma_scale: float
    sigma_drift: float
    sigma_tilt_bias: float
    sigma_depth_bias: float
    sigma_tray: float
    sigma_tilt: float
    sigma_depth: float
