# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Propose conventions, calibrations and mounts from a log, and list what it leaves open."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.config.calibration import is_camchain, read_pose_in_top
from hullrecon.dive.config.mounts import ChosenMount, choose_mounts, split_by_servo
from hullrecon.dive.config.schema import DEFAULT_MOUNTS, FROM_LOG
from hullrecon.dive.init.log_summary import LogSummary, TopicNote, guess_topics
from hullrecon.dive.logs.dvl_beams import ask_for_beams
from hullrecon.dive.logs.fixed_frames import fixed_sensors, frame_of
from hullrecon.dive.logs.messages.decode import ENCODINGS, type_name
from hullrecon.dive.logs.messages.descriptions import (
    CAMERA_INFO,
    calibration_yaml,
    frame_doubts,
    frame_tree,
    lies_beside,
)
from hullrecon.dive.logs.messages.samples import TYPES, WITHOUT_HEADER
from hullrecon.dive.logs.samples import DvlSample, ImuSample, SonarSample
from hullrecon.dive.logs.sonar_geometry import ask_for_azimuths
from hullrecon.dive.logs.streams.imu import LEAST_FELT_M_S2, UNIT_QUATERNION
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import Camera

STAMPS_OPEN = {  # by key of dive.toml, what the stamps of tables may leave open
    "logs.time_zone": 'the zone of the tables\' times, "UTC" or as "+02:00"',
    "dive.date": "the day on which the dive began, as the tables have times of day alone",
}


def questions(summary: LogSummary) -> list[Finding]:
    """List what the log leaves open and a run needs. Empty where it leaves nothing open.

    That is where the beams of DVL and sonar point, how a DVL sits whose attitude is used, and the
    zone and day of stamps that do not tell them.
    """
    beams, fan = beams_to_ask_for(summary), azimuths_to_ask_for(summary)
    out = [Finding("question", {"question": ask_for_beams(beams).line()})] if beams else []
    out += [Finding("question", {"question": ask_for_azimuths(fan).line()})] if fan else []
    out += [
        Finding("question", {"question": f"{key}: {STAMPS_OPEN[key]}"})
        for key in open_in_stamps(summary)
    ]
    return out + ([Finding("mount-of-dvl-open")] if has_attitude_of_dvl(summary) else [])


def open_in_stamps(summary: LogSummary) -> list[str]:
    """List the keys of dive.toml that say what the stamps of tables leave open."""
    lacks = {str(note.values["lacks"]) for note in summary.notes if note.code == "stamps-open"}
    return [key for key in STAMPS_OPEN if any(key in keys for keys in lacks)]


def _note_of(summary: LogSummary, sensor: str) -> TopicNote | None:
    """Find the topic that is guessed to be a sensor's."""
    topic = guess_topics(summary.topics).get(sensor)
    return next((note for note in summary.topics if note.channel.topic == topic), None)


def has_attitude_of_dvl(summary: LogSummary) -> bool:
    """Tell whether the only attitude is that of the DVL's own sensors."""
    topic = guess_topics(summary.topics).get("imu")
    return any(
        isinstance(t.first, ImuSample) and t.first.of_dvl
        for t in summary.topics
        if t.channel.topic == topic
    )


def imu_frame(summary: LogSummary) -> tuple[str, str]:
    """Guess the convention of the logged attitude, "enu" or "ned", and say why.

    Where the acceleration was logged, it decides: an accelerometer at rest measures -g, so turned
    by the orientation it points along +z in "enu" and along -z in "ned".
    """
    note = _note_of(summary, "imu")
    first = None if note is None else note.first
    is_message = note is not None and note.channel.encoding != "sample"
    if note is not None and is_message and first is not None:
        first = next(iter(TYPES["imu"][type_name(note.channel)](first, 0, "imu")), None)
    if isinstance(first, ImuSample) and abs(np.linalg.norm(first.quaternion) - 1) < UNIT_QUATERNION:
        up = Rotation.from_quat(first.quaternion).apply(first.acceleration)[2]
        if abs(up) > LEAST_FELT_M_S2:
            return ("enu" if up > 0 else "ned"), "by gravity in the first message"
    if is_message:
        return "enu", "REP 145, as no gravity is logged; or ned"
    return "ned", "or enu: the convention of the orientation"


def pressure_unit(summary: LogSummary) -> str | None:
    """Find the unit of the pressure's topic where that is not pascal, by its values."""
    note = _note_of(summary, "pressure")
    unit = None if note is None else note.depth.unit
    return None if unit == "Pa" else unit


