# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is judged, as arrays: read from deliver/, or taken from a solution."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.errors import InputError
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array, Mask

Fields = dict[str, NDArray[np.generic]]
_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip


@dataclass(frozen=True)
class Track:
    """t_s (n,) since 1970; poses T_M_v; sigma (n, 3) of x, y, z, or None."""

    t_s: Array
    poses: Poses
    sigma: Array | None

    def rows(self, which: Mask) -> Track:
        return Track(self.t_s[which], self.poses[which], None if self.sigma is None else self.sigma[which])


@dataclass(frozen=True)
class Cloud:
    """points (n, 3) and what a PLY says of each, by name."""

    points: Array
    fields: Fields


def read_table(path: Path) -> dict[str, Array]:
    """Columns of a CSV by name; empty is NaN. InputError when a row cannot be read."""
    try:
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
        return {key: np.array([float(row[key] or "nan") for row in rows]) for key in rows[0]}
    except (OSError, ValueError, TypeError, IndexError) as error:
        raise InputError(f"the table cannot be read: {error}", where=str(path)) from error


def read_track(path: Path) -> Track:
    """trajectory.csv."""
    table = read_table(path)
    sigma = columns(table, ("sigma_x", "sigma_y", "sigma_z")) if "sigma_x" in table else None
    return Track(table["t"], poses_in(table), sigma)


def poses_in(table: dict[str, Array]) -> Poses:
    return Poses(columns(table, ("qx", "qy", "qz", "qw")), columns(table, ("x", "y", "z")))


def columns(table: dict[str, Array], names: tuple[str, ...]) -> Array:
    """(n, names)."""
    return np.stack([table[name] for name in names], axis=1)


def read_cloud(path: Path) -> Cloud:
    """The vertices of a binary little-endian PLY. InputError when it is something else or cut short."""
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
    return Cloud(points, {name: rows[name] for name in kind.names or ()})


def deliver_folder(folder: Path) -> Path:
    """deliver/ of a run, or the folder itself when it is one. InputError when it holds no deliverable."""
    for place in (folder / "deliver", folder):
        if any((place / name).exists() for name in ("trajectory.csv", "surface.ply", "summary.json")):
            return place
    raise InputError(
        "no deliverables here", where=str(folder), remedy="give RUNS/<dive> after `hullrecon run`, or its deliver/"
    )


def _vertex_layout(lines: list[str]) -> tuple[int, np.dtype[np.void]]:
    """Count and row of the first element, which must be the vertices."""
    count, row = 0, list[tuple[str, str]]()
    for line in lines:
        words = line.split()
        if words[:1] == ["element"]:
            if row or words[1] != "vertex":
                break
            count = int(words[2])
        elif words[:1] == ["property"]:
            row.append((words[-1], "<" + _TYPES[words[1]]))
    return count, np.dtype(row)
