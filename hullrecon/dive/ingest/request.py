# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is read of a dive package, and in which conventions: as dive.toml says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hullrecon.dive.logs.formats.stamps import LoggerClock
from hullrecon.dive.logs.streams.pressure import PressureModel
from hullrecon.dive.logs.time_window import Instant
from hullrecon.records.clock import NS
from hullrecon.typing import Array

JOINT_KEYS = {"tray": "tray.joint", "sonar_tray": "sonar.joint"}  # of dive.toml, by record


@dataclass(frozen=True)
class LogUnits:
    """The units of what was logged, as dive.toml gives them."""

    rates: str = "rad/s"
    velocity: str = "m/s"
    joints: Mapping[str, str] = field(default_factory=dict)  # by record ("tray", "sonar_tray")


@dataclass(frozen=True, kw_only=True)
class IngestRequest:
    """What ingest needs of dive.toml."""

    logs: tuple[str, ...]  # relative to the package, as all files
    clock: LoggerClock = field(default_factory=LoggerClock)  # of tables whose stamps are open
    topics: Mapping[str, str]  # by sensor
    joints: Mapping[str, str]  # name of the servo by record ("tray", "sonar_tray")
    tray_positive: str = "up"  # or "down": which way it tilts where its logged angle grows
    tray_offset_deg: float = 0.0  # added to the angles, growing up
    imu_frame: str  # "ned" or "enu"
    imu_mount_deg: tuple[float, float, float] | None = None  # roll, pitch, yaw in the vehicle
    imu_heading: str = "orientation"  # or "rates"
    pressure: PressureModel
    beams: Array | None  # (b, 3) of the DVL, for messages without
    sigma_velocity: float  # m/s, where a message has none
    calibration: Mapping[str, str]  # file by camera ("camera_top", "camera_bottom")
    added_ns: Mapping[str, int]  # by sensor, added to the stamps (positive where they are early)
    mesh: str | None  # the CAD model
    units: str  # of the CAD model
    uncalibrated: tuple[str, ...] = ()  # cameras whose calibration the logs have to hold
    start: Instant = None  # of the part of the logs that is used
    end: Instant = None
    sonar_azimuth_deg: Array | None = None  # (beams,), for logs that do not say
    log_units: LogUnits = field(default_factory=LogUnits)
    position_source: str | None = None  # "satellite", "acoustic"; None: by type and topic
    position_frame: str = "enu"  # or "ned", of local positions
    sigma_position: float = 2.0  # m, where a message has none


def whole_ns(seconds: float) -> int:
    """Convert a time offset to whole nanoseconds."""
    return round(seconds * NS)
