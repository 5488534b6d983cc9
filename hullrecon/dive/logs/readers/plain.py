# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Plain files: a folder of CSVs with a header row, for anyone without ROS."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from hullrecon.dive.logs.formats import video_frames
from hullrecon.dive.logs.formats.csv_rows import Row, read_rows
from hullrecon.dive.logs.formats.foreign_forms import describe_pictures
from hullrecon.dive.logs.formats.sonar_file import read_ping
from hullrecon.dive.logs.formats.stamps import (
    LateStampError,
    LoggerClock,
    OpenStampError,
    StampReader,
    is_time_of_day,
    words_for_unit,
)
from hullrecon.dive.logs.messages.sonar import in_fan
from hullrecon.dive.logs.readers.protocol import Channel, Loss, Message
from hullrecon.dive.logs.readers.unpack import LONGEST_REASON, printable
from hullrecon.dive.logs.samples import (
    DvlSample,
    ImageSample,
    ImuSample,
    JointSample,
    PositionSample,
    PressureSample,
    Sample,
    SonarSample,
)
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS

COLUMNS = {
    "dvl": ("t", "vx", "vy", "vz"),
    "imu": ("t", "qx", "qy", "qz", "qw"),
    "pressure": ("t", "pascal"),
    "joints": ("t", "name", "rad"),
    "camera_top": ("t", "file"),
    "camera_bottom": ("t", "file"),
    "sonar": ("t", "file"),
    "position": ("t",),
}
# ends of the names of tables that are packed, or of another form than CSV
OTHER_FORMS = (".gz", ".bz2", ".xz", ".zst", ".zip", ".tsv", ".txt", ".xls", ".xlsx", ".ods")
# Mean time between two readings that no sensor is faster than, and rows that tell it. Stamps that
# count days stay below: a reading each second is 1.2e-5 days
LEAST_ROWS, SHORTEST_NS = 20, 20_000
# Nothing tells how a vehicle moved in between, so that a DVL or IMU is read far more often. In
# milliseconds even 100 readings a second are as far apart
LONGEST_NS, PATHS = 9 * NS, ("dvl", "imu")
LISTED_LINES = 5
# all pings together may unpack to the first number of bytes plus the second times their files' size
PING_FREE_BYTES, PING_RATIO = 1 << 26, 64
# characters; file systems take no longer names, and paths of up to 4096 in all
LONGEST_FILE_NAME, LONGEST_PATH = 255, 1000
# cells in which spreadsheets and databases have no value
NO_NUMBERS = frozenset({"nan", "inf", "infinity"})
NULLS = frozenset({"", "-", "--", "null", "none", "n/a", "na", "#n/a", "nil"})
RATES, ACCELERATION = ("wx", "wy", "wz"), ("ax", "ay", "az")
WINDOW = ("range_from", "range_to")
ALTITUDE = "altitude"
RANGE = "range_"  # and a number: one of a DVL's beams
OPTIONAL = {  # columns that a table may have beside those of COLUMNS
    "dvl": (f"{RANGE}1", f"{RANGE}2", "...", ALTITUDE),
    "imu": (*RATES, *ACCELERATION),
    "camera_top": ("frame",),
    "camera_bottom": ("frame",),
    "sonar": ("ping", *WINDOW),
    "position": ("latitude", "longitude", ALTITUDE, "x", "y", "z", "sigma_m"),
}


