# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Triangle meshes as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hullrecon.native import MeshIndex
from hullrecon.rows import blocks_of_rows
from hullrecon.typing import Array, Ints32

FACES_AT_ONCE = 1 << 17  # their corners take 10 MB, and each array of edge vectors as much


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh, with an index for closest points and ray casts."""

    vertices: Array  # (n, 3) m
    faces: Ints32  # (m, 3) rows of vertices, counter-clockwise seen from outside

    @cached_property
    def index(self) -> MeshIndex:
        """Index of the faces, built once for each mesh at its first use."""
        return MeshIndex(self.vertices, self.faces)

    def __getstate__(self) -> dict[str, object]:
        """Pickle the arrays alone: the index is native, and is built again."""
        return {"vertices": self.vertices, "faces": self.faces}


def face_areas(mesh: Mesh) -> Array:
    """Compute the area of each face (m,), m2."""
    return np.asarray(0.5 * np.linalg.norm(face_cross_products(mesh), axis=1))


def face_normals(mesh: Mesh) -> Array:
    """Compute the outward unit normal of each face (m, 3). Zero for a degenerate face."""
    cross = face_cross_products(mesh)
    return np.asarray(cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-15))


def vertex_areas(mesh: Mesh) -> Array:
    """Compute the share of area of each vertex (n,), m2: a third of the faces around it.

    A sum of values at vertices with these weights is an integral over the mesh.
    """
    third = face_areas(mesh) / 3
    return np.asarray(
        sum(np.bincount(mesh.faces[:, k], third, minlength=len(mesh.vertices)) for k in range(3))
    )


def vertex_normals(mesh: Mesh) -> Array:
    """Compute outward unit normals (n, 3): means of the faces' normals, weighted by their angles.

    Zero at vertices without a face.
    """
    angle, normal = corner_angles(mesh), face_normals(mesh)
    out = np.zeros_like(mesh.vertices)
    for k in range(3):
        for axis in range(3):
            out[:, axis] += np.bincount(
                mesh.faces[:, k], angle[:, k] * normal[:, axis], minlength=len(out)
            )
    return np.asarray(out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-15))


def corner_angles(mesh: Mesh) -> Array:
    """Compute the angle of each face at each of its corners (m, 3), rad."""
    out = np.zeros(mesh.faces.shape)
    for rows in blocks_of_rows(len(out), FACES_AT_ONCE):
        corner = mesh.vertices[mesh.faces[rows]]
        for k in range(3):
            a, b = corner[:, (k + 1) % 3] - corner[:, k], corner[:, (k + 2) % 3] - corner[:, k]
            cosine = np.einsum("ni,ni->n", a, b) / np.maximum(
                np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1), 1e-15
            )
            out[rows, k] = np.arccos(np.clip(cosine, -1, 1))
    return out


def corner_shares(corners: Array, points: Array) -> Array:
    """Compute barycentric coordinates (n, 3) of points (n, 3) on faces with corners (n, 3, 3).

    They are the weights with which values at the corners are interpolated. Points beside their face
    are moved to about its rim (weights are clipped to 0 to 1).
    """
    to_b, to_c, to_point = (end - corners[:, 0] for end in (corners[:, 1], corners[:, 2], points))
    bb, bc, cc, pb, pc = (
        np.einsum("ni,ni->n", u, v)
        for u, v in (
            (to_b, to_b), (to_b, to_c), (to_c, to_c), (to_point, to_b), (to_point, to_c)
        )
    )  # fmt: skip
    size = np.maximum(bb * cc - bc * bc, 1e-30)
    of_b, of_c = (cc * pb - bc * pc) / size, (bb * pc - bc * pb) / size
    return np.asarray(np.clip(np.stack([1 - of_b - of_c, of_b, of_c], axis=1), 0.0, 1.0))


def face_cross_products(mesh: Mesh) -> Array:
    """Compute (b - a) x (c - a) of each face (m, 3): twice the area along the normal."""
    out = np.empty(mesh.faces.shape)
    for rows in blocks_of_rows(len(out), FACES_AT_ONCE):
        a, b, c = mesh.vertices[mesh.faces[rows]].transpose(1, 0, 2)
        out[rows] = np.cross(b - a, c - a)
    return out
