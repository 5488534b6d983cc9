# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A sphere of triangles: a closed surface whose area, normals and distances are known."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh


def sphere(rounds: int = 2, radius: float = 1.0) -> Mesh:
    """Return an octahedron, faces outward, each split in four `rounds` times and pushed out to the
    radius.
    """
    vertices = np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array(
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    )
    for _ in range(rounds):
        edges, number = np.unique(
            np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1),
            axis=0,
            return_inverse=True,
        )
        p, q, r = (len(vertices) + number.reshape(-1, 3)).T
        a, b, c = faces.T
        vertices = np.vstack([vertices, vertices[edges].sum(axis=1)])
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
        faces = np.vstack(
            [np.stack(corner, axis=1) for corner in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))]
        )
    return Mesh(radius * vertices, faces.astype(np.int32))