class PlainLog:
    """A folder of CSVs. Files that they name lie next to them, or in the package."""

    kind = "plain files"
    gives_samples = True

    def __init__(
        self, path: Path, package: Path | None = None, clock: LoggerClock | None = None
    ) -> None:
        """Take the folder.

        Parameters
        ----------
        path : the folder
        package : in which files named by tables may lie as well
        clock : zone and day of stamps that do not tell them. None: these are refused
        """
        self.path, self.package, self._clock = path, package or path, clock or LoggerClock()
        self.notes: list[Finding] = []
        self._losses: list[Loss] = []
        # sonar files and the number in each of the pings that were read: none may be named twice
        self._pings: set[tuple[Path, int]] = set()
        self._ping_files: set[Path] = set()  # whose sizes count in _ping_bytes_left
        self._ping_bytes_left = PING_FREE_BYTES  # that pings may still unpack to
        # by camera, the video that is open and its path
        self._videos: dict[str, tuple[Path, video_frames.VideoFrames]] = {}

    def messages(self) -> Iterator[Message]:
        """Yield the readings of all tables, table by table.

        Raises InputError for a table without any row that can be read, or with stamps that are no
        seconds.
        """
        self.notes, self._losses = [], []
        self._pings, self._ping_files, self._videos = set(), set(), {}
        self._ping_bytes_left = PING_FREE_BYTES
        others = self._other_tables()
        if others:
            shown = ", ".join(others[:LISTED_LINES]) + (
                ", ..." if len(others) > LISTED_LINES else ""
            )
            tables = ", ".join(f"{sensor}.csv" for sensor in COLUMNS)
            values = {"files": printable(shown), "tables": tables}
            self.notes.append(Finding("tables-not-read", values))
        what, remedy = ("", "") if self._names_pictures() else describe_pictures(self._files())
        if what:
            self.notes.append(Finding("pictures-unnamed", {"what": what, "remedy": remedy}))
        for table in self.tables():
            yield from self._read_table(table.removesuffix(".csv"))

    def first_messages(self) -> list[Message]:
        """Read the first row of each table that can be read."""
        first = (
            next(self._read_table(table.removesuffix(".csv")), None) for table in self.tables()
        )
        return [message for message in first if message is not None]

    def losses(self) -> list[Loss]:
        """List what the last pass could not read."""
        return list(self._losses)

    def tables(self) -> list[str]:
        """List the CSVs of the folder that are read."""
        return [f"{sensor}.csv" for sensor in COLUMNS if (self.path / f"{sensor}.csv").exists()]

    def _names_pictures(self) -> bool:
        """Tell whether a camera has a table."""
        return any(table.startswith("camera_") for table in self.tables())

    def _files(self) -> list[str]:
        """List the names of the files in the folder and in the folders of it."""
        folders = [self.path, *(path for path in self.path.iterdir() if path.is_dir())]
        return [path.name for folder in folders for path in folder.iterdir()]

    def _other_tables(self) -> list[str]:
        """List the files of the folder that may be tables and are not read.

        These are CSVs of any other name, and files with the name of a sensor that are packed or of
        another form than CSV.
        """
        read = self.tables()
        return sorted(
            file.name
            for file in self.path.iterdir()
            if file.name not in read
            and file.is_file()
            and (
                file.suffix.lower() == ".csv"
                or (
                    file.suffix.lower() in OTHER_FORMS
                    and file.name.partition(".")[0].lower() in COLUMNS
                )
            )
        )

    def named_files(self) -> list[Path]:
        """List the existing images, videos and pings that tables name.

        Paths are relative to the package, absolute for files outside of it.
        """
        names = {
            row["file"]
            for sensor in ("camera_top", "camera_bottom", "sonar")
            if f"{sensor}.csv" in self.tables()
            for _, row in self._read(sensor)
            if row is not None and row["file"]
        }
        return sorted(
            {self._in_package(path) for path in map(self._locate, names) if is_file(path)}
        )

    def _read_table(self, sensor: str) -> Iterator[Message]:
        """Yield the readings of a sensor's table.

        Rows of units or remarks are skipped. Rows that cannot be read are counted and become a
        loss. Raises InputError where that is all of them, or where most stamps are no seconds.
        """
        channel, translate = Channel(sensor, f"{sensor}.csv", "sample"), self._translators()[sensor]
        stamps = StampReader(self._clock)
        bad, rows, pace = _BadLines(), 0, _Pace()
        for line, row in self._read(sensor):
            if row is not None and _is_remark(row["t"]):
                continue
            if row is not None and rows == 0:
                self.notes += _other_columns(sensor, row)
            rows += 1
            try:
                if row is None:
                    raise ValueError("it is cut off, too long or no CSV")
                sample = translate(row, stamps.read_ns(row))
            except (
                ValueError,
                TypeError,
                KeyError,
                OverflowError,
                AttributeError,
                OSError,
            ) as error:
                bad.add(line, error)
                continue
            pace.add(sample.t_ns)
            yield Message(channel, sample.t_ns, sample)
        if not rows:
            self.notes.append(Finding("table-empty", where=f"{sensor}.csv"))
        self._refuse(sensor, rows, bad, pace)
        if self._clock.is_assumed and stamps.open:
            self.notes.append(Finding("stamps-open", {"lacks": stamps.open}, f"{sensor}.csv"))
        if bad.count:
            why = f"{bad.listed()} of {sensor}.csv cannot be read"
            why += f": {bad.reason}" if bad.reason else ""
            self._losses.append(Loss(why, sensor, messages=bad.count))

    def _refuse(self, sensor: str, rows: int, bad: _BadLines, pace: _Pace) -> None:
        """Raise InputError for a table whose stamps are no seconds, or without a row to be read."""
        where, in_seconds = str(self.path), "write column t in seconds since 1970"
        doubt = pace.doubt(sensor in PATHS)
        if doubt:
            raise InputError(f"{sensor}.csv has {doubt}", where=where, remedy=in_seconds)
        if 2 * len(bad.late_s) > rows:
            late_s = bad.late_s[0]
            raise InputError(
                f"{sensor}.csv has stamps such as {late_s:.17g}{words_for_unit(late_s)}",
                where=where,
                remedy=in_seconds,
            )
        if rows and bad.count == rows:
            raise InputError(
                f"{sensor}.csv has no row that can be read: line {bad.first[0]}: {bad.reason}",
                where=where,
                remedy=bad.remedy,
            )

    def _read(self, sensor: str) -> Iterator[tuple[int, Row | None]]:
        return read_rows(self.path / f"{sensor}.csv", COLUMNS[sensor])

    def _translators(self) -> dict[str, Callable[[Row, int], Sample]]:
        """List the function that translates a row and its stamp, ns, by table."""
        return {
            "dvl": _dvl,
            "imu": _imu,
            "pressure": lambda row, t_ns: PressureSample(t_ns, _read_number(row["pascal"])),
            "joints": lambda row, t_ns: JointSample(
                t_ns, printable(row["name"].strip()), _read_number(row["rad"])
            ),
            "camera_top": lambda row, t_ns: self._read_image("camera_top", row, t_ns),
            "camera_bottom": lambda row, t_ns: self._read_image("camera_bottom", row, t_ns),
            "sonar": self._read_ping,
            "position": _position,
        }

    def _locate(self, name: str) -> Path:
        """Resolve a file name of a table: beside the table, else in the package.

        Separators may be those of Windows. If there is no such file, the path that it would have in
        the package is returned.
        """
        names = dict.fromkeys((name.strip(), name.strip().replace("\\", "/")))
        places = [folder / known for known in names for folder in (self.path, self.package)]
        return next((place for place in places if is_there(place)), self.package / name.strip())

    def _read_image(self, camera: str, row: Row, t_ns: int) -> ImageSample:
        """Read a row of a camera's table, which names an image file or a frame of a video.

        The bytes of an image file stay there: they are read when the image is checked. A frame of a
        video is decoded at once.
        """
        name = row["file"].strip()
        path = self._locate(name)
        is_name = 0 < len(name) <= LONGEST_PATH and len(path.name) <= LONGEST_FILE_NAME
        if not is_name or (is_there(path) and not is_file(path)):
            raise ValueError(f"{printable(name, LONGEST_REASON)!r} is no file")
        if path.suffix.lower() in video_frames.SUFFIXES:
            return ImageSample(t_ns, camera, self._read_video_frame(camera, path, row))
        return ImageSample(t_ns, camera, b"", self._in_package(path).as_posix())

    def _read_video_frame(self, camera: str, path: Path, row: Row) -> bytes:
        """Read a frame of a video as JPEG. Rows have to be in the order of the frames.

        The video stays open for the next row, as decoders only read forward.
        """
        if not (row.get("frame") or "").strip().isdecimal():
            raise ValueError("a video needs the number of its frame in column frame")
        name, video = self._videos.get(camera, (None, None))
        if name != path or video is None:
            video = video_frames.VideoFrames(path)
            self._videos[camera] = (path, video)
            if video.turned_deg:
                values = {"turn": f"turned by {video.turned_deg} degrees"}
                self.notes.append(Finding("pictures-turned", values, path.name))
        return video.jpeg(int(row["frame"]))

    def _in_package(self, path: Path) -> Path:
        """Name a file relative to the package, or by its whole path if it lies elsewhere."""
        return (
            path.relative_to(self.package) if path.is_relative_to(self.package) else path.absolute()
        )

    def _read_ping(self, row: Row, t_ns: int) -> SonarSample:
        """Read a ping. Beams lie in the y-z plane of `sonar`, azimuth from z towards y.

        Raises ValueError for a file that cannot be read, a ping that was named before, and where
        the pings together unpack to far more than their files hold.
        """
        name = printable(row["file"], LONGEST_REASON)
        path = Path(os.path.realpath(self._locate(row["file"])))  # of links in a circle, too
        number = int(row.get("ping") or 0)
        if (path, number) in self._pings:
            raise ValueError(f"{name}: its ping {number} was named already (column ping)")
        try:
            image, azimuth, range_m = read_ping(path, max(0, number), _window(row))
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
        if path not in self._ping_files:
            self._ping_bytes_left += PING_RATIO * path.stat().st_size
        self._ping_files.add(path)
        self._pings.add((path, number))
        self._ping_bytes_left -= image.nbytes
        if self._ping_bytes_left < 0:
            raise ValueError(
                f"{name}: with it the pings would unpack to more than {PING_RATIO} times their size"
            )
        return SonarSample(t_ns, image, None if azimuth is None else in_fan(azimuth), range_m)


