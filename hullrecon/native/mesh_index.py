# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Closest points and ray casts against a triangle mesh, in C++."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.errors import InputError
from hullrecon.typing import Array, Ints32, Mask


@dataclass(frozen=True, kw_only=True)
class Closest:
    """Closest points of a mesh."""

    # (n,) m, positive outside by the angle-weighted pseudonormal of the closest feature (face, edge
    # or vertex)
    distance: Array
    point: Array  # (n, 3) on the mesh
    # (n, 3) unit, gradient of the signed distance (the pseudonormal where the distance is zero)
    gradient: Array
    face: Ints32  # (n,) face on which the closest point lies


@dataclass(frozen=True, kw_only=True)
class Hits:
    """First crossings of rays with a mesh."""

    range: Array  # (n,) m, inf on a miss
    face: Ints32  # (n,) -1 on a miss
    normal: Array  # (n, 3) unit, outward by the corners' order, 0 on a miss


class MeshIndex:
    """An index for closest points and ray casts on a mesh: vertices (n, 3) m, faces (m, 3).

    Faces are counter-clockwise seen from outside. Vertices with equal coordinates count as one.
    `threads`: 0 takes all cores. The result does not depend on it. Raises InputError for wrong
    shapes, indices out of range and numbers that are not finite.
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, *, threads: int = 0) -> None:
        corners = np.asarray(faces)
        if corners.dtype.kind not in "iu":
            raise InputError("faces must be integers", where="faces")
        from hullrecon.native.compiled import native  # loads the solver's libraries

        self._index = native.MeshIndex(np.asarray(vertices, float), corners)
        self._threads = threads

    def __len__(self) -> int:
        """Count the faces."""
        return len(self._index)

    def closest(self, points: ArrayLike) -> Closest:
        """Find the closest points of the mesh to points (n, 3) m, with signed distances."""
        distance, point, gradient, face = self._index.closest(
            np.asarray(points, float), self._threads
        )
        return Closest(distance=distance, point=point, gradient=gradient, face=face)

    def cast(self, origins: ArrayLike, directions: ArrayLike) -> Hits:
        """Find the first crossings of rays from origins (n, 3) m along directions (n, 3).

        Both sides of a face count. Directions need not be unit vectors, and ranges are in metres.
        """
        distance, face, normal = self._index.cast(
            np.asarray(origins, float), np.asarray(directions, float), self._threads
        )
        return Hits(range=distance, face=face, normal=normal)

    def is_free(self, starts: ArrayLike, ends: ArrayLike) -> Mask:
        """Tell which straight lines from starts (n, 3) to ends (n, 3) no face crosses, (n,).

        A face at the end itself does not count. This is faster than `cast`, which finds the first
        face.
        """
        free: Mask = self._index.is_free(
            np.asarray(starts, float), np.asarray(ends, float), self._threads
        )
        return free
