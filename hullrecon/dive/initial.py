# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The first dive.toml, written from what a log and the folder around it hold."""

from __future__ import annotations

import os
import re
from pathlib import Path

from hullrecon.dive.hull import FORMATS
from hullrecon.dive.messages.samples import TYPES
from hullrecon.dive.survey import Survey, guess_topics
from hullrecon.dive.timeline import moment

HEAD = """\
# What was dived, with which sensors, and how they are mounted. Written by `hullrecon init`; read through it once:
# mounts and sigmas are typical values, not yours. Then `hullrecon check {folder}` says in words what it reads.
# Lengths are metres, angles degrees where a key ends in _deg or a mount lists x, y, z, roll, pitch, yaw.

[dive]
name = "{name}"
vessel = ""                      # the ship's name, for the report
{date}
[logs]
files = ["{log}"]

[topics]                         # a sensor without a line was not carried
{topics}
[tray]                           # the servoed tray that carries DVL and cameras
{tray}# its name in the joint messages{joints}
origin = [0.0, 0.0, 0.0]         # where it turns, in the vehicle's frame: x forward, y starboard, z down
sigma_deg = 0.8                  # slop of the servo

[imu]
frame = "ned"                    # or "enu": the convention of the messages' orientation
sigma_roll_pitch_deg = 0.1
heading_drift_deg_per_hour = 1.0

[pressure]
origin = [0.0, 0.0, 0.0]         # of the sensor, in the vehicle's frame
density = 1025.0                 # kg/m3; fresh water has 1000
gravity = 9.81
atmosphere = 101325.0            # Pa on the day of the dive

[dvl]
mount = [0.0, 0.0, 0.0, 0.0, 90.0, 0.0]      # on the tray; pitch 90 looks forward
sigma_velocity = 0.003           # m/s, where the messages have no covariance
sigma_range = 0.01
"""

TOP = """
[camera.top]
calibration = "{calibration}"    # the camera_info YAML of ROS's camera_calibration
mount = [0.0, 0.0, 0.0, 90.0, 0.0, 90.0]     # on the tray; these angles look forward, image upright
time_offset = 0.0                # s, added to the images' stamps
"""

BOTTOM = """
[camera.bottom]
calibration = "{calibration}"
pose_in_top = [0.0, 0.1, 0.0, 0.0, 0.0, 0.0] # from the stereo calibration: the lower camera in the upper one's frame
"""

SONAR = """
[sonar]
# joint = "sonar_tray"           # its own servo, if it has one
origin = [0.0, 0.0, 0.0]
mount = [0.0, 0.0, 0.0, 0.0, 90.0, 0.0]
elevation_deg = 14.0             # full aperture out of the fan plane
"""

HULL = """
[hull]                           # the drawing
mesh = "{mesh}"
units = "m"                      # of the file: m, mm, cm, ft, in
pose = [0.0, 0.0, 0.0, 180.0, 0.0, 0.0]      # first guess of the drawing's frame in the global one
pose_sigma = [1.0, 1.0, 0.3, 1.0, 1.0, 5.0]  # how good that guess is, at the middle of the survey
"""

NO_HULL = """
# [hull]                         # no drawing was found here; with one, name it:
# mesh = "hull.stl"
# units = "m"
"""


def first_config(survey: Survey, log: Path, folder: Path) -> str:
    """The text of a dive.toml for that folder, which load_config accepts."""
    guessed = guess_topics(survey.topics)
    names = joint_names(survey)
    tray = next((n for n in names if "tray" in n or "tilt" in n), names[0] if names else "tray")
    starts = [t.start_ns for t in survey.topics if t.count]
    text = HEAD.format(
        folder=folder.name or ".",
        name=re.sub(r"[^A-Za-z0-9._-]+", "-", folder.resolve().name) or "dive",
        date=f"date = {moment(min(starts))[:19]}Z\n" if starts else "",
        log=Path(os.path.relpath(log, folder)).as_posix(),
        topics=_topics(survey, guessed),
        tray=f'joint = "{tray}"'.ljust(33),
        joints=f": {', '.join(names)}" if names else "",
    )
    for camera, section in (("camera_top", TOP), ("camera_bottom", BOTTOM)):
        if camera in guessed:
            text += section.format(calibration=_calibration(folder, camera))
    if "sonar" in guessed:
        text += SONAR
    mesh = _drawing(folder)
    return text + (HULL.format(mesh=mesh) if mesh else NO_HULL)


def joint_names(survey: Survey) -> list[str]:
    """The joints of the first joint message."""
    for note in survey.topics:
        if note.channel.type.endswith("/JointState") and note.first is not None:
            return [str(name) for name in note.first.name]  # type: ignore[attr-defined]
    return []


def _topics(survey: Survey, guessed: dict[str, str]) -> str:
    if any(note.channel.encoding == "sample" for note in survey.topics):
        return "# the names of the files say which sensor is which\n"
    lines = []
    for sensor in TYPES:
        if sensor in guessed:
            kind = next(t.channel.type for t in survey.topics if t.channel.topic == guessed[sensor])
            lines.append(f'{sensor} = "{guessed[sensor]}" '.ljust(33) + f"# {kind}")
        else:
            lines.append(f"# {sensor} =".ljust(33) + "# no topic of the log has a type that fits, or a name that tells")
    others = [t.channel for t in survey.topics if t.channel.topic not in guessed.values()]
    lines += [f"#   not used: {c.topic} ({c.type})" for c in others]
    return "\n".join(lines) + "\n"


def _calibration(folder: Path, camera: str) -> str:
    side = camera.removeprefix("camera_")
    found = sorted(p for pattern in ("*.yaml", "*.yml") for p in folder.rglob(pattern) if side in p.stem.lower())
    return found[0].relative_to(folder).as_posix() if found else f"calibration/{camera}.yaml"


def _drawing(folder: Path) -> str | None:
    found = sorted(p for form in FORMATS for p in (*folder.glob(f"*.{form}"), *folder.glob(f"*.{form}.gz")))
    return found[0].name if found else None
