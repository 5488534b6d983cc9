# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The page's 3-D view: the hull as found, the rest of the ship, path and objects.

report/web/src/scene.js is given a document, and one packed block of arrays that it points into. All
arrays are little-endian. Each begins at a multiple of four bytes:

- vertices: three uint16 that divide the part's bounding box evenly. The box, like path and objects,
  is relative to the document's `origin`: WebGL has single precision
- form: int16 in steps of `form_step_m` along the normal
- relief, the part of the form that may be exaggerated: int16 in the same steps
- normals: three int8 in 127ths
- map coordinates: two float32
- triangles: three uint32

The *form* is the deviation from the CAD model without offset and tilt of the surveyed patch.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, cast

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.meshes.local_origin import local_origin
from hullrecon.geometry.meshes.mesh import Mesh, vertex_normals
from hullrecon.geometry.meshes.thinning import thin_mesh
from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.content.page_data import rounded
from hullrecon.report.figures.hull_map import HullMap
from hullrecon.report.survey import Surfaces, Survey
from hullrecon.typing import Array, Ints, Ints32, Mask

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

SceneDocument = Mapping[str, object]
BLOCK = "scene-block"  # id of the element that holds the packed arrays
MAX_SURVEYED, MAX_REST = 220_000, 80_000  # triangles: what a telephone still turns smoothly
MAX_AT_ONCE = 500_000  # triangles that are thinned at a time: each takes 450 bytes meanwhile
MAX_PATH = 2000  # points of the path
RADIUS_M = 0.4  # of the relief's median: larger than structures, smaller than dents and waves
SPACING_M = 0.05  # of the points at which the median is computed
MAX_SAMPLES = 20_000  # of these points; of more, spacing and radius grow
SAMPLES_AT_A_TIME = 1000  # points whose neighbours are held at a time, 4 kB each
_STEPS = 65535  # of a uint16 over the bounding box


@dataclass(frozen=True, kw_only=True)
class ScenePart:
    """A mesh of the 3-D view."""

    vertices: Array  # (n, 3) m, of the hull without its form
    form: Array  # (n,) m along the normals, to be added to get the hull as found
    normals: Array  # (n, 3) outward
    faces: Ints32  # (m, 3)
    chart: Array  # (n, 2) along, girth of the vertices, NaN off the chart

    @property
    def has_form(self) -> bool:
        return bool(np.abs(self.form).max(initial=0.0) > 0)

    def as_found(self) -> Array:
        """Move the vertices along their normals to the hull as found."""
        return self.vertices + self.form[:, None] * self.normals


def scene_parts(surfaces: Surfaces) -> tuple[ScenePart | None, ScenePart | None]:
    """Split the hull into surveyed part and rest of the ship. None for a part without faces.

    Offset and tilt of the patch are left out: they are not known well enough to be shown as a
    shape. Without a CAD model the surveyed part has no form.
    """
    surveyed, rest = _split_hull(surfaces)
    return _decimate(surveyed, MAX_SURVEYED), _decimate(rest, MAX_REST)


def _split_hull(surfaces: Surfaces) -> tuple[ScenePart | None, ScenePart | None]:
    """Split the hull into surveyed part and rest of the ship, with all faces.

    A face of which all three corners were seen is surveyed. Both are None without a surface.
    """
    surface = surfaces.as_found if surfaces.as_found is not None else surfaces.surveyed
    if surface is None or surfaces.chart is None or not len(surface.faces):
        return None, None
    form = np.zeros(len(surface.vertices))
    if surfaces.deviation is not None and surface is surfaces.as_found:
        form = np.nan_to_num(surfaces.deviation.form)
    chart = surfaces.chart.to_chart(surface.vertices)[:, :2]
    smooth, rough = surfaces.chart.from_chart(chart)[1], vertex_normals(surface.mesh())
    # Normals of the chart, which are smooth, where there are any: those of the mesh follow its
    # bumps.
    normals = np.where(np.isfinite(smooth).all(axis=1, keepdims=True), smooth, rough)
    # The page adds the form again, more or less exaggerated
    base = surface.vertices - form[:, None] * normals
    whole = ScenePart(vertices=base, form=form, normals=normals, faces=surface.faces, chart=chart)
    seen = np.asarray((surface.support[surface.faces] > 0).all(axis=1), bool)
    return _submesh(whole, seen), _submesh(whole, ~seen)


def _submesh(part: ScenePart, faces: Mask) -> ScenePart | None:
    """Keep the faces of a mask (m,) and the vertices that they use."""
    kept = part.faces[faces]
    if not len(kept):
        return None
    used, index = _used_vertices(kept, len(part.vertices))
    return _with_attributes_of(part, used, part.vertices[used], index)


