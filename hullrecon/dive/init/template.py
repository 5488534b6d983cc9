# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write the first dive.toml from the contents of a log and the folder around it."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Sequence
from pathlib import Path

from hullrecon.dive.hull.mesh_files import FORMATS
from hullrecon.dive.init.log_summary import LogSummary, guess_topics
from hullrecon.dive.init.proposals import (
    azimuths_to_ask_for,
    beams_to_ask_for,
    depth_grows_up,
    find_calibration,
    has_attitude_of_dvl,
    imu_frame,
    open_in_stamps,
    pose_by_calibration,
    pressure_unit,
    proposed_mounts,
)
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.records.clock import format_time

HEAD = """\
# What was dived, with which sensors, and how they are mounted. Written by `hullrecon init`.
# Read through it once: sigmas are typical values; no log can tell what is marked "to fill in".
# Then `hullrecon check {folder}` describes what it reads.
# Lengths are metres, angles degrees where a key ends in _deg or a mount lists
# x, y, z, roll, pitch, yaw.

[dive]
name = {name}
vessel = ""                      # the ship's name, for the report
{date}
[logs]
files = [{logs}]
{time_zone}
[topics]                         # a sensor without a line was not carried
{topics}
[tray]                           # the servoed tray that carries DVL and cameras
{tray}# its name in the joint messages{joints}
{tray_origin}
sigma_deg = 0.8                  # backlash of the servo

[imu]
frame = "{frame}"                    # {why_frame}
{mount_deg}sigma_roll_pitch_deg = 0.1
heading_drift_deg_per_hour = 1.0

[pressure]
{pressure_origin}
{pressure_unit}density = 1025.0                 # kg/m3; fresh water has 1000
# where density was measured, it tells one camera's scale; kg/m3, 2.05 if left out
# density_sigma = 0.3
gravity = 9.81
atmosphere = 101325.0            # Pa on the day of the dive

[dvl]
{dvl_mount}
{beams}sigma_velocity = 0.003           # m/s, where the messages have no covariance
sigma_range = 0.01
"""

TOP = """
[camera.top]
calibration = {calibration}    # the camera_info YAML of ROS's camera_calibration
{camera_top_mount}
time_offset = 0.0                # s, added to the images' stamps
"""

BOTTOM = """
[camera.bottom]
calibration = {calibration}
{camera_bottom_pose_in_top}
"""

SONAR = """
[sonar]
# joint = "sonar_tray"           # its own servo, if it has one
{sonar_origin}
{sonar_mount}
elevation_deg = 14.0             # full aperture out of the fan plane
"""

POSITION = """
[position]                       # of USBL, or of GPS at the surface: it bounds the path's drift
{position_origin}
sigma_m = 2.0                    # where the messages have no covariance
"""

AZIMUTHS = """\
# to fill in: of each beam from the middle, growing from port to starboard
# beam_azimuth_deg = [-14.0, ..., 14.0]
"""

HULL = """
[hull]                           # the CAD model
mesh = {mesh}
units = "m"                      # of the file: m, mm, cm, ft, in
# bow = "-x"                     # where the bow lies, if not where the file's long axis grows
# length_overall = 60.0          # of the ship by her papers: it tells the file's scale and unit
# aft_perpendicular = 0.0        # where on that axis stations and frames count from, if not zero
# to fill in: first guess of the CAD model's frame in the global one
# pose = [x, y, z, 180.0, 0.0, yaw]
# how good that guess is, at the middle of the survey, by the axes of the file
# pose_sigma = [1.0, 1.0, 0.3, 1.0, 1.0, 5.0]
"""

NO_HULL = """
# [hull]                         # no CAD model was found here; with one, name it:
# mesh = "hull.stl"
# units = "m"
"""

MOUNT_DEG = """\
# to fill in: of the frame dvl in the vehicle, as attitude is that of the DVL's own sensors
# mount_deg = [roll, pitch, yaw]
"""

BY_SIGN = "# by its values: they are negative below the water"
BY_VALUES = "# by its values: as pascal they lie above the water"

