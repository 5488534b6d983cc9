# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Closest points on a mesh and rays against it, in batches."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh, face_normals
from hullrecon.geometry.meshes.tessellation import smooth_normals
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Ints32, Mask


@dataclass(frozen=True, kw_only=True)
class ClosestPoints(Rows):
    """Closest points of a mesh."""

    distance: Array  # (n,) m, signed, positive outside
    foot: Array  # (n, 3) on the mesh
    normal: Array  # (n, 3) of the closest triangle, outward
    face: Ints  # (n,) closest triangle, -1 for a point that is not finite


class Scene:
    """Closest points and ray casts on one mesh, exact in double precision."""

    def __init__(self, mesh: Mesh) -> None:
        self._index, self._mesh = mesh.index, mesh

    @cached_property
    def _normal(self) -> Array:
        """Normals (m, 3) of the faces, which rays do without."""
        return face_normals(self._mesh)

    def closest(self, points: Array) -> ClosestPoints:
        """Find the closest point of the mesh for each of the points (n, 3).

        The sign of the distance is by the pseudonormal there. NaN for points that are not finite.
        """
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
        return ClosestPoints(distance=distance, foot=foot, normal=normal, face=face)

    def smooth_normals(self, near: ClosestPoints) -> Array:
        """Compute the normals (n, 3) of the curved hull that the facets approximate.

        At finite closest points. They do not jump from facet to facet, except at sharp edges.
        """
        return smooth_normals(self._mesh, near.foot, near.face)

    def hit(self, origins: Array, directions: Array) -> tuple[Array, Ints32]:
        """Cast rays from origins (n, 3), or one (3,), m, along unit directions (n, 3).

        Returns ranges (n,) m, inf where nothing was met, and the faces (n,) that were met, or -1.
        """
        if not len(directions):
            return np.zeros(0), np.zeros(0, np.int32)
        hits = self._index.cast(np.broadcast_to(origins, directions.shape), directions)
        return hits.range, hits.face

    def cast(self, origins: Array, directions: Array) -> Array:
        """Compute the range (n,) m from origins to the mesh, inf for a ray that misses it.

        origins (n, 3) or (3,) m. directions (n, 3): unit vectors.
        """
        return self.hit(origins, directions)[0]

    def is_free(self, starts: Array, ends: Array) -> Mask:
        """Tell which straight lines (n,) between points (n, 3) or (3,) the mesh does not cross.

        A line that meets the mesh only at its end is free.
        """
        return self._index.is_free(*np.broadcast_arrays(starts, ends))