def _used_vertices(faces: Ints32, count: int) -> tuple[Ints, Ints32]:
    """Find the vertices (k,), of `count`, that faces (m, 3) use, and number the faces by them."""
    marked = np.zeros(count, bool)
    marked[faces] = True
    number = (np.cumsum(marked) - 1).astype(np.int32)
    return np.flatnonzero(marked), number[faces]


def _with_attributes_of(part: ScenePart, which: Ints, vertices: Array, faces: Ints32) -> ScenePart:
    """Make a mesh of new vertices that have form, normal and chart point of old ones.

    which: (n,) the vertex of `part` whose attributes each new vertex (n, 3) gets. faces: (m, 3) of
    the new vertices.
    """
    return ScenePart(
        vertices=vertices,
        faces=faces,
        form=part.form[which],
        normals=part.normals[which],
        chart=part.chart[which],
    )


def _decimate(part: ScenePart | None, most: int) -> ScenePart | None:
    """Thin a mesh to about `most` triangles.

    Form, normals and chart points are those of the nearest old vertices. None, and a mesh that has
    no more triangles, are returned as they are.
    """
    if part is None or len(part.faces) <= most:
        return part
    from scipy.spatial import cKDTree

    found = part.as_found()
    mesh = Mesh(found, part.faces)
    if len(mesh.faces) > MAX_AT_ONCE:
        mesh = _thin_stripes(mesh, 2 * most)
    mesh = thin_mesh(mesh, most)
    # The hull as found was thinned. Take the form off again, which the page adds
    nearest = np.asarray(cKDTree(found).query(mesh.vertices)[1], np.int64)
    vertices = mesh.vertices - part.form[nearest, None] * part.normals[nearest]
    return _with_attributes_of(part, nearest, vertices, mesh.faces)


