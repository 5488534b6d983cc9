# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""dive.toml as frozen structs: what was dived and how the sensors are mounted.

Steps add a section each of their own. Every key has a description, which begins with its unit where
it has one. Angles are degrees where a key ends in `_deg` (docs/conventions.md). Six-number mounts
are x, y, z in metres, roll, pitch, yaw in degrees. Their sigmas are metres and a small rotation
vector in degrees.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from types import MappingProxyType
from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from hullrecon.dive.config.config_errors import NAME, ONE_LINE

Positive = Annotated[float, Meta(gt=0)]
NotNegative = Annotated[float, Meta(ge=0)]
Offset = Annotated[float, Meta(ge=-4e9, le=4e9)]
BeamAngle = Annotated[
    float, Meta(gt=0, lt=90, description="deg, from the z axis of dvl to each beam")
]
Azimuth = Annotated[float, Meta(ge=-360, le=360)]
BeamAzimuths = Annotated[
    tuple[Azimuth, ...],
    Meta(min_length=1, description="deg, of each beam about the z axis of dvl, from x towards y"),
]
Three = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]
FROM_LOG: Literal["tf_static"] = "tf_static"  # of a mount: to be taken from the log (mounts.py)
MountNumbers = Six | Literal["tf_static"]
Origin = Annotated[
    Three | Literal["tf_static"],
    Meta(description="m, in the vehicle's frame; by the log's tf_static, else 0, 0, 0"),
]
MountSigma = Annotated[
    Six,
    Meta(
        description="m and deg, sigma of x, y, z and of a small rotation vector, in the parent "
        "frame"
    ),
]
FileName = Annotated[str, Meta(pattern=ONE_LINE, min_length=1, max_length=1000)]
Calibration = Annotated[
    FileName | None,
    Meta(
        description="camera_info YAML of the camera, relative to dive.toml; absent: the CameraInfo "
        "that was logged beside its images"
    ),
]
TimeOffset = Annotated[Offset, Meta(description="s, added to the stamps")]
Readout = Annotated[
    float,
    Meta(
        ge=0.0, le=0.2, description="s, from the first row of an image, at its stamp, to the last"
    ),
]
JointUnit = Annotated[Literal["rad", "deg"], Meta(description="of the logged angles")]
CalibrationSigma = Annotated[
    float,
    Meta(
        ge=0,
        le=10,
        description="px, rms over the image of what the calibration leaves of the lens's smooth "
        "displacement of pixels; 0: nothing",
    ),
]
TopicName = Annotated[str, Meta(pattern=ONE_LINE, max_length=1000)]
TimeZone = Annotated[str, Meta(pattern=r"^(UTC|[+-](0[0-9]|1[0-4]):(00|15|30|45))$")]
Hour = Annotated[datetime, Meta(tz=True)]
WindowLimit = Annotated[
    Hour | Annotated[float, Meta(ge=0, le=4e9)] | None,
    Meta(
        description="s, from the first message of the logs, or a date and time with its zone: what "
        "is used begins or ends there"
    ),
]
Topic = Annotated[TopicName | None, Meta(description="topic; absent: not carried")]