DATE = """\
# to fill in: the day on which the dive began, of which the log has times alone
# date = 2026-05-04T09:30:00Z
"""
TIME_ZONE = """\
# to fill in: the zone of the tables' stamps, by how much their clock is ahead of UTC
# time_zone = "+00:00"
"""

BEAMS = """\
# beam_angle_deg = 30.0          # to fill in, from its manual: from its axis to each beam
# beam_azimuth_deg = [180.0, 0.0, 90.0, -90.0]  # of each beam about its z axis, from x towards y
"""

MOUNTS = {  # the lines of mounts that no log tells
    "tray.origin": """\
# to fill in: where it turns, in the vehicle's frame: x forward, y starboard, z down
# origin = [x, y, z]""",
    "pressure.origin": """\
# origin = [x, y, z]             # to fill in: the sensor, in the vehicle's frame""",
    "dvl.mount": """\
# to fill in: on the tray; pitch 90 looks forward
# mount = [x, y, z, 0.0, 90.0, 0.0]""",
    "camera.top.mount": """\
# to fill in: on the tray; these angles look forward, image upright
# mount = [x, y, z, 90.0, 0.0, 90.0]""",
    "camera.bottom.pose_in_top": """\
# to fill in, from the stereo calibration: the lower camera in the upper one
# pose_in_top = [x, y, z, roll, pitch, yaw]""",
    "position.origin": """\
# to fill in: transponder or antenna, in the vehicle's frame
# origin = [x, y, z]""",
    "sonar.origin": """\
# to fill in: where the servo turns, in the vehicle's frame
# origin = [x, y, z]""",
    "sonar.mount": """\
# mount = [x, y, z, 0.0, 90.0, 0.0]          # to fill in: on its servo""",
}


def _depth_lines(unit: str | None, grows_up: bool) -> str:
    """Write the keys of [pressure] for values in another unit than Pa, or that grow upwards."""
    lines = []
    if unit is not None:
        lines.append(f"unit = {_quote(unit)}".ljust(33) + BY_VALUES + "\n")
    if grows_up:
        lines.append('z_axis = "up"'.ljust(33) + BY_SIGN + "\n")
    return "".join(lines)


def _date_line(starts_ns: Sequence[int], lacks: Sequence[str]) -> str:
    """Write the key dive.date: of the first message, a comment where no stamp tells the day."""
    if "dive.date" in lacks:
        return DATE
    return f"date = {format_time(min(starts_ns))[:19]}Z\n" if starts_ns else ""


def fill_template(summary: LogSummary, logs: Sequence[Path], folder: Path) -> str:
    """Write a dive.toml for a folder, with comments for what no log tells.

    load_config accepts the text.

    Parameters
    ----------
    summary : what the logs hold
    logs : their paths
    folder : the package's folder, in which calibrations and a CAD model are looked for
    """
    guessed = guess_topics(summary.topics)
    names = joint_names(summary)
    tray = next((n for n in names if "tray" in n or "tilt" in n), names[0] if names else "tray")
    starts = [t.start_ns for t in summary.topics if t.count]
    frame, why_frame = imu_frame(summary)
    mounts, unit = _mount_lines(summary, tray, folder), pressure_unit(summary)
    text = HEAD.format(
        frame=frame,
        why_frame=why_frame,
        pressure_unit=_depth_lines(unit, depth_grows_up(summary)),
        mount_deg=MOUNT_DEG if has_attitude_of_dvl(summary) else "",
        folder=_printable(folder.name) or ".",
        name=_quote(
            re.sub(r"[^A-Za-z0-9._-]+", "-", folder.resolve().name).lstrip(".-")[:100] or "dive"
        ),
        date=_date_line(starts, open_in_stamps(summary)),
        time_zone=TIME_ZONE if "logs.time_zone" in open_in_stamps(summary) else "",
        logs=", ".join(_quote(Path(os.path.relpath(log, folder)).as_posix()) for log in logs),
        beams=BEAMS if beams_to_ask_for(summary) else "",
        topics=_topic_lines(summary, guessed),
        tray=f"joint = {_quote(tray)} ".ljust(33),
        joints=f": {_printable(', '.join(names))}" if names else "",
        **mounts,
    )
    calibrated = True  # the lower camera needs the upper one
    for camera, section in (("camera_top", TOP), ("camera_bottom", BOTTOM)):
        file = find_calibration(folder, camera)
        calibrated = calibrated and file is not None
        if camera in guessed:
            calibration = _quote(file or f"calibration/{camera}.yaml")
            filled = section.format(calibration=calibration, **mounts)
            text += filled if calibrated else _comment_out(filled)
    if "sonar" in guessed:
        text += SONAR.format(**mounts) + (AZIMUTHS if azimuths_to_ask_for(summary) else "")
    if "position" in guessed:
        text += POSITION.format(**mounts)
    mesh = _cad_model(folder)
    return text + (HULL.format(mesh=_quote(mesh)) if mesh else NO_HULL)


