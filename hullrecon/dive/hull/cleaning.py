# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Clean a mesh: merge equal corners, remove degenerate and duplicate faces."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh, face_areas
from hullrecon.typing import Array, Ints32, Mask

MERGE = 2e-7  # of the largest extent: two steps of single precision, in which STL stores corners
FINEST_M = 1e-6  # no CAD model is finer


def clean_mesh(mesh: Mesh, messages: list[str]) -> Mesh:
    """Return the mesh with equal corners merged, without degenerate and duplicate faces and corners
    of no face.

    What was removed is added to messages.
    """
    tolerance = max(FINEST_M, MERGE * float(np.ptp(mesh.vertices, axis=0).max()))
    vertices, faces = merge_corners(mesh.vertices, mesh.faces, tolerance)
    flat = find_degenerate(Mesh(vertices, faces), tolerance)
    faces = faces[~flat]
    first = np.sort(np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1])
    for count, name in ((int(flat.sum()), "degenerate"), (len(faces) - len(first), "duplicate")):
        if count:
            messages.append(
                f"{count} {name} faces were removed" if count > 1 else f"1 {name} face was removed"
            )
    used, renumbered = np.unique(faces[first], return_inverse=True)
    return Mesh(vertices[used], renumbered.reshape(-1, 3).astype(np.int32))


def merge_corners(vertices: Array, faces: Ints32, tolerance: float) -> tuple[Array, Ints32]:
    """Return vertices and faces with the corners in one cell of that size, m, as one: the first of
    them, in their order.
    """
    cells = np.round((vertices - vertices.min(axis=0)) / tolerance).astype(np.int64)
    _, first, number = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")  # corners keep the order of the file
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return vertices[first[order]], rank[number.ravel()][faces].astype(np.int32)


def find_degenerate(mesh: Mesh, tolerance: float) -> Mask:
    """Return the faces (m,) that are lower than the tolerance, m, over their longest side."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    longest = np.max([np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=0)
    return np.asarray(2 * face_areas(mesh) <= tolerance * longest)