def _is_remark(stamp: str) -> bool:
    """Tell whether a row is one of units, a remark or a total, by its cell of column t."""
    text = stamp.strip()
    is_word = text[:1].isalpha() and not any(c.isdigit() for c in text)
    return text.startswith(("#", "%", "[")) or (is_word and text.lower() not in NULLS | NO_NUMBERS)


def _other_columns(sensor: str, row: Row) -> list[Finding]:
    """Name the columns of a sensor's table that are not read: they may be misspelt."""
    read = (*COLUMNS[sensor], *OPTIONAL.get(sensor, ()))
    others = [
        name
        for name in row
        if name
        and name not in read
        and not (sensor == "dvl" and name.startswith(RANGE))
        and not (name == "date" and is_time_of_day(row["t"]))
    ]
    values = {"columns": printable(", ".join(others), LONGEST_REASON), "read": ", ".join(read)}
    return [Finding("columns-not-read", values, f"{sensor}.csv")] if others else []


class _BadLines:
    """Count the lines that cannot be read, and keep the numbers of the first, and why."""

    def __init__(self) -> None:
        self.count = 0
        self.first: list[int] = []
        self.reason = self.remedy = ""  # of the first that has one
        self.late_s: list[float] = []  # stamps too large to be seconds

    def add(self, line: int, error: Exception) -> None:
        """Count a line that cannot be read."""
        self.count += 1
        if len(self.first) < LISTED_LINES:
            self.first.append(line)
        self.reason = self.reason or printable(str(error), LONGEST_REASON)
        if isinstance(error, OpenStampError):
            self.remedy = self.remedy or error.remedy
        if isinstance(error, LateStampError):
            self.late_s.append(error.seconds)

    def listed(self) -> str:
        """Name the first of these lines, such as "lines 3, 5, ..."."""
        noun = "line" if self.count == 1 else "lines"
        return f"{noun} {', '.join(map(str, self.first))}" + (
            ", ..." if self.count > LISTED_LINES else ""
        )


