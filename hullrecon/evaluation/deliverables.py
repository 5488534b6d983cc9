# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the deliverables that are scored as arrays."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.errors import InputError
from hullrecon.geometry.poses import Poses, identity
from hullrecon.typing import Array, Mask

Fields = dict[str, NDArray[np.generic]]
_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}


@dataclass(frozen=True, kw_only=True)
class TimedPoses:
    """A path as delivered."""

    t_s: Array  # (n,) since 1970
    poses: Poses  # hull_from_vehicle
    sigma: Array | None = None  # (n, 3) m of x, y, z in the frame that was delivered, or None
    hull_from_delivered: Poses = field(default_factory=identity)  # pose of that frame in M
    has_depth: bool = True  # z of g counts from the water's surface; else from the first pose

    def rows(self, which: Mask) -> TimedPoses:
        """Select some rows of the path."""
        sigma = None if self.sigma is None else self.sigma[which]
        return replace(self, t_s=self.t_s[which], poses=self.poses[which], sigma=sigma)


WORDS = ("side",)  # columns of trajectory.csv without numbers
UNIT = re.compile(r"_(m|m2|m3|rad|s)$")  # unit at the end of a column's name


@dataclass(frozen=True, kw_only=True)
class PointCloud:
    """The vertices of a PLY."""

    points: Array  # (n, 3) m
    fields: Fields = field(default_factory=dict)  # (n,) each property, by name


def read_table(path: Path) -> dict[str, Array]:
    """Read a CSV's columns of numbers by name without unit (`sigma_x` of `sigma_x_m`).

    An empty cell is NaN; columns of words are left out. Raises InputError for a row that cannot be
    read.
    """
    try:
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
        names = {key: UNIT.sub("", key) for key in rows[0] if key not in WORDS}
        return {
            name: np.array([float(row[key] or "nan") for row in rows])
            for key, name in names.items()
        }
    except (OSError, ValueError, TypeError, IndexError) as error:
        raise InputError(f"the table cannot be read: {error}", where=str(path)) from error


def read_trajectory(path: Path) -> TimedPoses:
    """Read trajectory.csv. Raises InputError where it cannot be read."""
    table = read_table(path)
    sigma = columns(table, ("sigma_x", "sigma_y", "sigma_z")) if "sigma_x" in table else None
    has_depth = "depth" not in table or not np.isnan(table["depth"]).all()
    return TimedPoses(t_s=table["t"], poses=poses_in(table), sigma=sigma, has_depth=has_depth)


def poses_in(table: dict[str, Array]) -> Poses:
    """Read the poses of a table with columns x, y, z, qx, qy, qz, qw."""
    return Poses(columns(table, ("qx", "qy", "qz", "qw")), columns(table, ("x", "y", "z")))


def columns(table: dict[str, Array], names: tuple[str, ...]) -> Array:
    """Stack columns by name, (n, names)."""
    return np.stack([table[name] for name in names], axis=1)


def read_cloud(path: Path) -> PointCloud:
    """Read the vertices of a binary little-endian PLY.

    Raises InputError for any other file, and for one that is cut short.
    """
    raw = path.read_bytes()
    end = raw.find(b"end_header\n")
    lines = raw[: max(end, 0)].decode("ascii", "replace").splitlines()
    if end < 0 or "format binary_little_endian 1.0" not in lines:
        raise InputError("not a binary little-endian PLY", where=str(path))
    count, kind = _vertex_layout(lines)
    start = end + len(b"end_header\n")
    if len(raw) < start + count * kind.itemsize:
        raise InputError("the PLY is cut short", where=str(path))
    rows = np.frombuffer(raw, kind, count, start)
    points = np.stack([rows[axis] for axis in "xyz"], axis=1).astype(float)
    return PointCloud(points=points, fields={name: rows[name] for name in kind.names or ()})


def deliver_folder(folder: Path) -> Path:
    """Find the folder deliver/ of a run, or take the folder itself if it holds deliverables.

    Raises InputError when there are none.
    """
    for candidate in (folder / "deliver", folder):
        if any(
            (candidate / name).exists()
            for name in ("trajectory.csv", "surface.ply", "summary.json")
        ):
            return candidate
    raise InputError(
        "no deliverables here",
        where=str(folder),
        remedy="give RUNS/<dive> after `hullrecon run`, or its deliver/",
    )


def _vertex_layout(lines: list[str]) -> tuple[int, np.dtype[np.void]]:
    """Read number and row type of a PLY's vertices, the first element of its header."""
    count, row = 0, list[tuple[str, str]]()
    for line in lines:
        fields = line.split()
        if fields[:1] == ["element"]:
            if row or fields[1] != "vertex":
                break
            count = int(fields[2])
        elif fields[:1] == ["property"]:
            row.append((fields[-1], "<" + _TYPES[fields[1]]))
    return count, np.dtype(row)
