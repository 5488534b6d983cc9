# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sigmas of navigation's sensors and their mounts, in metres and radians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import SupportsFloat, cast

import numpy as np

from hullrecon.typing import Array

HOUR_S = 3600.0
# The keys of dive.toml that the sigmas are made of.
SIGMA_KEYS = (
    "tray.sigma_deg",
    "imu.sigma_roll_pitch_deg",
    "imu.heading_drift_deg_per_hour",
    "imu.bias_sigma_deg",
    "pressure.sigma_m",
    "pressure.bias_sigma_m",
    "dvl.mount_sigma",
    "dvl.scale_sigma",
    "dvl.sigma_range",
)


@dataclass(frozen=True, kw_only=True)
class NavigationSigmas:
    """One sigma of each error of navigation's sensors.

    `tilt_rad`, `depth_m` and `range_m` are of white noise. All others are of errors that are one
    unknown each for the whole dive.
    """

    mount: Array  # (6,) of the DVL on the tray, m and rad
    scale: float  # of the DVL's velocities
    heading_drift_rad_s: float
    tilt_bias_rad: float  # of roll and pitch
    depth_bias_m: float
    tray_rad: float  # the servo's backlash
    tilt_rad: float  # of roll and pitch
    depth_m: float
    range_m: float  # of a DVL beam
    # sigma of the time offset of DVL and pressure sensor relative to the IMU, s, that remains after
    # their clocks were compared (navigation/clocks)
    dvl_late_s: float = 0.0
    pressure_late_s: float = 0.0
    # of the tray's angle at any time, in addition to `tray_rad`, where its readings are useless
    # (`doubtful_angles`)
    tray_unknown_rad: float = 0.0


def sigmas_from_settings(settings: Mapping[str, object]) -> NavigationSigmas:
    """Collect the sigmas of a dive from the values of dive.toml by dotted key (SIGMA_KEYS).

    Degrees become radians, and the drift of the heading one per second. Sigmas of time offsets and
    of a useless tray angle are not among them: they are zero until the sensors were compared.
    """

    def number(key: str) -> float:
        return float(cast(SupportsFloat, settings[key]))

    mount = np.array(settings["dvl.mount_sigma"], float)
    mount[3:] = np.radians(mount[3:])
    return NavigationSigmas(
        mount=mount,
        scale=number("dvl.scale_sigma"),
        heading_drift_rad_s=float(np.radians(number("imu.heading_drift_deg_per_hour")) / HOUR_S),
        tilt_bias_rad=float(np.radians(number("imu.bias_sigma_deg"))),
        depth_bias_m=number("pressure.bias_sigma_m"),
        tray_rad=float(np.radians(number("tray.sigma_deg"))),
        tilt_rad=float(np.radians(number("imu.sigma_roll_pitch_deg"))),
        depth_m=number("pressure.sigma_m"),
        range_m=number("dvl.sigma_range"),
    )
