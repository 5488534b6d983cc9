# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Closest points on a mesh and rays against it, in batches, by Open3D's Embree scene (single precision about the middle)."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.meshes import Mesh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Closest:
    """distance (n,) m, signed, positive outside; foot (n, 3) on the mesh; normal (n, 3) of the closest triangle, outward."""

    distance: Array
    foot: Array
    normal: Array


class Scene:
    """Answers for one mesh. Coordinates are shifted to the mesh's middle first: single precision then holds micrometres."""

    def __init__(self, mesh: Mesh) -> None:
        open3d: Any = import_module("open3d")
        self._tensor = open3d.core.Tensor
        self._middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
        self._scene = open3d.t.geometry.RaycastingScene(nthreads=1)
        vertices = self._tensor((mesh.vertices - self._middle).astype(np.float32))
        self._scene.add_triangles(vertices, self._tensor(mesh.faces.astype(np.uint32)))

    def closest(self, points: Array) -> Closest:
        """The closest point of the mesh for each of (n, 3); the sign is the closest triangle's side."""
        answer = self._scene.compute_closest_points(self._tensor((points - self._middle).astype(np.float32)))
        foot = answer["points"].numpy().astype(float) + self._middle
        normal = answer["primitive_normals"].numpy().astype(float)
        gap = points - foot
        side = np.where(np.einsum("ni,ni->n", gap, normal) < 0, -1.0, 1.0)
        return Closest(side * np.linalg.norm(gap, axis=1), foot, normal)

    def cast(self, origins: Array, directions: Array) -> Array:
        """How far along unit directions (n, 3) from origins (n, 3) or (3,) the mesh is met, (n,) m; inf where it is not."""
        start = np.broadcast_to(origins, directions.shape) - self._middle
        rays = self._tensor(np.hstack([start, directions]).astype(np.float32))
        return np.asarray(self._scene.cast_rays(rays)["t_hit"].numpy(), float)
