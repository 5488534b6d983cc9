# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Half hulls and hulls cut at a plane, made whole by reflection: so that rays tell inside from outside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Ints32

Plane = tuple[int, float]  # axis and coordinate of a side of the bounding box
ON_PLANE = 1e-3  # of the largest extent
OPEN_SHARE = 0.05  # of the open boundary's length that must lie on a plane of symmetry
PLATED_SHARE = 0.01  # of the area; a plane that holds more is plating (a flat bottom, a deck), not a cut


def reflected(mesh: Mesh, planes: Sequence[Plane]) -> Mesh:
    """The mesh and its reflections; the first faces are those of the mesh. How reflected ones are wound does not matter."""
    vertices, faces = mesh.vertices, mesh.faces
    for axis, level in planes:
        copy = vertices.copy()
        copy[:, axis] = 2 * level - copy[:, axis]
        faces = np.vstack([faces, faces + len(vertices)])
        vertices = np.vstack([vertices, copy])
    return Mesh(vertices, faces.astype(np.int32))


def possible_cuts(mesh: Mesh) -> list[Plane]:
    """Sides of the bounding box at which the mesh may have been cut: part of its open boundary lies there, no plating does."""
    edges = boundary(mesh.faces)
    if not len(edges):
        return []
    ends, corners = mesh.vertices[edges], mesh.vertices[mesh.faces]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    tolerance = ON_PLANE * float((high - low).max())
    found = []
    for axis, level in [(axis, float(side[axis])) for axis in range(3) for side in (low, high)]:
        lies = (np.abs(ends[:, :, axis] - level) < tolerance).all(axis=1)
        plated = (np.abs(corners[:, :, axis] - level) < tolerance).all(axis=1)
        if length[lies].sum() >= OPEN_SHARE * length.sum() and area[plated].sum() < PLATED_SHARE * area.sum():
            found.append((axis, level))
    return found


def boundary(faces: Ints32) -> Ints32:
    """Edges (k, 2) with one face."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    return np.asarray(unique[count == 1], np.int32)
