# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The distance between a CAD model of flat facets and the curved hull that it represents.

Two facets of widths a and b, across an edge at which they meet at an angle t, approximate a circle
of radius (a + b) / (2 t). Its arc rises above the facet of width a by the sagitta
a^2 t / (4 (a + b)). Heights of that size come from the tessellation, not from a structure. When the
survey slides along the hull, the pattern of facets makes false minima a facet apart, which
registration must not take for information.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from hullrecon.geometry.meshes.mesh import (
    Mesh,
    corner_angles,
    corner_shares,
    face_areas,
    face_normals,
)
from hullrecon.geometry.meshes.topology import find_shared_edges, weld_vertices
from hullrecon.typing import Array, Ints, Mask

REACH_M = 1.0  # largest distance from points of the facets whose error counts
# A sharper edge is drawn on purpose (a chine, a keel), and not between facets of a curve
SHARPEST_RAD = np.radians(40.0)


@dataclass(frozen=True, kw_only=True)
class TessellationError:
    """The error of flat facets against a smooth hull."""

    sigma_m: float  # of the hull's distance from the facets
    length_m: float  # mean width of a facet, within which the errors are correlated


@dataclass(frozen=True, kw_only=True)
class _SmoothEdges:
    """The k edges between faces that approximate one curved surface."""

    first: Ints  # (k,) face on one side
    second: Ints  # (k,) face on the other side
    width_first: Array  # (k,) m, of the first face, perpendicular to the edge
    width_second: Array  # (k,) m, of the second face
    angle: Array  # (k,) rad, between the two faces' normals


def facet_sagitta(mesh: Mesh) -> Array:
    """Compute the sagitta of the hull's arc over each face (m,), m.

    It is the largest of those by the face's edges. Sharp edges have none.
    """
    edges = _smooth_edges(mesh)
    out = np.zeros(len(mesh.faces))
    for face, own in ((edges.first, edges.width_first), (edges.second, edges.width_second)):
        np.maximum.at(
            out,
            face,
            own**2 * edges.angle / (4 * np.maximum(edges.width_first + edges.width_second, 1e-12)),
        )
    return out


def facet_turn(mesh: Mesh) -> Array:
    """Compute the largest angle (m,) rad of each face to a neighbour, sharp edges left out."""
    edges = _smooth_edges(mesh)
    out = np.zeros(len(mesh.faces))
    for face in (edges.first, edges.second):
        np.maximum.at(out, face, edges.angle)
    return out


def tessellation_error(mesh: Mesh, points: Array) -> TessellationError:
    """Estimate the error of the facets within REACH_M of points (n, 3) in the mesh's frame.

    Zero where these facets share no smooth edge.
    """
    # Facets count by area, and widths by how much they bend the hull
    part = Mesh(mesh.vertices, mesh.faces[_faces_near(mesh, points)])
    edges = _smooth_edges(part)
    if not len(edges.angle):
        return TessellationError(sigma_m=0.0, length_m=1.0)
    sagitta, area = facet_sagitta(part), face_areas(part)
    width = 0.5 * (edges.width_first + edges.width_second)
    return TessellationError(
        sigma_m=float(np.sqrt(np.average(sagitta**2, weights=area + 1e-12))),
        length_m=float(np.average(width, weights=width * edges.angle + 1e-12)),
    )


def smooth_normals(mesh: Mesh, points: Array, faces: Ints) -> Array:
    """Compute the unit normals (n, 3) of the curved hull at points (n, 3) on their faces (n,).

    The normals of facets jump from one to the next. So normals are interpolated between the corners
    of a facet. The normal at a corner is the mean, weighted by angle, of those facets around it
    that are turned from this one by less than a sharp edge is.
    """
    wanted, row = np.unique(faces, return_inverse=True)
    at_corner = _corner_normals(mesh, wanted)[row.reshape(-1)]
    share = corner_shares(mesh.vertices[mesh.faces[faces]], points)
    smooth = np.einsum("nk,nki->ni", share, at_corner)
    return np.asarray(smooth / np.linalg.norm(smooth, axis=1, keepdims=True))


def _corner_normals(mesh: Mesh, wanted: Ints) -> Array:
    """Compute the smooth unit normals (k, 3, 3) at the three corners of the faces `wanted` (k,).

    They are means over the facets around a corner, weighted by their angles there, without those
    beyond a sharp edge. The normal of the facet itself where no facet around the corner has an
    area.
    """
    vertex = weld_vertices(mesh).faces
    normal, angle = face_normals(mesh), corner_angles(mesh).ravel()
    # The corners of all faces in the order of their vertices
    order = np.argsort(vertex.ravel(), kind="stable")
    count = np.bincount(vertex.ravel())
    start = np.cumsum(count) - count
    # Pairs of each wanted corner with each corner at the same vertex
    own = vertex[wanted].ravel()
    corner = np.repeat(np.arange(len(own)), count[own])
    rank = np.arange(len(corner)) - np.repeat(np.cumsum(count[own]) - count[own], count[own])
    other = order[start[own[corner]] + rank]
    beside = normal[other // 3]
    cosine = np.einsum("ni,ni->n", normal[wanted[corner // 3]], beside)
    weight = np.where(cosine >= np.cos(SHARPEST_RAD), angle[other], 0.0)
    total = np.stack(
        [np.bincount(corner, weight * beside[:, i], minlength=len(own)) for i in range(3)], axis=1
    )
    length = np.linalg.norm(total, axis=1, keepdims=True)
    facet = np.repeat(normal[wanted], 3, axis=0)
    return np.where(length > 0, total / np.where(length > 0, length, 1), facet).reshape(-1, 3, 3)


def _faces_near(mesh: Mesh, points: Array) -> Mask:
    """Tell which faces (m,) may have a point within REACH_M of points (n, 3)."""
    corner = mesh.vertices[mesh.faces]
    middle = corner.mean(axis=1)
    radius = np.linalg.norm(corner - middle[:, None], axis=2).max(axis=1)
    return np.asarray(cKDTree(points).query(middle)[0] <= REACH_M + radius)


def _smooth_edges(mesh: Mesh) -> _SmoothEdges:
    """Find the edges between two faces that meet at less than SHARPEST_RAD.

    Sharper edges and faces without area are left out.
    """
    welded = weld_vertices(mesh)
    shared = find_shared_edges(welded.faces)
    normal, area = face_normals(mesh), face_areas(mesh)
    angle = np.arccos(
        np.clip(np.einsum("ni,ni->n", normal[shared.first], normal[shared.second]), -1, 1)
    )
    smooth = (angle <= SHARPEST_RAD) & (area[shared.first] > 0) & (area[shared.second] > 0)
    first, second = shared.first[smooth], shared.second[smooth]
    # The width of a face across an edge is its height over that edge
    ends = welded.vertices[shared.vertices[smooth]]
    length = np.maximum(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), 1e-9)
    return _SmoothEdges(
        first=first,
        second=second,
        width_first=2 * area[first] / length,
        width_second=2 * area[second] / length,
        angle=angle[smooth],
    )
