# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Closest points on a mesh and rays against it, in batches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.native import MeshIndex
from hullrecon.typing import Array, Ints


@dataclass(frozen=True)
class Closest:
    """distance (n,) m, signed, positive outside; foot (n, 3) on the mesh; normal (n, 3) of the closest triangle, outward;
    face (n,), -1 where there is no answer."""

    distance: Array
    foot: Array
    normal: Array
    face: Ints


class Scene:
    """Answers for one mesh, exact in double precision."""

    def __init__(self, mesh: Mesh) -> None:
        self._index = MeshIndex(mesh.vertices, mesh.faces)
        a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
        normal = np.cross(b - a, c - a)
        self._normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-15)

    def closest(self, points: Array) -> Closest:
        """Return the mesh's closest point to each of (n, 3), the sign by the pseudonormal there; NaN for points not finite."""
        known = np.asarray(np.isfinite(points).all(axis=1))
        distance, foot, normal = (
            np.full(len(points), np.nan),
            np.full((len(points), 3), np.nan),
            np.full((len(points), 3), np.nan),
        )
        face = np.full(len(points), -1)
        if known.any():
            near = self._index.closest(points[known])
            distance[known], foot[known], face[known] = near.distance, near.point, near.face
            normal[known] = self._normal[near.face]
        return Closest(distance, foot, normal, face)

    def cast(self, origins: Array, directions: Array) -> Array:
        """Return how far (n,), m, along unit directions (n, 3) from origins (n, 3) or (3,) the mesh lies; inf for a miss."""
        if not len(directions):
            return np.zeros(0)
        return self._index.cast(np.broadcast_to(origins, directions.shape), directions).range