def _mount_lines(summary: LogSummary, tray: str, folder: Path) -> dict[str, str]:
    """Write the lines of all mounts, by the names of their fields in the template.

    A mount that is neither in tf_static nor in a calibration becomes a comment, to be filled in.
    tray: name of the tray's joint.
    """
    lines = dict(MOUNTS)
    for key, mount in proposed_mounts(summary, {"tray": tray}).items():
        values, name = ", ".join(f"{v:g}" for v in mount.value), key.rpartition(".")[2]
        lines[key] = f"{name} = [{values}]  # by {mount.source}; see that it is right"
    rig = pose_by_calibration(folder, summary)
    if rig is not None:
        values = ", ".join(f"{v:.7g}" for v in rig[1])
        lines["camera.bottom.pose_in_top"] = f"pose_in_top = [{values}]  # by {_printable(rig[0])}"
    return {key.replace(".", "_"): line for key, line in lines.items()}


def joint_names(summary: LogSummary) -> list[str]:
    """List the joints of the first joint message."""
    for note in summary.topics:
        if note.channel.type.endswith("/JointState") and note.first is not None:
            return [str(name) for name in note.first.name]  # type: ignore[attr-defined]
    return []


def _topic_lines(summary: LogSummary, guessed: dict[str, str]) -> str:
    """Write the lines of [topics]: the topic that was guessed for each sensor, then all others."""
    if all(note.channel.encoding == "sample" for note in summary.topics):
        return "# the names of the files say which sensor is which\n"
    lines = []
    for sensor in TYPES:
        channel = next(
            (t.channel for t in summary.topics if t.channel.topic == guessed.get(sensor)), None
        )
        if channel is not None and channel.encoding == "sample":
            lines.append(
                f"# {sensor} =".ljust(33)
                + f"# comes from the file beside the log: {_printable(channel.type)}"
            )
        elif channel is not None:
            kind = channel.type
            lines.append(
                f"{sensor} = {_quote(guessed[sensor])} ".ljust(33) + f"# {_printable(kind)}"
            )
        else:
            lines.append(
                f"# {sensor} =".ljust(33)
                + "# no topic of the log has a type that fits, or a name that tells"
            )
    others = [t.channel for t in summary.topics if t.channel.topic not in guessed.values()]
    lines += [f"#   not used: {_printable(c.topic)} ({_printable(c.type)})" for c in others]
    return "\n".join(lines) + "\n"


def _cad_model(folder: Path) -> str | None:
    """Find a CAD model in a folder by the endings of files. None without one."""
    found = sorted(
        p for form in FORMATS for p in (*folder.glob(f"*.{form}"), *folder.glob(f"*.{form}.gz"))
    )
    return found[0].name if found else None


def _quote(text: str) -> str:
    """Quote any text as a TOML string."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _printable(text: str) -> str:
    """Replace control characters, for a comment."""
    return "".join(c if c.isprintable() else "?" for c in text)


def _comment_out(section: str) -> str:
    """Turn the lines of a section into comments."""
    return "".join(
        f"# {line}" if line.strip() else line for line in section.splitlines(keepends=True)
    )