class Section(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of dive.toml."""


class Dive(Section, frozen=True):
    """What was dived."""

    name: Annotated[
        str,
        Meta(
            pattern=NAME,
            max_length=100,
            description="name of the dive and of its folder of results",
        ),
    ]
    vessel: Annotated[
        str, Meta(pattern=ONE_LINE, max_length=200, description="name of the ship, for the report")
    ] = ""
    date: Annotated[
        datetime | None,
        Meta(description="start of the dive, for the report, and the day of times of day in CSVs"),
    ] = None
    start: WindowLimit = field(name="from", default=None)
    end: WindowLimit = field(name="to", default=None)


class Logs(Section, frozen=True):
    """The recorded files."""

    files: Annotated[
        tuple[FileName, ...],
        Meta(
            min_length=1,
            description="bags, MCAP, ROS 2 folders, PD0, AD2CP, ARIS, ViewPoint, Water Linked JSON "
            "or a folder of CSVs",
        ),
    ]
    time_zone: Annotated[
        TimeZone | None,
        Meta(
            description='of stamps in CSVs that are dates and times without one: "UTC", or by how '
            'much the clock is ahead of it, as "+02:00"',
        ),
    ] = None


class Topics(Section, frozen=True):
    """The topic of each sensor that was carried.

    Where all logs are CSVs and files of one instrument, the keys are ignored: these say themselves
    which sensor they are.
    """

    dvl: Topic = None
    imu: Topic = None
    pressure: Topic = None
    joints: Topic = None
    camera_top: Topic = None
    camera_bottom: Topic = None
    sonar: Topic = None
    position: Topic = None


class Tray(Section, frozen=True):
    """The servo that tilts DVL and cameras about the vehicle's y axis."""

    joint: Annotated[
        str,
        Meta(
            pattern=ONE_LINE,
            max_length=1000,
            description="name of the tray's joint in the joint messages; empty: nothing turns",
        ),
    ] = "tray"
    joint_unit: JointUnit = "rad"
    positive: Annotated[
        Literal["up", "down"],
        Meta(description="which way the tray tilts, its front, where the logged angle grows"),
    ] = "up"
    offset_deg: Annotated[Offset, Meta(description="deg, added to the angles, growing up")] = 0.0
    origin: Origin = FROM_LOG
    sigma_deg: Annotated[
        Positive, Meta(description="deg, sigma of the servo's angle, its backlash included")
    ] = 0.8
    time_offset: Annotated[
        Offset, Meta(description="s, added to the stamps of all joint messages")
    ] = 0.0


class Imu(Section, frozen=True):
    """Attitude."""

    frame: Annotated[
        Literal["ned", "enu"],
        Meta(
            description="convention of the logged orientation and axes: forward, starboard, down "
            "in north, east, down, or forward, port, up in east, north, up"
        ),
    ] = "ned"
    rates_unit: Annotated[
        Literal["rad/s", "deg/s"], Meta(description="of the logged angular velocity")
    ] = "rad/s"
    mount_deg: Annotated[
        Three | None,
        Meta(
            description="deg, roll, pitch, yaw of the IMU (axes forward, starboard, down) in the "
            "vehicle; absent: aligned; 180, 0, 0 where its axes are of the other convention than "
            "its orientation. To be given where attitude comes from a DVL's own sensors: "
            "then of the frame dvl"
        ),
    ] = None
    sigma_roll_pitch_deg: Annotated[
        Positive, Meta(description="deg, white sigma of roll and pitch")
    ] = 0.1
    heading: Annotated[
        Literal["orientation", "rates"],
        Meta(
            description="what gives the heading. The rates where a compass swings near the ship's "
            "steel: heading_drift_deg_per_hour is that of the gyroscope then, which check tells"
        ),
    ] = "orientation"
    heading_drift_deg_per_hour: Annotated[
        NotNegative, Meta(description="deg/h, sigma of the heading's drift")
    ] = 1.0
    bias_sigma_deg: Annotated[
        NotNegative, Meta(description="deg, sigma of the constant error of roll and of pitch")
    ] = 0.2
    time_offset: TimeOffset = 0.0


class Pressure(Section, frozen=True):
    """Depth, from absolute pressure or as logged."""

    origin: Origin = FROM_LOG
    unit: Annotated[
        Literal["Pa", "hPa", "mbar", "kPa", "psi", "dbar", "bar", "kgf/cm2", "m", "cm", "mm", "ft"]
        | None,
        Meta(
            description="of what the topic holds: a pressure, or a depth; absent: Pa for types of "
            "pressures, m for others"
        ),
    ] = None
    z_axis: Annotated[
        Literal["up", "down"] | None,
        Meta(
            description="sign of logged depths and poses; absent: as their type has it (poses up, "
            "REP 103, depths down)"
        ),
    ] = None
    density: Annotated[float, Meta(ge=900, le=1300, description="kg/m3, of the water")] = 1025.0
    density_sigma: Annotated[
        NotNegative,
        Meta(
            description="kg/m3, sigma of the density, also of the one behind logged depths; "
            "smaller where it was measured"
        ),
    ] = 2.05
    gravity: Annotated[float, Meta(ge=9.7, le=9.9, description="m/s2, of gravity")] = 9.81
    atmosphere: Annotated[NotNegative, Meta(description="Pa, pressure at the water's surface")] = (
        101325.0
    )
    sigma_m: Annotated[Positive, Meta(description="m, white sigma of a depth")] = 0.02
    bias_sigma_m: Annotated[
        NotNegative, Meta(description="m, sigma of the constant error of the depth")
    ] = 0.1
    time_offset: TimeOffset = 0.0


class Dvl(Section, frozen=True):
    """Velocity and ranges along the beams."""

    mount: Annotated[
        MountNumbers,
        Meta(
            description="m and deg, tray_from_dvl: the DVL on the tray; by the log's tf_static, "
            "else 0, 0, 0, 0, 90, 0"
        ),
    ] = FROM_LOG
    mount_sigma: MountSigma = (0.01, 0.01, 0.01, 0.5, 0.5, 0.5)
    velocity_unit: Annotated[
        Literal["m/s", "cm/s", "mm/s"], Meta(description="of the logged velocities")
    ] = "m/s"
    sigma_velocity: Annotated[
        Positive, Meta(description="m/s, of each axis, where the messages have no covariance")
    ] = 0.003
    sigma_range: Annotated[Positive, Meta(description="m, white sigma of a range")] = 0.01
    scale_sigma: Annotated[
        NotNegative, Meta(description="share, sigma of the error common to all velocities")
    ] = 0.005
    beams: Annotated[
        tuple[Three, ...] | None,
        Meta(description="unit vectors of the beams in dvl, for messages without them"),
    ] = None
    beam_angle_deg: BeamAngle | None = None
    beam_azimuth_deg: BeamAzimuths | None = None
    time_offset: Annotated[
        Offset, Meta(description="s, added to the stamps, those of its own attitude and depth too")
    ] = 0.0


class CameraTop(Section, frozen=True):
    """The first camera."""

    calibration: Calibration = None
    mount: Annotated[
        MountNumbers,
        Meta(
            description="m and deg, tray_from_top: the camera on the tray; by the log's tf_static, "
            "else 0, 0, 0, 90, 0, 90"
        ),
    ] = FROM_LOG
    mount_sigma: MountSigma = (0.01, 0.01, 0.01, 0.5, 0.5, 0.5)
    time_offset: TimeOffset = 0.0
    readout_s: Readout = 0.0
    sigma_px: Annotated[
        Positive, Meta(description="px, sigma of a feature before residuals tell it")
    ] = 1.0
    calibration_sigma_px: CalibrationSigma = 0.1


class CameraBottom(Section, frozen=True):
    """The second camera of a stereo rig."""

    calibration: Calibration = None
    pose_in_top: Annotated[
        MountNumbers,
        Meta(
            description="m and deg, top_from_bottom: the camera in the top camera's frame; by the "
            "log's tf_static, else 0, 0.1, 0, 0, 0, 0"
        ),
    ] = FROM_LOG
    pose_sigma: Annotated[
        Six, Meta(description="m and deg, as mount_sigma; all zero: calibrated, held")
    ] = (
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    )
    time_offset: TimeOffset = 0.0
    readout_s: Readout = 0.0
    calibration_sigma_px: CalibrationSigma = 0.1


class Cameras(Section, frozen=True):
    """One camera, `top`, or a stereo rig."""

    top: CameraTop | None = None
    bottom: CameraBottom | None = None


class Sonar(Section, frozen=True):
    """An imaging sonar."""

    joint: Annotated[
        TopicName | None, Meta(description="name of the joint of its own servo; absent: fixed")
    ] = None
    joint_unit: JointUnit = "rad"
    origin: Origin = FROM_LOG
    mount: Annotated[
        MountNumbers,
        Meta(
            description="m and deg, frame of that servo to sonar; by the log's tf_static, else 0, "
            "0, 0, 0, 90, 0"
        ),
    ] = FROM_LOG
    mount_sigma: MountSigma = (0.01, 0.01, 0.01, 0.5, 0.5, 0.5)
    elevation_deg: Annotated[
        Positive, Meta(description="deg, full aperture out of the plane of the fan")
    ] = 14.0
    beam_azimuth_deg: Annotated[
        tuple[Annotated[float, Meta(gt=-90, lt=90)], ...] | None,
        Meta(
            description="deg, of each beam from the middle of the fan, growing from port to "
            "starboard, for logs that do not say where the beams point"
        ),
    ] = None
    time_offset: TimeOffset = 0.0


class Position(Section, frozen=True):
    """Positions by USBL, or by GPS at the surface: they bound the drift of the path."""

    origin: Origin = FROM_LOG
    source: Annotated[
        Literal["satellite", "acoustic"] | None,
        Meta(
            description="who measures them: an antenna, which receives nothing under water, or "
            "USBL and underwater GPS; absent: sensor_msgs/NavSatFix is an antenna's, unless its "
            "topic's name says otherwise (usbl, ugps, acoustic, ...), other types are acoustic"
        ),
    ] = None
    frame: Annotated[
        Literal["enu", "ned"],
        Meta(
            description="convention of x and y in a local frame: east and north, or north and east"
        ),
    ] = "enu"
    sigma_m: Annotated[
        Positive,
        Meta(description="m, of each horizontal axis, where the messages have no covariance"),
    ] = 2.0
    time_offset: TimeOffset = 0.0


Limits = tuple[Offset, Offset]


class HullRegion(Section, frozen=True):
    """A part of the hull that coverage is counted against; at least one pair of limits is given."""

    name: Annotated[
        str,
        Meta(
            pattern=ONE_LINE,
            min_length=1,
            max_length=100,
            description="for the report; each its own",
        ),
    ]
    along: Annotated[
        Limits | None,
        Meta(
            description="m, from and to, forward as in the deliverables; absent: the whole length"
        ),
    ] = None
    girth: Annotated[
        Limits | None,
        Meta(
            description="m, from and to, of arc from the keel, port positive and starboard "
            "negative; absent: the whole girth"
        ),
    ] = None


class Hull(Section, frozen=True):
    """The CAD model of the ship, and where it roughly lies."""

    mesh: Annotated[FileName, Meta(description="STL, PLY, OBJ, OFF or GLB, relative to dive.toml")]
    units: Annotated[Literal["m", "mm", "cm", "ft", "in"], Meta(description="of the mesh")] = "m"
    pose: Annotated[Six, Meta(description="m and deg, first guess of global_from_hull")] = (
        0.0,
        0.0,
        0.0,
        180.0,
        0.0,
        0.0,
    )
    pose_sigma: Annotated[
        Six | None,
        Meta(
            description="m and deg, of the guess, in M's axes: the translation is that of the "
            "middle of the survey; absent: 1 m, vertically 0.3 m, 1 degree of heel and trim, 5 of "
            "heading, by the axis that `hull.pose` turns up"
        ),
    ] = None
    bow: Annotated[
        Literal["+x", "-x", "+y", "-y", "+z", "-z"] | None,
        Meta(
            description="where along the mesh's long axis the bow lies; absent: where that axis "
            "grows"
        ),
    ] = None
    aft_perpendicular: Annotated[
        Offset | None,
        Meta(
            description="m, where on the mesh's long axis the aft perpendicular lies: stations and "
            "frames count from it; absent: its zero, or the aft end where zero lies off the ship "
            "by more than its length"
        ),
    ] = None
    length_overall: Annotated[
        Positive | None,
        Meta(
            description="m, of the ship by her papers, or of the part of her that the mesh shows: "
            "what the mesh's scale and unit are held against; absent: they are taken on trust"
        ),
    ] = None
    frame_spacing: Annotated[
        Positive | None, Meta(description="m, between frames, for addresses by frame number")
    ] = None
    deviation_sigma: Annotated[
        Positive, Meta(description="m, sigma of the hull's deviation from the CAD model")
    ] = 0.02
    deviation_length: Annotated[
        tuple[Positive, Positive],
        Meta(description="m, along and over the girth: how far the deviation stays alike"),
    ] = (3.0, 1.5)
    region: Annotated[
        Annotated[tuple[HullRegion, ...], Meta(max_length=100)] | None,
        Meta(description="parts of the hull that coverage is counted against"),
    ] = None


class DiveConfig(Section, frozen=True):
    """The sections that describe the vehicle and the dive."""

    dive: Dive
    logs: Logs
    topics: Topics = field(default_factory=Topics)
    tray: Tray = field(default_factory=Tray)
    imu: Imu = field(default_factory=Imu)
    pressure: Pressure = field(default_factory=Pressure)
    dvl: Dvl = field(default_factory=Dvl)
    camera: Cameras = field(default_factory=Cameras)  # without `top`: no camera
    sonar: Sonar | None = None
    position: Position = field(default_factory=Position)
    hull: Hull | None = None  # absent: no CAD model


# The keys of dive.toml that a rig without priors is made of: what a step declares to be handed them
RIG_KEYS = (
    "tray.origin", "pressure.origin", "dvl.mount", "camera.top.mount", "camera.bottom.pose_in_top",
    "sonar.origin", "sonar.mount",
)  # fmt: skip
# The sections that a rig with priors is made of
RIG_SECTIONS = ("tray", "imu", "pressure", "dvl", "camera.top", "camera.bottom")
# Where a sensor sits if neither dive.toml nor the log says so
DEFAULT_MOUNTS: Mapping[str, tuple[float, ...]] = MappingProxyType(
    {
        "tray.origin": (0.0, 0.0, 0.0),
        "pressure.origin": (0.0, 0.0, 0.0),
        "position.origin": (0.0, 0.0, 0.0),
        "dvl.mount": (0.0, 0.0, 0.0, 0.0, 90.0, 0.0),
        "camera.top.mount": (0.0, 0.0, 0.0, 90.0, 0.0, 90.0),
        "camera.bottom.pose_in_top": (0.0, 0.1, 0.0, 0.0, 0.0, 0.0),
        "sonar.origin": (0.0, 0.0, 0.0),
        "sonar.mount": (0.0, 0.0, 0.0, 0.0, 90.0, 0.0),
    }
)
