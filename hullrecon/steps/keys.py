# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Keys of dive.toml that steps declare, and are then given (`steps/chain.py`)."""

from __future__ import annotations

from hullrecon.dive.config.schema import RIG_KEYS
from hullrecon.geometry.frames import Camera

TIME_OFFSETS = {  # sections with the time_offset of each sensor
    **{name: name for name in ("dvl", "imu", "pressure", "sonar", "position")},
    "joints": "tray",
    **{camera.key: camera.section for camera in Camera},
}
INGEST_KEYS = (
    "dive.date",
    "dive.from",
    "dive.to",
    "logs",
    "topics",
    "tray.joint",
    "tray.joint_unit",
    "tray.positive",
    "tray.offset_deg",
    "sonar.joint",
    "sonar.joint_unit",
    "sonar.beam_azimuth_deg",
    "imu.frame",
    "imu.mount_deg",
    "imu.rates_unit",
    "imu.heading",
    "pressure.density",
    "pressure.gravity",
    "pressure.atmosphere",
    "pressure.z_axis",
    "pressure.unit",
    "dvl.beams",
    "dvl.beam_angle_deg",
    "dvl.beam_azimuth_deg",
    "dvl.sigma_velocity",
    "dvl.velocity_unit",
    "position.frame",
    "position.source",
    "position.sigma_m",
    *(f"{camera.section}.calibration" for camera in Camera),
    *(f"{section}.time_offset" for section in TIME_OFFSETS.values()),
    "hull.mesh",
    "hull.units",
)
# A key that a camera's section always has: its value is None if the dive has no such camera.
CARRIED = "time_offset"
WATER_KEYS = ("pressure.density", "pressure.gravity", "pressure.atmosphere")
# Keys by which sensors are compared with each other.
SENSOR_KEYS = (
    *RIG_KEYS, *WATER_KEYS, "imu.frame", "imu.mount_deg", "tray.joint_unit", "tray.positive",
    "tray.offset_deg", "tray.sigma_deg", "topics",
)  # fmt: skip
READOUT_KEYS = ("camera.top.readout_s", "camera.bottom.readout_s")
# Keys of the rig that place a sensor. A step that uses the adjusted mounts needs the tray's alone.
TRAY_KEYS = ("tray.origin",)
CAMERA_KEYS = (*TRAY_KEYS, "camera.top.mount", "camera.bottom.pose_in_top")
SONAR_KEYS = ("sonar.origin", "sonar.mount")
DVL_KEYS = (*TRAY_KEYS, "dvl.mount")
