# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The meshes of the 3-D view: the hull as found where it was seen, and the rest of the ship as its
CAD model has it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.meshes.mesh import vertex_normals
from hullrecon.report.survey import Surfaces
from hullrecon.typing import Array, Ints, Mask

MAX_SURVEYED, MAX_REST = 220_000, 80_000  # triangles: what a telephone still turns smoothly


@dataclass(frozen=True, kw_only=True)
class ScenePart:
    """A mesh of the 3-D view: vertices (n, 3) without the hull's form; form (n,) m, which along the
    outward unit normals (n, 3) gives the hull as found; faces (m, 3); chart points (n, 2), NaN off
    the chart.
    """

    vertices: Array
    form: Array
    normals: Array
    faces: Ints
    chart: Array

    @property
    def has_form(self) -> bool:
        return bool(np.abs(self.form).max(initial=0.0) > 0)

    def as_found(self) -> Array:
        """Return the vertices of the hull as found."""
        return self.vertices + self.form[:, None] * self.normals


def scene_parts(surfaces: Surfaces) -> tuple[ScenePart | None, ScenePart | None]:
    """Return the surveyed part of the hull and the rest of the ship; None for what there is not.

    Without the hull's form the surveyed part is the CAD model with the patch's offset and tilt,
    which are not known well enough to be shown as a shape. Without a CAD model it is the surface
    that was surveyed, and has no form.
    """
    surface = surfaces.as_found if surfaces.as_found is not None else surfaces.surveyed
    if surface is None or surfaces.chart is None or not len(surface.faces):
        return None, None
    form = np.zeros(len(surface.vertices))
    if surfaces.deviation is not None and surface is surfaces.as_found:
        form = np.nan_to_num(surfaces.deviation.form)
    chart = surfaces.chart.to_chart(surface.vertices)[:, :2]
    smooth, rough = surfaces.chart.from_chart(chart)[1], vertex_normals(surface.mesh())
    # of the form: not those of its bumps
    normals = np.where(np.isfinite(smooth).all(axis=1, keepdims=True), smooth, rough)
    base = surface.vertices - form[:, None] * normals
    whole = ScenePart(
        vertices=base, form=form, normals=normals, faces=surface.faces.astype(np.int64), chart=chart
    )
    seen = np.asarray((surface.support[surface.faces] > 0).all(axis=1), bool)
    return _decimate(_submesh(whole, seen), MAX_SURVEYED), _decimate(
        _submesh(whole, ~seen), MAX_REST
    )


def _submesh(part: ScenePart, faces: Mask) -> ScenePart | None:
    """Return the part of those faces (m,) bool, without the vertices that it does not use."""
    kept = part.faces[faces]
    if not len(kept):
        return None
    used, index = np.unique(kept, return_inverse=True)
    return _at(part, used, part.vertices[used], index.reshape(-1, 3))


def _at(part: ScenePart, which: Ints, vertices: Array, faces: Ints) -> ScenePart:
    """Return a mesh whose vertices have form, normal and chart point of those vertices of a part."""
    return ScenePart(
        vertices=vertices,
        faces=faces,
        form=part.form[which],
        normals=part.normals[which],
        chart=part.chart[which],
    )


def _decimate(part: ScenePart | None, most: int) -> ScenePart | None:
    """Return a part of at most about so many triangles; form and chart are those of the nearest
    vertices.
    """
    if part is None or len(part.faces) <= most:
        return part
    import open3d as o3d
    from scipy.spatial import cKDTree

    found = part.as_found()
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(found), o3d.utility.Vector3iVector(part.faces.astype(np.int32))
    )
    mesh = mesh.simplify_quadric_decimation(target_number_of_triangles=most)
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    nearest = np.asarray(cKDTree(found).query(vertices)[1], np.int64)
    return _at(part, nearest, vertices - part.form[nearest, None] * part.normals[nearest], faces)
