# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a DVL of Water Linked sends over TCP, kept line by line in a file: velocity with ranges, and
the DVL's own attitude.

Protocol: [WaterLinkedJSON], json_v3 (before it, reports had no time). Axes: x forward, y right, z
out of the transducers; velocities are turned by the mounting rotation offset, ranges are those of
the transducers. position_local has roll, pitch and yaw in degrees, z down, heading from wherever
the DVL was started: by its gyroscope, not a compass.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.formats.json_reports import Report, number_of, read_reports
from hullrecon.dive.logs.messages.velocity import FIGURE_OF_MERIT_LIMIT
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, printable
from hullrecon.dive.logs.samples import DvlSample, ImuSample
from hullrecon.errors import InputError
from hullrecon.typing import Array

# one of them stands in the first report
MARKS = (b'"transducers"', b'"position_local"', b'"response_to"')
START_BYTES = 4096
SUFFIXES = (".json", ".jsonl", ".txt", ".log")
VELOCITY, ATTITUDE = (Channel(sensor, "Water Linked JSON", "sample") for sensor in ("dvl", "imu"))
LOST = np.full(3, np.nan)
NS_PER_US = 1000
MOST_BEAMS = 8


class WaterLinkedLog(FileLog):
    """Reports line by line; what is no report is named by its line."""

    kind = "Water Linked JSON"
    gives_samples = True

    def _read(self) -> Iterator[Message]:
        offset_deg, timeless = None, 0
        with self.path.open("rb") as stream:
            for number, report in read_reports(stream):
                try:
                    if report is None:
                        raise DamagedError("it is no JSON object")
                    # json_v1 has no types
                    kind = report.get("type", "velocity" if "vx" in report else None)
                    if kind == "velocity" and "time_of_validity" not in report:
                        timeless += 1
                    elif kind == "velocity":
                        sample = to_velocity(report)
                        yield self._tracker.record(Message(VELOCITY, sample.t_ns, sample))
                    elif kind == "position_local":
                        attitude = to_attitude(report)
                        yield self._tracker.record(Message(ATTITUDE, attitude.t_ns, attitude))
                    elif report.get("response_to") == "get_config":
                        offset_deg = _mounting_offset(report)
                except DamagedError as error:
                    self._tracker.open_gap(f"line {number} cannot be read: {error}")
        if timeless and not self._tracker.seen:
            raise InputError(
                f"{printable(self.path.name)}: its {timeless} reports carry no time_of_validity (older than json_v3)",
                where=printable(str(self.path.parent)),
                remedy="update the DVL's software (2.1 or later), or log it through a driver that stamps its reports",
            )
        self._tracker.finish()
        self.remarks += describe(timeless, offset_deg)


def is_water_linked(start: bytes) -> bool:
    """Return whether a file that begins so holds such reports, one a line: other JSON lies in many
    folders.
    """
    return (
        holds_reports(start)
        and start.lstrip().startswith(b"{")
        and start.split(maxsplit=1)[0] != b"{"
    )


def holds_reports(start: bytes) -> bool:
    """Return whether a file that begins so holds such reports, one a line or as somebody rewrote
    them: a list, indented.
    """
    return start.lstrip()[:1] in (b"{", b"[") and any(mark in start for mark in MARKS)


def describe(timeless: int, offset_deg: float | None) -> list[str]:
    """Return a sentence for what the reports of a file lack; offset_deg: None where its
    configuration was not logged.
    """
    out = []
    if timeless:
        out.append(
            f"{timeless} reports have no time_of_validity (a protocol older than json_v3): they cannot be used"
        )
    if offset_deg:
        out.append(
            f"velocities were turned by the DVL's mounting rotation offset of {offset_deg:g} degrees, its ranges were not: "
            "add it to each of dvl.beam_azimuth_deg"
        )
    if offset_deg is None:
        out.append(
            "its mounting rotation offset is not in the file: where it is not 0, add it to each of dvl.beam_azimuth_deg"
        )
    return out


def to_velocity(report: Report) -> DvlSample:
    """Return velocity and ranges of a report of type velocity. Raises DamagedError."""
    is_valid = (
        report.get("velocity_valid") is True and report.get("tracking_mode", "bottom") == "bottom"
    )
    merit = number_of(report, "fom") if is_valid else np.nan
    is_valid = is_valid and not merit >= FIGURE_OF_MERIT_LIMIT
    velocity = (
        np.array([number_of(report, key) for key in ("vx", "vy", "vz")]) if is_valid else LOST
    )
    altitude = number_of(report, "altitude") if is_valid else np.nan
    return DvlSample(
        round(number_of(report, "time_of_validity")) * NS_PER_US,
        velocity,
        merit if is_valid and merit > 0 else np.nan,
        _ranges(report.get("transducers")),
        None,
        altitude=altitude if altitude > 0 else np.nan,
    )


def to_attitude(report: Report) -> ImuSample:
    """Return the attitude of a report of type position_local. Raises DamagedError."""
    angles = [number_of(report, key) for key in ("yaw", "pitch", "roll")]
    quaternion = Rotation.from_euler("ZYX", angles, degrees=True).as_quat()
    return ImuSample(round(number_of(report, "ts") * 1e9), quaternion, LOST, LOST, of_dvl=True)


def _ranges(transducers: object) -> Array:
    """Return the distances in the order of the transducers' numbers, NaN for one that is not valid."""
    if not isinstance(transducers, Sequence) or len(transducers) > MOST_BEAMS:
        raise DamagedError("it has no list of transducers")
    if not all(isinstance(t, dict) for t in transducers):
        raise DamagedError("a transducer of it is none")
    found = sorted(
        (number_of(t, "id"), number_of(t, "distance"), t.get("beam_valid") is True)
        for t in transducers
    )
    return np.array(
        [distance if valid and distance > 0 else np.nan for _, distance, valid in found], float
    )


def _mounting_offset(report: Report) -> float | None:
    result = report.get("result")
    return number_of(result, "mounting_rotation_offset") if isinstance(result, dict) else None
