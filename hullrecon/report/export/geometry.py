# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces, landmarks, the chart and the hull's pose, as PLY and JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.config.mounts import guess_sigma
from hullrecon.dive.config.schema import Hull
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.records.solution import HullPose, Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.survey import Survey
from hullrecon.typing import Array, Ints

_NAMES = {"float32": "float", "float64": "double", "uint8": "uchar", "int32": "int"}


def ply_bytes(
    vertex: Mapping[str, NDArray[np.generic]],
    faces: NDArray[np.integer] | None = None,
    comments: Sequence[str] = (),
) -> bytes:
    """Encode vertex properties (n,), in the order given, and triangles (m, 3) as PLY.

    Raises KeyError for a property that is not float32, float64, uint8 or int32.
    """
    rows = pack_rows(vertex)
    header = ["ply", "format binary_little_endian 1.0", *(f"comment {line}" for line in comments)]
    header += [
        f"element vertex {len(rows)}",
        *(f"property {_NAMES[values.dtype.name]} {name}" for name, values in vertex.items()),
    ]
    body = rows.tobytes()
    if faces is not None:
        header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        triangles = np.empty(len(faces), [("n", "u1"), ("v", "<i4", 3)])
        triangles["n"], triangles["v"] = 3, faces
        body += triangles.tobytes()
    return "\n".join([*header, "end_header", ""]).encode("ascii", "replace") + body


def pack_rows(columns: Mapping[str, NDArray[np.generic]]) -> NDArray[np.void]:
    """Pack columns (n,) into rows (n,) without gaps, little endian."""
    types = [(name, values.dtype.newbyteorder("<")) for name, values in columns.items()]
    rows = np.empty(len(next(iter(columns.values()))), types)
    for name, values in columns.items():
        rows[name] = values
    return rows


def columns(points: NDArray[np.float64]) -> dict[str, NDArray[np.generic]]:
    """Split points (n, 3) into columns x, y, z of double precision.

    Single precision has steps of 4 mm at a ship's length from a harbour's origin.
    """
    return {name: np.ascontiguousarray(points[:, k]) for k, name in enumerate("xyz")}


def color_columns(color: NDArray[np.generic]) -> dict[str, NDArray[np.generic]]:
    """Split colours (n, 3) from 0 to 255 into columns red, green, blue of a byte."""
    return {name: color[:, k].astype(np.uint8) for k, name in enumerate(("red", "green", "blue"))}


def landmarks_in_hull(solution: Solution) -> NDArray[np.float64]:
    """Transform the landmarks (L, 3) to M. They stay in g without a CAD model."""
    return solution.result_from_global().apply(solution.landmarks.position)


def header_comments(survey: Survey) -> list[str]:
    """Write the comments of each PLY's header: frame and units."""
    return [
        f"frame {survey.track.frame}: {survey.frame_in_words}",
        "unit metre; sigma is one standard deviation",
    ]


def landmarks_ply(survey: Survey, solution: Solution) -> bytes:
    """Encode landmarks.ply (docs/deliverables.md), in M, without a CAD model in g.

    track is the number of images that saw a landmark. sigma is that of one axis: the square root of
    a third of the covariance's trace.
    """
    sigma = np.sqrt(np.einsum("nii->n", solution.landmarks.covariance) / 3)
    values = {
        **columns(landmarks_in_hull(solution)),
        **color_columns(solution.landmarks.color),
        "label": solution.landmarks.label.astype(np.uint8),
        "deviation": solution.landmarks.deviation.astype(np.float32),
        "sigma": sigma.astype(np.float32),
        "track": solution.landmarks.views.astype(np.int32),
    }
    return ply_bytes(values, comments=header_comments(survey))