def depth_grows_up(summary: LogSummary) -> bool:
    """Tell whether the depth's topic holds numbers that are negative below the water."""
    note = _note_of(summary, "pressure")
    return note is not None and note.depth.grows_up


def beams_to_ask_for(summary: LogSummary) -> int:
    """Count the DVL's beams where the first message has ranges but no directions, else 0."""
    note = _note_of(summary, "dvl")
    first = None if note is None else note.first
    if note is not None and first is not None and not isinstance(first, DvlSample):
        first = next(iter(TYPES["dvl"][type_name(note.channel)](first, 0, "dvl")), None)
    return len(first.ranges) if isinstance(first, DvlSample) and first.beams is None else 0


def azimuths_to_ask_for(summary: LogSummary) -> int:
    """Count the beams of an imaging sonar where nothing says where they point, else 0."""
    note = _note_of(summary, "sonar")
    first = None if note is None else note.first
    return len(first.image) if isinstance(first, SonarSample) and first.directions is None else 0


def missing_calibrations(summary: LogSummary, folder: Path) -> dict[str, str]:
    """Write a camera_info YAML for each camera that has a logged CameraInfo but no file yet.

    Returns its text by path in the package.
    """
    out = {}
    for camera in ("camera_top", "camera_bottom"):
        topic = guess_topics(summary.topics).get(camera)
        if topic is None or find_calibration(folder, camera) is not None:
            continue
        infos = [
            t for t in summary.topics if type_name(t.channel) == CAMERA_INFO and t.first is not None
        ]
        beside = [t for t in infos if lies_beside(t.channel.topic, topic)]
        text = calibration_yaml(beside[0].first, beside[0].channel.topic) if beside else None
        if text is not None:
            out[f"calibration/{camera}.yaml"] = text
    return out


def proposed_mounts(
    summary: LogSummary, joints: Mapping[str, str] = MappingProxyType({})
) -> dict[str, ChosenMount]:
    """Propose mounts, by key of dive.toml, where tf_static leads from base_link to a sensor.

    Mounts that tf_static does not give, or gives in two ways, are left out.

    joints: names of the servos' joints, by record ("tray", "sonar_tray").
    """
    frames = {
        sensor: frame
        for sensor, topic in guess_topics(summary.topics).items()
        for note in summary.topics
        if note.channel.topic == topic
        and note.channel.encoding in ENCODINGS
        and note.first is not None
        and type_name(note.channel) not in WITHOUT_HEADER
        and (frame := frame_of(note.first)) is not None
    }
    messages = [message for note in summary.topics for message in note.frames]
    sensors = fixed_sensors(frame_tree(messages), frames, joints, frame_doubts(messages))
    found = choose_mounts(dict.fromkeys(DEFAULT_MOUNTS, FROM_LOG), sensors)
    # Doubtful mounts are not proposed: written into dive.toml they would pass for confirmed ones.
    # They are left to the log, and `check` reports what is wrong with them.
    doubtful = (
        () if split_by_servo(sensors) is None else ("tray.origin", "dvl.mount", "camera.top.mount")
    )
    return {key: mount for key, mount in found.items() if mount.source and key not in doubtful}


def find_calibration(folder: Path, camera: str) -> str | None:
    """Find the YAML file of a package that calibrates a camera, relative to the package.

    It is named after the camera, or is a camchain of Kalibr. None where there is none. folder: of
    the package, which is searched with the folders in it.
    """
    side = camera.removeprefix("camera_")
    patterns = ("*.yaml", "*.yml", "*/*.yaml", "*/*.yml")
    files = [p for pattern in patterns for p in folder.glob(pattern) if p.is_file()]
    found = sorted(p for p in files if side in p.stem.lower()) or sorted(filter(is_camchain, files))
    return found[0].relative_to(folder).as_posix() if found else None


def pose_by_calibration(folder: Path, summary: LogSummary) -> tuple[str, tuple[float, ...]] | None:
    """Find the lower camera's pose in the upper one where one camchain calibrates both.

    Returns its file, and the pose as in dive.toml. None where each camera has a file of its own, or
    the camchain holds no pose or cannot be read.
    """
    file = find_calibration(folder, Camera.TOP.key)
    if file is None or file != find_calibration(folder, Camera.BOTTOM.key):
        return None
    try:
        pose = read_pose_in_top(folder / file, guess_topics(summary.topics))
    except InputError:  # `check` says what is wrong with it
        return None
    return None if pose is None else (file, pose)