class _Pace:
    """Watches how fast the stamps of a table follow each other."""

    def __init__(self) -> None:
        self.read = self.slow = 0  # stamps, and steps of more than LONGEST_NS
        self.first_ns = self.last_ns = 0

    def add(self, t_ns: int) -> None:
        """Take the next stamp."""
        if self.read == 0:
            self.first_ns = t_ns
        elif t_ns - self.last_ns > LONGEST_NS:
            self.slow += 1
        self.read, self.last_ns = self.read + 1, t_ns

    def doubt(self, is_of_path: bool) -> str:
        """Word why the stamps are no seconds. "" where they may be.

        is_of_path: the readings are those of which a path is made, so that they are frequent.
        """
        if self.read < LEAST_ROWS:
            return ""
        span = f"{self.read} stamps from {self.first_ns / 1e9:.10g} to {self.last_ns / 1e9:.10g}"
        if 0 < self.last_ns - self.first_ns < SHORTEST_NS * (self.read - 1):
            return f"{span}, which are no seconds: are they days, as in a spreadsheet?"
        if is_of_path and 2 * self.slow > self.read:
            step_s = (self.last_ns - self.first_ns) / (self.read - 1) / 1e9
            return f"{span}, {step_s:.3g} s from one to the next: are they milliseconds?"
        return ""


