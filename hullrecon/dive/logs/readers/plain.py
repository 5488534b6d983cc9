# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Plain files: a folder of CSVs with a header row, for anyone without ROS."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

from hullrecon.dive.logs.readers.protocol import Channel, Loss, Message
from hullrecon.dive.logs.samples import DvlSample, ImageSample, ImuSample, JointSample, PressureSample, Sample, SonarSample
from hullrecon.errors import InputError

Row = Mapping[str, str]
COLUMNS = {
    "dvl": ("t", "vx", "vy", "vz"),
    "imu": ("t", "qx", "qy", "qz", "qw"),
    "pressure": ("t", "pascal"),
    "joints": ("t", "name", "rad"),
    "camera_top": ("t", "file"),
    "camera_bottom": ("t", "file"),
    "sonar": ("t", "file"),
}
UNITS = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
EARLIEST_S, LATEST_S = 3e8, 4.2e9  # 1979 and 2103: no log of a dive lies outside
RATES, ACCELERATION = ("wx", "wy", "wz"), ("ax", "ay", "az")


class PlainLog:
    """package: files named in the CSVs are looked for beside the CSV, then below the package."""

    kind = "plain files"
    gives_samples = True

    def __init__(self, path: Path, package: Path | None = None) -> None:
        self.path, self.package = path, package or path
        self.remarks: list[str] = []
        self._losses: list[Loss] = []

    def messages(self) -> Iterator[Message]:
        self.remarks, self._losses = [], []
        for table in self.tables():
            yield from self._table(table.removesuffix(".csv"))

    def losses(self) -> list[Loss]:
        return list(self._losses)

    def tables(self) -> list[str]:
        """Return the names of the CSVs that are there and read."""
        return [f"{sensor}.csv" for sensor in COLUMNS if (self.path / f"{sensor}.csv").exists()]

    def named_files(self) -> list[Path]:
        """Return the files that a CSV of images or pings names and that exist, relative to the package if they lie in it."""
        out = []
        for sensor in ("camera_top", "camera_bottom", "sonar"):
            if (self.path / f"{sensor}.csv").exists():
                out += [self._locate(row["file"]) for _, row in self._read(sensor) if row.get("file")]
        return sorted({self._in_package(path) for path in out if path.is_file()})

    def _table(self, sensor: str) -> Iterator[Message]:
        channel = Channel(sensor, f"{sensor}.csv", "sample")
        bad: list[int] = []
        late: list[float] = []
        first_reason = ""
        rows = 0
        for line, row in self._read(sensor):
            rows += 1
            try:
                sample = self._samples()[sensor](row)
            except _LateStampError as error:
                late.append(error.seconds)
                bad.append(line)
                continue
            except (ValueError, TypeError, KeyError, OverflowError, AttributeError) as error:
                first_reason = first_reason or f"line {line}: {error}"
                bad.append(line)
                continue
            yield Message(channel, sample.t_ns, sample)
        if 2 * len(late) > rows:
            raise InputError(
                f"{sensor}.csv has stamps such as {late[0]:.17g}{unit_of_stamp(late[0])}", where=str(self.path),
                remedy="write column t in seconds since 1970",
            )  # fmt: skip
        if rows and len(bad) == rows:
            raise InputError(f"{sensor}.csv has no row that can be read: {first_reason}", where=str(self.path))
        if bad:
            lines = ", ".join(map(str, bad[:5])) + (", ..." if len(bad) > 5 else "")
            self._losses.append(Loss(f"lines {lines} of {sensor}.csv cannot be read", sensor, messages=len(bad)))

    def _read(self, sensor: str) -> Iterator[tuple[int, Row]]:
        """Line number and row. InputError when a column that every row needs is not in the header."""
        path = self.path / f"{sensor}.csv"
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
            table = csv.DictReader((line.replace("\0", "") for line in stream), skipinitialspace=True)
            missing = [name for name in COLUMNS[sensor] if name not in (table.fieldnames or ())]
            if missing:
                raise InputError(
                    f"{path.name} has no column {', '.join(missing)}", where=str(path.parent),
                    remedy=f"its header row needs {', '.join(COLUMNS[sensor])}",
                )  # fmt: skip
            try:
                yield from ((table.line_num, row) for row in table)
            except csv.Error as error:
                self._losses.append(Loss(f"{path.name} cannot be read from line {table.line_num} on: {error}", sensor))

    def _samples(self) -> dict[str, Callable[[Row], Sample]]:
        return {
            "dvl": _dvl,
            "imu": _imu,
            "pressure": lambda row: PressureSample(_ns(row), _number(row["pascal"])),
            "joints": lambda row: JointSample(_ns(row), row["name"].strip(), _number(row["rad"])),
            "camera_top": lambda row: self._image("camera_top", row),
            "camera_bottom": lambda row: self._image("camera_bottom", row),
            "sonar": self._sonar,
        }

    def _locate(self, name: str) -> Path:
        beside = self.path / name.strip()
        return beside if beside.exists() else self.package / name.strip()

    def _image(self, camera: str, row: Row) -> ImageSample:
        path = self._locate(row["file"])
        return ImageSample(_ns(row), camera, b"", self._in_package(path).as_posix())

    def _in_package(self, path: Path) -> Path:
        return path.relative_to(self.package) if path.is_relative_to(self.package) else path.absolute()

    def _sonar(self, row: Row) -> SonarSample:
        """Beams lie in the y-z plane of `sonar`, azimuth from z towards y."""
        try:
            with self._locate(row["file"]).open("rb") as stream, np.load(stream, allow_pickle=False) as arrays:
                absent = [key for key in ("image", "azimuth", "range") if key not in arrays]
                if absent:
                    raise ValueError(f"it has no {' and no '.join(absent)}")
                image, azimuth, range_m = (np.asarray(arrays[key]) for key in ("image", "azimuth", "range"))
        except Exception as error:  # numpy and zipfile raise a dozen kinds over a damaged .npz
            raise ValueError(f"{row['file']}: {error}") from None
        if image.shape != (len(azimuth), len(range_m)) or not image.size:
            raise ValueError("the sonar image's shape is not [beams, ranges]")
        directions = np.stack([np.zeros(len(azimuth)), np.sin(azimuth), np.cos(azimuth)], axis=1)
        return SonarSample(_ns(row), image, directions, range_m.astype(float))


