# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Triangle meshes as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Mesh:
    """vertices (n, 3) metres; faces (m, 3) int32, counter-clockwise seen from outside."""

    vertices: Array
    faces: NDArray[np.int32]


def vertex_areas(mesh: Mesh) -> Array:
    """A third of the faces around each vertex (n,), m2. So values are weighted where a mesh is finer in places."""
    third = face_areas(mesh) / 3
    return np.asarray(sum(np.bincount(mesh.faces[:, k], third, minlength=len(mesh.vertices)) for k in range(3)))


def face_areas(mesh: Mesh) -> Array:
    """(m,) m2."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))
