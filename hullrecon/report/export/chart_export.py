# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The chart for programs without hullrecon: as a mesh, and how to go from it to the ship."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.address import is_hull_chart
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.report.export.geometry_export import header_comments
from hullrecon.report.export.ply import columns, ply_bytes
from hullrecon.report.survey import Survey
from hullrecon.typing import Array, Ints

STEP_M = 0.1  # between vertices: 0.6 mm off a bilge of 2 m radius
MAX_VERTICES = 250_000  # of a larger survey the step is longer
MARGIN_M = 0.5  # around what was seen
TO_POINT = (
    "along = along_from_x * x, girth = girth_from_y * y. In chart.ply find the face whose corners' "
    "(along, girth) hold the point and interpolate x, y, z and nx, ny, nz linearly: the point on "
    "the hull, and the outward normal there. What lies off the hull by an offset (deviation.tif, a "
    "height) is the point plus offset times normal."
)
TO_CHART = (
    "The inverse: find the face, the place on it and the offset for which point plus offset times "
    "normal, both interpolated as above, is the given point (Newton's method from the closest "
    "point takes some steps). x = along / along_from_x, y = girth / girth_from_y. The closest "
    "point itself, at which the objects' outlines and deviation.tif lie, is up to offset times the "
    "angle between neighbouring faces away."
)


@dataclass(frozen=True, kw_only=True)
class ChartMesh:
    """The chart as a mesh."""

    along_girth: Array  # (n, 2) m, of the vertices
    points: Array  # (n, 3) m
    normals: Array  # (n, 3) outward
    faces: Ints  # (m, 3) outward
    step_m: float  # between vertices


def chart_mesh(chart: Chart, seen: Array) -> ChartMesh:
    """Sample the part of a chart around points (n, 3) that were seen on a lattice."""
    at = chart.to_chart(seen)[:, :2]
    at = at[np.isfinite(at).all(axis=1)]
    low, high = at.min(axis=0) - MARGIN_M, at.max(axis=0) + MARGIN_M
    step = max(STEP_M, float(np.sqrt(np.prod(high - low) / MAX_VERTICES)))
    along, girth = (
        np.arange(np.floor(a / step), np.ceil(b / step) + 1) * step
        for a, b in zip(low, high, strict=True)
    )
    lattice = np.stack(np.meshgrid(along, girth, indexing="ij"), axis=-1)
    points, normals = chart.from_chart(lattice.reshape(-1, 2))
    number = np.arange(len(points)).reshape(len(along), len(girth))
    corners = [
        number[rows, columns].ravel()
        for rows in (np.s_[:-1], np.s_[1:])
        for columns in (np.s_[:-1], np.s_[1:])
    ]
    whole = np.isfinite(points[np.stack(corners, axis=1)]).all(axis=(1, 2))
    # charts are left-handed about the outward normal
    a, b, c, d = (corner[whole] for corner in corners)
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    used, faces = np.unique(faces, return_inverse=True)
    return ChartMesh(
        along_girth=lattice.reshape(-1, 2)[used],
        points=points[used],
        normals=normals[used],
        faces=faces.reshape(-1, 3),
        step_m=step,
    )


def chart_ply(survey: Survey, mesh: ChartMesh) -> bytes:
    """Encode chart.ply (docs/deliverables.md)."""
    normals = {f"n{axis}": mesh.normals[:, k].astype(np.float32) for k, axis in enumerate("xyz")}
    at = {
        name: np.ascontiguousarray(mesh.along_girth[:, k])
        for k, name in enumerate(("along", "girth"))
    }
    return ply_bytes({**columns(mesh.points), **normals, **at}, mesh.faces, header_comments(survey))


def chart_document(chart: Chart, outside: OutsideMap, mesh: ChartMesh) -> dict[str, object]:
    """Build chart.json (docs/deliverables.md)."""
    on_ship, arrays = is_hull_chart(chart), chart.to_arrays()
    low, high = mesh.along_girth.min(axis=0), mesh.along_girth.max(axis=0)
    plane = None
    if "origin" in arrays:
        axes = np.asarray(arrays["axes"], float)
        plane = {
            "origin": np.asarray(arrays["origin"], float).tolist(),
            "along": axes[0].tolist(),
            "girth": axes[1].tolist(),
            "normal": axes[2].tolist(),
        }
    return {
        "schema": 1,
        "frame": outside.frame,
        "kind": "hull" if on_ship else "plane",
        "along": "m along the ship, forward positive" if on_ship else "m along the plane",
        "girth": "m of arc from the keel, port positive" if on_ship else "m across the plane",
        "map": {
            "along_from_x": outside.x_sign,
            "girth_from_y": outside.y_sign,
            "name": outside.name,
            "wkt": outside.wkt,
        },
        "mesh": {
            "file": "chart.ply",
            "step_m": mesh.step_m,
            "along_m": [float(low[0]), float(high[0])],
            "girth_m": [float(low[1]), float(high[1])],
        },
        "plane": plane,
        "from_map_to_frame": TO_POINT,
        "from_frame_to_map": TO_CHART,
    }
