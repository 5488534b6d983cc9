# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull as found as a point cloud (ASPRS LAS 1.4), for programs of surveyors."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from io import BytesIO

import numpy as np

from hullrecon.geometry.meshes.gltf_axes import gltf_from
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.typing import Array

# Step of the integers in which LAS stores coordinates: a twentieth of the best sigma. 32 bits reach
# over 200 km.
STEP_M = 0.0001
POINT_FORMAT = 6  # the lowest that carries its coordinate system as WKT


def las_bytes(
    surface: Surface,
    split: DeviationSplit | None,
    frame: str,
    t_ns: int,
    *,
    by_images: bool = True,
    up: Sequence[float] | Array = (0.0, 0.0, 1.0),
) -> bytes:
    """Encode as_found.las (docs/deliverables.md): the seen vertices, with their sigmas.

    Parameters
    ----------
    surface
        The hull as found. Only vertices with support are written.
    split
        Its deviation from the CAD model, None without one.
    frame
        M or g, the frame of the surface.
    t_ns
        Time of the dive's last pose. Its date is written as the file's.
    by_images
        True if the support counts images, False if it counts returns of the DVL.
    up
        (3,) the axis that points up in M.
    """
    import laspy

    seen = surface.support > 0
    points = surface.vertices[seen]
    header = laspy.LasHeader(version="1.4", point_format=POINT_FORMAT)
    header.scales, header.offsets = np.full(3, STEP_M), np.floor(points.min(axis=0))
    header.creation_date = datetime.fromtimestamp(t_ns / 1e9, UTC).date()
    header.generating_software, header.system_identifier = "hullrecon", "hullrecon"
    values = {
        "sigma": (surface.sigma, "m, one sigma along the normal"),
        "support": (surface.support, "images that saw it" if by_images else "DVL returns near"),
    }
    if split is not None:
        values |= {
            "deviation": (surface.deviation, "m from the CAD model, outward"),
            "form": (split.form, "m, without offset and tilt"),
            "form_sigma": (split.form_sigma, "m, one sigma of the form"),
        }
    types = {name: np.int32 if name == "support" else np.float32 for name in values}
    header.add_extra_dims(
        [laspy.ExtraBytesParams(name, types[name], text) for name, (_, text) in values.items()]
    )
    header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(frame_wkt(frame, up)))
    header.global_encoding.wkt = True
    cloud = laspy.LasData(header)
    cloud.xyz = points
    cloud.return_number[:] = cloud.number_of_returns[:] = 1
    for name, (value, _) in values.items():
        cloud[name] = value[seen].astype(types[name])
    file = BytesIO()
    cloud.write(file)
    return file.getvalue()


def frame_wkt(frame: str, up: Sequence[float] | Array = (0.0, 0.0, 1.0)) -> str:
    """Write a local coordinate system of three axes in WKT 1: metres, tied to no place on Earth.

    frame: M or g. up: (3,) the axis of M that points up. WKT needs names of compass directions: in
    M a level axis is called east, and the other by its direction relative to that.
    """
    name, datum, directions = (
        "hull frame of the ship (M)",
        "the ship",
        _directions(np.asarray(up, float)),
    )
    if frame != "M":
        name, datum, directions = (
            "local level frame (g), z down",
            "start of the dive",
            ("EAST", "NORTH", "DOWN"),
        )
    axes = ",".join(
        f'AXIS["{axis}",{direction}]' for axis, direction in zip("xyz", directions, strict=True)
    )
    return f'LOCAL_CS["{name}",LOCAL_DATUM["{datum}",32767],UNIT["metre",1],{axes}]'


def _directions(up: Array) -> tuple[str, ...]:
    """Name the directions of x, y, z of a right-handed frame, given its up (3,), for the LAS.

    Which level axis is east is not known, and one is taken.
    """
    turn = gltf_from(up)[:3, :3]  # rows east, up, south
    names = (("EAST", "WEST"), ("UP", "DOWN"), ("SOUTH", "NORTH"))
    row = np.argmax(np.abs(turn), axis=0)
    return tuple(names[k][0 if turn[k, axis] > 0 else 1] for axis, k in enumerate(row))