def surface_ply(survey: Survey, surface: Surface, split: DeviationSplit | None = None) -> bytes:
    """Encode surface.ply or as_found.ply (docs/deliverables.md).

    as_found.ply also holds the form of the deviation (`split`), NaN without a CAD model.
    """
    values = {
        **columns(surface.vertices),
        "deviation": surface.deviation.astype(np.float32),
        "sigma": surface.sigma.astype(np.float32),
        "support": surface.support.astype(np.int32),
    }
    if surface is survey.surfaces.as_found:
        unknown = np.full(len(surface.vertices), np.nan, np.float32)
        values["form"] = unknown if split is None else split.form.astype(np.float32)
        values["form_sigma"] = unknown if split is None else split.form_sigma.astype(np.float32)
    return ply_bytes(values, surface.faces, header_comments(survey))


def motion_document(motion: Poses) -> dict[str, list[float]]:
    """Write a rigid motion (a batch of one) as translation (m) and quaternion (x y z w)."""
    return {
        "translation": motion.translation[0].tolist(),
        "quaternion": motion.quaternion[0].tolist(),
    }


def alignment_document(
    hull_pose: HullPose, hull: Hull, weak_directions: Sequence[Mapping[str, object]]
) -> dict[str, object]:
    """Build alignment.json (docs/deliverables.md): T_g_M, its first guess, weak directions.

    The covariance is that of the hull's pose in g, the CAD model's error included
    (HullPose.covariance).
    """
    return {
        "T_g_M": motion_document(hull_pose.global_from_hull),
        "covariance": hull_pose.covariance.tolist(),
        "covariance_order": "translation x y z in g (m), "
        "rotation x y z perturbed on the right (rad), about survey_center",
        "survey_center": hull_pose.survey_center.tolist(),
        "prior": {
            **motion_document(from_mount(hull.pose)),
            "sigma_m_deg": guess_sigma(hull.pose, hull.pose_sigma).tolist(),
        },
        "weak_directions": list(weak_directions),
    }


STEP_M = 0.1  # between vertices of the chart's mesh: 0.6 mm off a bilge of 2 m radius
MAX_VERTICES = 250_000  # with more the step is longer
MARGIN_M = 0.5  # of the mesh around what was seen
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
class ChartKind:
    """What chart.json says of a kind of chart."""

    name: str
    along: str  # what the coordinate counts
    girth: str


CHART_KINDS = {  # by the kind that a chart's arrays name
    "axis": ChartKind(
        name="hull",
        along="m along the ship, forward positive",
        girth="m of arc from the keel, port positive",
    ),
    "plane": ChartKind(name="plane", along="m along the plane", girth="m across the plane"),
    "cylinder": ChartKind(
        name="cylinder",
        along="m along the survey, of arc where it bends that way",
        girth="m across the survey, of arc where it bends that way",
    ),
}


@dataclass(frozen=True, kw_only=True)
class ChartMesh:
    """The chart as a mesh."""

    along_girth: Array  # (n, 2) m, of the vertices
    points: Array  # (n, 3) m
    normals: Array  # (n, 3) outward
    faces: Ints  # (m, 3) outward
    step_m: float  # between vertices


def chart_mesh(chart: Chart, seen: Array) -> ChartMesh:
    """Sample a chart on a lattice over the part that encloses the seen points (n, 3).

    With it other programs convert map coordinates to the results' frame (chart.ply). Cells of which
    a corner is off the chart are left out.
    """
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
        part.ravel()
        for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:])
    ]
    # Cells of which all four corners lie on the chart
    whole = np.isfinite(points[np.stack(corners, axis=1)]).all(axis=(1, 2))
    # Along, girth and the outward normal are left-handed: this order of corners turns faces
    # outward.
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
    arrays = chart.to_arrays()
    kind = CHART_KINDS[str(arrays["kind"])]
    low, high = mesh.along_girth.min(axis=0), mesh.along_girth.max(axis=0)
    plane = None
    if kind.name == "plane":
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
        "kind": kind.name,
        "along": kind.along,
        "girth": kind.girth,
        "map": outside.document(),
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
