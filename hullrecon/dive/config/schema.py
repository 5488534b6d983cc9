# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""dive.toml as frozen structs: what was dived and how the sensors are mounted. Steps add a section each of their own.

Units stand in each field's comment; angles are degrees where a key ends in `_deg` (docs/conventions.md). Six-number mounts are
x, y, z in metres, roll, pitch, yaw in degrees; their sigmas are metres and a small rotation vector in degrees.
"""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from msgspec import Meta, Struct, field

Positive = Annotated[float, Meta(gt=0)]
NotNegative = Annotated[float, Meta(ge=0)]
Offset = Annotated[float, Meta(ge=-4e9, le=4e9)]
BeamAngle = Annotated[float, Meta(gt=0, lt=90, description="degrees from the z axis of dvl to each beam")]
Azimuth = Annotated[float, Meta(ge=-360, le=360)]
BeamAzimuths = Annotated[
    tuple[Azimuth, ...], Meta(min_length=1, description="degrees about the z axis of dvl, from x towards y, of each beam")
]
Three = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]


class Section(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of dive.toml."""


class Dive(Section, frozen=True):
    name: Annotated[str, Meta(pattern=r"^[A-Za-z0-9_][A-Za-z0-9._-]*\Z", max_length=100)]  # also that of the run's folder
    vessel: str = ""
    date: datetime | None = None


class Logs(Section, frozen=True):
    files: Annotated[tuple[str, ...], Meta(min_length=1)]  # relative to dive.toml


class Topics(Section, frozen=True):
    """An absent topic: that sensor was not carried. With plain files the keys are ignored: the CSVs' names decide."""

    dvl: str | None = None
    imu: str | None = None
    pressure: str | None = None
    joints: str | None = None
    camera_top: str | None = None
    camera_bottom: str | None = None
    sonar: str | None = None


class Tray(Section, frozen=True):
    joint: str = "tray"  # its name in the joint messages; "": nothing turns
    origin: Three = (0.0, 0.0, 0.0)  # m, in vehicle
    sigma_deg: Positive = 0.8


class Imu(Section, frozen=True):
    frame: Literal["ned", "enu"] = "ned"
    sigma_roll_pitch_deg: Positive = 0.1
    heading_drift_deg_per_hour: NotNegative = 1.0
    bias_sigma_deg: NotNegative = 0.2


class Pressure(Section, frozen=True):
    origin: Three = (0.0, 0.0, 0.0)  # m, in vehicle
    density: Positive = 1025.0  # kg/m3
    gravity: Positive = 9.81  # m/s2
    atmosphere: NotNegative = 101325.0  # Pa
    sigma_m: Positive = 0.02  # white
    bias_sigma_m: NotNegative = 0.1


class Dvl(Section, frozen=True):
    mount: Six = (0.0, 0.0, 0.0, 0.0, 90.0, 0.0)  # T_s_d
    mount_sigma: Six = (0.01, 0.01, 0.01, 0.5, 0.5, 0.5)
    sigma_velocity: Positive = 0.003  # m/s
    sigma_range: Positive = 0.01  # m
    scale_sigma: NotNegative = 0.005
    beams: tuple[Three, ...] | None = None  # unit vectors in dvl, for messages without
    beam_angle_deg: BeamAngle | None = None
    beam_azimuth_deg: BeamAzimuths | None = None


class CameraTop(Section, frozen=True):
    calibration: str
    mount: Six = (0.0, 0.0, 0.0, 90.0, 0.0, 90.0)  # T_s_ct
    mount_sigma: Six = (0.01, 0.01, 0.01, 0.5, 0.5, 0.5)
    time_offset: Offset = 0.0  # s, added to the stamps
    sigma_px: Positive = 1.0


class CameraBottom(Section, frozen=True):
    calibration: str
    pose_in_top: Six = (0.0, 0.1, 0.0, 0.0, 0.0, 0.0)  # T_ct_cb
    pose_sigma: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # zero: calibrated, held
    time_offset: Offset = 0.0  # s


class Cameras(Section, frozen=True):
    top: CameraTop | None = None
    bottom: CameraBottom | None = None


class Sonar(Section, frozen=True):
    joint: str | None = None  # its own servo; absent: fixed
    origin: Three = (0.0, 0.0, 0.0)  # m, in vehicle
    mount: Six = (0.0, 0.0, 0.0, 0.0, 90.0, 0.0)  # frame of that servo to sonar
    mount_sigma: Six = (0.01, 0.01, 0.01, 0.5, 0.5, 0.5)
    elevation_deg: Positive = 14.0  # full aperture out of the fan plane


class Hull(Section, frozen=True):
    mesh: str
    units: Literal["m", "mm", "cm", "ft", "in"] = "m"
    pose: Six = (0.0, 0.0, 0.0, 180.0, 0.0, 0.0)  # first guess of T_g_M
    pose_sigma: Six = (1.0, 1.0, 0.3, 1.0, 1.0, 5.0)  # in M's axes, at the middle of the survey
    frame_spacing: Positive | None = None  # m
    deviation_sigma: Positive = 0.02  # m
    deviation_length: tuple[Positive, Positive] = (3.0, 1.5)  # m, along and girth


class DiveConfig(Section, frozen=True):
    """The sections that describe the vehicle and the dive. `hull` absent: no CAD model; `camera.top` absent: no camera."""

    dive: Dive
    logs: Logs
    topics: Topics = field(default_factory=Topics)
    tray: Tray = field(default_factory=Tray)
    imu: Imu = field(default_factory=Imu)
    pressure: Pressure = field(default_factory=Pressure)
    dvl: Dvl = field(default_factory=Dvl)
    camera: Cameras = field(default_factory=Cameras)
    sonar: Sonar | None = None
    hull: Hull | None = None
