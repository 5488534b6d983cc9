# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The JSON lines that a Water Linked DVL sends over TCP: velocity with ranges, its own attitude.

Protocol: [WaterLinkedJSON], json_v3 (before it, reports had no time). Axes: x forward, y right, z
out of the transducers. Velocities are turned by the mounting rotation offset, ranges are those of
the transducers. position_local has roll, pitch and yaw in degrees, z down, heading from wherever
the DVL was started: by its gyroscope, not a compass.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import BinaryIO

import numpy as np

from hullrecon.dive.logs.messages.velocity import FIGURE_OF_MERIT_LIMIT
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, printable
from hullrecon.dive.logs.samples import LOST, DvlSample, ImuSample
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.typing import Array

LONGEST_LINE = 1 << 16  # bytes; a report of four beams has 1,100
LARGEST = 10**18  # microseconds since 1970 have sixteen digits
Report = Mapping[str, object]
# one of them stands in the first report
MARKS = (b'"transducers"', b'"position_local"', b'"response_to"')
START_BYTES = 4096
SUFFIXES = (".json", ".jsonl", ".txt", ".log")
VELOCITY, ATTITUDE = (Channel(sensor, "Water Linked JSON", "sample") for sensor in ("dvl", "imu"))
NS_PER_US = 1000
MOST_BEAMS = 8


def read_reports(stream: BinaryIO) -> Iterator[tuple[int, Report | None]]:
    """Yield each line's number and JSON object. None for a line that is too long or holds none."""
    number = 0
    while line := stream.readline(LONGEST_LINE):
        number += 1
        whole = len(line) < LONGEST_LINE or line.endswith(b"\n")
        while not whole and (piece := stream.readline(LONGEST_LINE)):
            whole = piece.endswith(b"\n")
            line = b""  # too long to be kept
        if line.strip():
            yield number, _parse(line)
        elif not line:
            yield number, None


def number_of(report: Report, key: str) -> float:
    """Read a finite number of a report. Raises DamagedError where there is none."""
    value = report.get(key)
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not -LARGEST <= value <= LARGEST
    ):
        raise DamagedError(f"{key} is no number")
    return float(value)


def _parse(line: bytes) -> Report | None:
    """Parse a line as a JSON object. None for anything else."""
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


class WaterLinkedLog(FileLog):
    """Reads reports line by line. Lines that are no report are listed as losses."""

    kind = "Water Linked JSON"
    gives_samples = True

    def _read(self) -> Iterator[Message]:
        """Yield velocities and attitudes of the reports, and note what these lack.

        Reports without a time are dropped and counted. Raises InputError where all are.
        """
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
                f"{printable(self.path.name)}: its {timeless} reports carry no time_of_validity "
                "(older than json_v3)",
                where=printable(str(self.path.parent)),
                remedy="update the DVL's software (2.1 or later), or log it through a driver that "
                "stamps its reports",
            )
        self._tracker.finish()
        self.notes += describe(timeless, offset_deg)


def is_water_linked(start: bytes) -> bool:
    """Tell whether a file holds a DVL's reports, one per line, by its first bytes.

    JSON of other kinds lies in many folders.
    """
    return (
        holds_reports(start)
        and start.lstrip().startswith(b"{")
        and start.split(maxsplit=1)[0] != b"{"
    )


def holds_reports(start: bytes) -> bool:
    """Tell whether a file holds a DVL's reports, one per line or reformatted as a list."""
    return start.lstrip()[:1] in (b"{", b"[") and any(mark in start for mark in MARKS)


def describe(timeless: int, offset_deg: float | None) -> list[Finding]:
    """List what the reports of a file lack.

    Parameters
    ----------
    timeless : reports without a time
    offset_deg : mounting rotation offset, None where the configuration was not logged
    """
    out = [Finding("water-linked-timeless", {"count": timeless})] if timeless else []
    if offset_deg is None:
        out.append(Finding("water-linked-no-offset"))
    elif offset_deg:
        out.append(Finding("water-linked-offset", {"degrees": offset_deg}))
    return out


def to_velocity(report: Report) -> DvlSample:
    """Convert a report of type velocity. Raises DamagedError where a value is missing.

    The velocity is lost where the report marks it as invalid, where it is not over the bottom, or
    where its figure of merit is FIGURE_OF_MERIT_LIMIT or more.
    """
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
    """Convert a report of type position_local to an attitude of `dvl`. Its position is not used.

    Raises DamagedError where a value is missing.
    """
    from scipy.spatial.transform import Rotation  # slow to import, and few logs need it

    angles = [number_of(report, key) for key in ("yaw", "pitch", "roll")]
    quaternion = Rotation.from_euler("ZYX", angles, degrees=True).as_quat()
    return ImuSample(round(number_of(report, "ts") * 1e9), quaternion, LOST, LOST, of_dvl=True)


def _ranges(transducers: object) -> Array:
    """Read the ranges along the beams in the order of the transducers' numbers, NaN where lost."""
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
    """Read the mounting rotation offset, deg, of a configuration. None without one."""
    result = report.get("result")
    return number_of(result, "mounting_rotation_offset") if isinstance(result, dict) else None