class _LateStampError(ValueError):
    def __init__(self, seconds: float) -> None:
        super().__init__()
        self.seconds = seconds


def unit_of_stamp(value: float) -> str:
    """Return the name of the unit in which a stamp that is none in seconds would be one; "" where none fits."""
    fits = [name for name, size in UNITS.items() if EARLIEST_S <= value / size <= LATEST_S]
    return f", which look like {fits[0]}" if fits else ""


def _dvl(row: Row) -> DvlSample:
    names = [n for n in row if n and n.startswith("range_")]
    odd = [n for n in names if not n[6:].isdecimal()]
    if odd:
        raise ValueError(f"column {odd[0]} is none of range_1, range_2, ...")
    names.sort(key=lambda n: int(n[6:]))
    velocity = np.array([_number(row[name], lost=True) for name in ("vx", "vy", "vz")])
    ranges = np.array([_number(row[name], lost=True) for name in names])
    return DvlSample(_ns(row), velocity, float("nan"), ranges, None)


def _imu(row: Row) -> ImuSample:
    quaternion = np.array([_number(row[name]) for name in ("qx", "qy", "qz", "qw")])
    rates, acceleration = (
        np.array([_number(row.get(name) or "", lost=True) for name in names]) for names in (RATES, ACCELERATION)
    )
    return ImuSample(_ns(row), quaternion, rates, acceleration)


def _number(value: str, lost: bool = False) -> float:
    """An empty cell is a lost value where that may be."""
    return float("nan") if lost and not (value or "").strip() else float(value)


def _ns(row: Row) -> int:
    """Nanoseconds of seconds since 1970, exact to the digits written."""
    seconds = float(row["t"])
    if seconds > LATEST_S:
        raise _LateStampError(seconds)
    whole, _, fraction = row["t"].strip().partition(".")
    if whole.lstrip("-").isdigit() and (not fraction or fraction.isdigit()) and not whole.startswith("-"):
        return int(whole) * 1_000_000_000 + int((fraction + "0" * 9)[:9])
    return round(seconds * 1e9)
