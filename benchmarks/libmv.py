# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Bundles from libmv's problem files (Ceres' own examples, real tracks of Blender's 'Tears of
Steel').

Little-endian 'v', markers in pixels 'P'; f cx cy k1 k2 k3 p1 p2; cameras: image, camera_from_global
by columns, translation; points: track, xyz; markers: image, track, pixel. All float32 and int32.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.bundle import Bundle
from hullrecon.errors import InputError
from hullrecon.geometry import poses

_CAMERA = np.dtype([("image", "<i4"), ("columns", "<f4", (3, 3)), ("translation", "<f4", 3)])
_POINT = np.dtype([("track", "<i4"), ("xyz", "<f4", 3)])
_MARKER = np.dtype([("image", "<i4"), ("track", "<i4"), ("pixel", "<f4", 2)])


def read(path: Path) -> Bundle:
    """Read a problem of libmv. Points with fewer than two markers are left out.

    Raises InputError when the file is of another kind or length.
    """
    data = path.read_bytes()
    if data[:2] != b"vP":
        raise InputError(
            "not a little-endian libmv problem with markers in pixels", where=str(path)
        )
    intrinsics = np.frombuffer(data, "<f4", 8, 2).astype(float)
    offset = 34
    tables: list[NDArray[Any]] = []
    for kind in (_CAMERA, _POINT, _MARKER):
        count = int(np.frombuffer(data, "<i4", 1, offset)[0])
        tables.append(np.frombuffer(data, kind, count, offset + 4))
        offset += 4 + count * kind.itemsize
    if offset != len(data):
        raise InputError(f"{len(data) - offset} bytes are left over", where=str(path))
    return _bundle(intrinsics, *tables)


def _bundle(
    intrinsics: NDArray[np.float64],
    cameras: NDArray[Any],
    points: NDArray[Any],
    markers: NDArray[Any],
) -> Bundle:
    f, cx, cy, k1, k2, k3, p1, p2 = intrinsics
    matrix = np.tile(np.eye(4), (len(cameras), 1, 1))
    matrix[:, :3, :3], matrix[:, :3, 3] = (
        cameras["columns"].transpose(0, 2, 1),
        cameras["translation"],
    )
    g_from_camera = poses.from_matrix(matrix).inverse()
    used = np.isin(markers["image"], cameras["image"]) & np.isin(markers["track"], points["track"])
    markers = markers[used]
    tracks, views = np.unique(markers["track"], return_counts=True)
    markers = markers[np.isin(markers["track"], tracks[views > 1])]
    points = points[np.isin(points["track"], tracks[views > 1])]
    return Bundle(
        pose=np.hstack([g_from_camera.translation, g_from_camera.quaternion]),
        point=points["xyz"].astype(float),
        camera=np.array([f, f, cx, cy, k1, k2, p1, p2, k3]),
        top_from_bottom=np.r_[0, 0, 0, 0, 0, 0, 1.0],
        seen_from=_places(cameras["image"], markers["image"]),
        seen=_places(points["track"], markers["track"]),
        pixel=markers["pixel"].astype(float),
    )


def _places(names: NDArray[Any], wanted: NDArray[Any]) -> NDArray[np.int32]:
    order = np.argsort(names)
    return order[np.searchsorted(names[order], wanted)].astype(np.int32)
