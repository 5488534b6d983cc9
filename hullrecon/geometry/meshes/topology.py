# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the edges of a mesh, and the faces that meet at them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Ints, Mask


@dataclass(frozen=True, kw_only=True)
class Edges:
    """Unique edges of a mesh."""

    vertices: Ints  # (e, 2) ascending in each row
    of_face: Ints  # (m, 3) edges 0-1, 1-2, 2-0 of each face
    face_count: Ints  # (e,) faces that have the edge
    forward: Mask  # (m, 3) the face runs along the edge from its smaller vertex


@dataclass(frozen=True, kw_only=True)
class SharedEdges:
    """Edges between exactly two faces."""

    vertices: Ints  # (k, 2)
    first: Ints  # (k,) faces
    second: Ints  # (k,) faces
    # (k,) the two run along the edge in opposite senses, as neighbours of a consistently oriented
    # surface do
    same_winding: Mask


def find_edges(faces: NDArray[np.integer]) -> Edges:
    """Find the edges of faces (m, 3), in ascending order of their vertices."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
    size = int(faces.max()) + 1 if len(faces) else 1
    low, high = ends.min(axis=1), ends.max(axis=1)
    key, number, count = np.unique(low * size + high, return_inverse=True, return_counts=True)
    return Edges(
        vertices=np.stack([key // size, key % size], axis=1),
        of_face=number.reshape(-1, 3),
        face_count=count,
        forward=(ends[:, 0] < ends[:, 1]).reshape(-1, 3),
    )


def find_shared_edges(faces: NDArray[np.integer]) -> SharedEdges:
    """Find the edges of faces (m, 3) that exactly two faces share, with `first` < `second`.

    Open edges, and those at which more than two faces meet, are left out.
    """
    edges = find_edges(faces)
    number = edges.of_face.ravel()
    inner = np.flatnonzero(edges.face_count[number] == 2)
    pairs = inner[np.argsort(number[inner], kind="stable")].reshape(-1, 2)
    forward = edges.forward.ravel()
    return SharedEdges(
        vertices=edges.vertices[number[pairs[:, 0]]],
        first=pairs[:, 0] // 3,
        second=pairs[:, 1] // 3,
        same_winding=forward[pairs[:, 0]] != forward[pairs[:, 1]],
    )


def weld_vertices(mesh: Mesh, tolerance_m: float = 1e-6) -> Mesh:
    """Merge vertices at equal coordinates, to the tolerance. Faces keep their order."""
    cells = np.round(mesh.vertices / tolerance_m).astype(np.int64)
    _, first, number = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    return Mesh(mesh.vertices[first], np.asarray(number.reshape(-1)[mesh.faces], np.int32))