def _thin_stripes(mesh: Mesh, most: int) -> Mesh:
    """Thin a mesh to about `most` triangles, in stripes across its longest axis.

    This takes less memory than the whole at once. Neighbouring stripes are joined at the vertices
    that both keep on their common border, nine in ten. Elsewhere a slit is left that is as narrow
    as the error of thinning, below a millimetre.
    """
    axis = int(np.argmax(np.ptp(mesh.vertices, axis=0)))
    order = np.argsort(mesh.vertices[mesh.faces, axis].mean(axis=1), kind="stable")
    stripes = np.array_split(order, -(-len(order) // MAX_AT_ONCE))
    points, faces, count = [], [], 0
    for stripe in stripes:
        used, index = _used_vertices(mesh.faces[stripe], len(mesh.vertices))
        thin = thin_mesh(Mesh(mesh.vertices[used], index), round(most * len(stripe) / len(order)))
        points.append(thin.vertices)
        faces.append(thin.faces + count)
        count += len(thin.vertices)
    # Equal vertices of neighbouring stripes become one
    joined, number = np.unique(np.concatenate(points), axis=0, return_inverse=True)
    return Mesh(joined, number.ravel()[np.concatenate(faces)].astype(np.int32))


def relief_of(points: Array, form: Array) -> Array:
    """Compute the relief (n,) m of a form (n,) at points (n, 3): a smoothed median over RADIUS_M.

    The page exaggerates it, so that dents and waves show. The median leaves out structures on the
    hull (objects, growth) and noise, which keep their height. It is computed at one point in each
    cell, since a mesh is finer at objects. It is then averaged over half the radius, and
    interpolated to all points. Over wide surveys cell and radius grow.
    """
    from scipy.spatial import cKDTree

    if not form.any():
        return np.zeros(len(points))
    spacing = SPACING_M
    samples = _one_per_cell(points, spacing)
    while len(samples) > MAX_SAMPLES:
        spacing *= np.sqrt(2.0)
        samples = _one_per_cell(points, spacing)
    radius = RADIUS_M * spacing / SPACING_M
    at, samples_form = points[samples], form[samples]
    tree = cKDTree(at)
    medians = np.concatenate(
        [_medians(samples_form[near], start) for near, start in _neighbours(tree, at, radius)]
    )
    smooth = np.concatenate(
        [
            np.add.reduceat(medians[near], start[:-1]) / np.diff(start)
            for near, start in _neighbours(tree, at, radius / 2)
        ]
    )
    distance, nearest = tree.query(points, k=min(4, len(at)))
    distance, nearest = (np.reshape(values, (len(points), -1)) for values in (distance, nearest))
    # Of the four nearest samples, by inverse squares of distances that never become zero
    weight = 1.0 / (distance + 0.25 * spacing) ** 2
    return np.asarray((smooth[nearest] * weight).sum(axis=1) / weight.sum(axis=1))


def _neighbours(tree: cKDTree, points: Array, radius: float) -> Iterator[tuple[Ints, Ints]]:
    """Find for points (n, 3), some at a time, the tree's rows within a radius: one group a point.

    Yields
    ------
    rows (k,), start (m + 1,)
        Rows of all groups, and where in them each of m groups begins and the last ends. The points
        are in the tree, so none is empty.
    """
    for begin in range(0, len(points), SAMPLES_AT_A_TIME):
        part = points[begin : begin + SAMPLES_AT_A_TIME]
        groups = cast(
            "Sequence[Sequence[int]]", tree.query_ball_point(part, radius, return_sorted=False)
        )
        start = np.cumsum([0, *map(len, groups)])
        yield np.fromiter(chain.from_iterable(groups), np.int64, start[-1]), start


def _medians(values: Array, start: Ints) -> Array:
    """Compute the median (m,) of each group of values (k,), which begin at start (m + 1,)."""
    count = np.diff(start)
    # one row a group, filled up with infinity, which a sorted row has last
    rows = np.full((len(count), int(count.max(initial=0))), np.inf)
    rows[np.arange(rows.shape[1]) < count[:, None]] = values
    rows.sort(axis=1)
    each = np.arange(len(count))
    return np.asarray((rows[each, (count - 1) // 2] + rows[each, count // 2]) / 2)


def _one_per_cell(points: Array, spacing: float) -> Array:
    """Select the first of the points (n, 3) in each cube with sides of `spacing` m, by index."""
    _, first = np.unique(np.floor(points / spacing).astype(np.int64), axis=0, return_index=True)
    return np.sort(first)


@dataclass(frozen=True, kw_only=True)
class SceneView:
    """The 3-D view."""

    document: SceneDocument
    block: str  # the packed arrays as base64


def make_scene(survey: Survey, view: HullMap | None) -> SceneView | None:
    """Make the 3-D view of a survey. None without a surface or a map."""
    surveyed, rest = scene_parts(survey.surfaces)
    if surveyed is None or view is None:
        return None
    outside = view.extent.outside
    block, path = bytearray(), _finite_rows(survey.track.poses.translation)
    origin = local_origin(surveyed.vertices)
    document: SceneDocument = {
        "block": BLOCK,
        "frame": str(survey.track.frame),
        "origin": origin.tolist(),
        "up": view.chart.ship_axes[2].tolist(),
        "forward": view.chart.ship_axes[0].tolist(),
        "forward_name": "bow" if survey.is_in_hull_frame else "x",
        "surveyed": _pack(surveyed, outside, block, origin),
        "rest": None if rest is None else _pack(rest, outside, block, origin),
        "has_form": surveyed.has_form,
        "has_cad": survey.is_in_hull_frame,
        "path": rounded((path - origin)[:: max(1, -(-len(survey.track.t_ns) // MAX_PATH))]),
        "objects": [
            _object(o, origin)
            for o in survey.findings.objects or ()
            if np.isfinite((*o.center, *o.normal)).all()
        ],
    }
    return SceneView(document=document, block=b64encode(bytes(block)).decode())


def _pack(part: ScenePart, outside: OutsideMap, block: bytearray, origin: Array) -> SceneDocument:
    """Append a part's arrays to the block.

    Returns the part's entry of the document: where each array begins in the block, and the scales
    to decode it. The box is relative to `origin` (3,).
    """
    relief = relief_of(part.vertices, part.form)
    low, high = part.vertices.min(axis=0), part.vertices.max(axis=0)
    span = np.maximum(high - low, 1e-6)
    form_step = max(float(np.abs(part.form).max(initial=0.0)), 1e-6) / 32767
    return {
        "count": len(part.vertices),
        "triangles": len(part.faces),
        "low": (low - origin).tolist(),
        "step": (span / _STEPS).tolist(),
        "form_step_m": form_step,
        "vertices": _append(block, np.round((part.vertices - low) / span * _STEPS).astype("<u2")),
        "form": _append(block, np.round(part.form / form_step).astype("<i2")),
        "relief": _append(block, np.round(relief / form_step).astype("<i2")),
        "normals": _append(block, np.round(127 * part.normals).astype("i1")),
        "map": _append(block, outside.to_map(part.chart).astype("<f4")),
        "faces": _append(block, part.faces.astype("<u4")),
    }


def _append(block: bytearray, values: np.ndarray) -> int:
    """Append an array. Returns the byte at which it begins."""
    block.extend(bytes(-len(block) % 4))
    start = len(block)
    block.extend(np.ascontiguousarray(values).tobytes())
    return start


def _object(found: ReportedObject, origin: Array) -> SceneDocument:
    """Describe an object for the view, its points relative to `origin`."""
    return {
        "id": found.id,
        "kind": "protrusion" if found.height >= 0 else "recess",
        "at": rounded(np.array(found.center, float) - origin),
        "normal": rounded(np.array(found.normal, float)),
        "outline": rounded(_finite_rows(np.array(found.outline, float).reshape(-1, 3) - origin)),
    }


def _finite_rows(points: Array) -> Array:
    """Drop points (n, 3) with a NaN."""
    return points[np.isfinite(points).all(axis=1)]
