# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Complete half hulls and cut hulls by reflection, for the rays that tell inside from outside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh, face_areas
from hullrecon.geometry.meshes.topology import find_edges
from hullrecon.typing import Ints, Ints32

Plane = tuple[int, float]  # axis and coordinate of a side of the bounding box
ON_PLANE = 1e-3  # of the largest extent; what is nearer to a plane lies on it
OPEN_SHARE = 0.05  # of the open boundary's length that lies on a plane where the hull was cut
# of the mesh's area; a plane with more faces in it is plating (a flat bottom, a deck), not a cut
PLATED_SHARE = 0.01


def reflect_mesh(mesh: Mesh, planes: Sequence[Plane]) -> Mesh:
    """Complete a mesh by its reflections in planes, one plane after the other.

    Reflected faces come behind the mesh's own. They keep their order of corners and so face inward:
    the result is only for casting rays at.
    """
    vertices, faces = mesh.vertices, mesh.faces
    for axis, level in planes:
        copy = vertices.copy()
        copy[:, axis] = 2 * level - copy[:, axis]
        faces = np.vstack([faces, faces + len(vertices)])
        vertices = np.vstack([vertices, copy])
    return Mesh(vertices, faces.astype(np.int32))


def find_possible_cuts(mesh: Mesh) -> list[Plane]:
    """Find the sides of the bounding box at which the mesh may have been cut, as a half hull is.

    At least OPEN_SHARE of the mesh's open edges lies in such a side, and hardly any face. Empty for
    a closed mesh.
    """
    edges = find_boundary(mesh.faces)
    if not len(edges):
        return []
    ends = mesh.vertices[edges]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    tolerance = ON_PLANE * float(np.ptp(mesh.vertices, axis=0).max())
    found = []
    for axis, level in _find_unplated_sides(mesh, tolerance):
        lies = (np.abs(ends[:, :, axis] - level) < tolerance).all(axis=1)
        if length[lies].sum() >= OPEN_SHARE * length.sum():
            found.append((axis, level))
    return found


def find_openings(mesh: Mesh) -> list[Plane]:
    """Find the sides of the bounding box at which the mesh ends open, as a half hull does.

    Hardly any face lies in such a side, and the vertices on it span more than half of the mesh in
    both other directions. Other than `find_possible_cuts`, this also finds openings of hulls whose
    plates have a thickness: their rims are closed, so that they have no open boundary.
    """
    extent = np.ptp(mesh.vertices, axis=0)
    tolerance = ON_PLANE * float(extent.max())
    found = []
    for axis, level in _find_unplated_sides(mesh, tolerance):
        rim = mesh.vertices[np.abs(mesh.vertices[:, axis] - level) < tolerance]
        if (np.delete(np.ptp(rim, axis=0), axis) > 0.5 * np.delete(extent, axis)).all():
            found.append((axis, level))
    return found


def _find_unplated_sides(mesh: Mesh, tolerance: float) -> list[Plane]:
    """Find the sides of the bounding box in which hardly any face lies.

    At these a hull may have been cut. At others a flat bottom or a deck closes it. tolerance: m,
    from a side to what lies in it.
    """
    corners, area = mesh.vertices[mesh.faces], face_areas(mesh)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    found = []
    for axis, level in [(axis, float(side[axis])) for axis in range(3) for side in (low, high)]:
        plated = (np.abs(corners[:, :, axis] - level) < tolerance).all(axis=1)
        if area[plated].sum() < PLATED_SHARE * area.sum():
            found.append((axis, level))
    return found


def ends_at_a_plane(mesh: Mesh) -> bool:
    """Tell whether the mesh was cut at a plane, as a half hull is.

    Its open boundary there has to span more than half of the mesh in both directions. A seam at the
    bow lies in such a plane too, but is narrow.
    """
    edges, extent = find_boundary(mesh.faces), np.ptp(mesh.vertices, axis=0)
    for axis, level in find_possible_cuts(mesh):
        ends = mesh.vertices[edges].reshape(-1, 3)
        rim = ends[np.abs(ends[:, axis] - level) < ON_PLANE * float(extent.max())]
        if (np.delete(np.ptp(rim, axis=0), axis) > 0.5 * np.delete(extent, axis)).all():
            return True
    return False


def find_boundary(faces: Ints32) -> Ints:
    """Find the edges (k, 2) that belong to one face only, in ascending order of their vertices."""
    edges = find_edges(faces)
    return np.asarray(edges.vertices[edges.face_count == 1])