def is_there(path: Path) -> bool:
    """Tell whether something lies at a path. False for a path that no file can have."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def is_file(path: Path) -> bool:
    """Tell whether a path is a regular file, not a pipe, device or folder."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _dvl(row: Row, t_ns: int) -> DvlSample:
    """Translate a row of dvl.csv. Empty cells of velocities, ranges and altitude are lost values.

    The directions of the beams are those of dive.toml.
    """
    names = [n for n in row if n.startswith(RANGE)]
    odd = [n for n in names if not n[len(RANGE) :].isdecimal()]
    if odd:
        raise ValueError(f"column {odd[0]} is none of range_1, range_2, ...")
    names.sort(key=lambda n: int(n[len(RANGE) :]))
    velocity = np.array([_read_number(row[name], lost=True) for name in ("vx", "vy", "vz")])
    ranges = np.array([_read_number(row[name], lost=True) for name in names])
    altitude = _read_number(row[ALTITUDE], lost=True) if ALTITUDE in row else float("nan")
    return DvlSample(t_ns, velocity, float("nan"), ranges, None, altitude=altitude, by_hand=True)


def _imu(row: Row, t_ns: int) -> ImuSample:
    """Translate a row of imu.csv. Rates and accelerations may be missing."""
    quaternion = np.array([_read_number(row[name]) for name in ("qx", "qy", "qz", "qw")])
    rates, acceleration = (
        np.array([_read_number(row.get(name) or "", lost=True) for name in names])
        for names in (RATES, ACCELERATION)
    )
    return ImuSample(t_ns, quaternion, rates, acceleration)


def _position(row: Row, t_ns: int) -> PositionSample:
    """Translate a row of position.csv: latitude and longitude, or x and y.

    NaN where the cells are empty, as there was no fix then.
    """
    geographic = "latitude" in row
    names = ("latitude", "longitude", "altitude") if geographic else ("x", "y", "z")
    if not geographic and not {"x", "y"} <= row.keys():
        raise ValueError("a position needs columns latitude and longitude, or x and y")
    place = np.array([_read_number(row.get(name) or "", lost=True) for name in names])
    return PositionSample(
        t_ns, place, _read_number(row.get("sigma_m") or "", lost=True), geographic
    )


def _window(row: Row) -> tuple[float, float] | None:
    """Read where a DIDSON's samples begin and end. None where the row has neither."""
    near, far = ((row.get(name) or "").strip() for name in WINDOW)
    return (_read_number(near), _read_number(far)) if near or far else None


def _read_number(value: str, lost: bool = False) -> float:
    """Read a cell's number. One without a value is a lost value where `lost` allows it."""
    if lost and (value or "").strip().lower() in NULLS:
        return float("nan")
    try:
        return float(value)
    except ValueError:
        raise ValueError(f"{value.strip()!r} is no number") from None
