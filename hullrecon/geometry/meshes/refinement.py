# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Midpoint subdivision of a mesh until its edges are short enough where it matters [Ozog2016 3.2.2.1], without cracks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Ints, Mask


def refine(
    mesh: Mesh, longest_m: float | Callable[[Array], Array], attributes: Array | None = None, spared_m: float = 0.0
) -> tuple[Mesh, Array]:
    """Return the mesh with edges split at their midpoints until none is longer than wanted.

    longest_m: the longest edge allowed, metres; a function gives it at the edges' midpoints (n, 3), inf where the mesh may stay
    coarse; no edge up to `spared_m` is asked about. Neighbouring faces split their common edge together, so no crack opens;
    with an edge a face splits its longest edge too, so that triangles do not degenerate. attributes (n, k) of the vertices are
    averaged along; returned with the mesh. The first vertices are the old ones, unmoved.
    """
    table = np.hstack([mesh.vertices, np.zeros((len(mesh.vertices), 0)) if attributes is None else attributes])
    faces = mesh.faces.astype(np.int64)
    while True:
        edge, of_face = _edges(faces)
        marked = _mark_edges(table[:, :3], edge, of_face, longest_m, spared_m)
        if not marked.any():
            return Mesh(table[:, :3].copy(), faces.astype(np.int32)), table[:, 3:].copy()
        middle = np.full(len(edge), -1)
        middle[marked] = len(table) + np.arange(marked.sum())
        table = np.vstack([table, table[edge[marked]].mean(axis=1)])
        faces = _split_faces(faces, middle[of_face], table[:, :3])


def _edges(faces: Ints) -> tuple[Ints, Ints]:
    """Return unique edges (e, 2), and for each face the number of the edges 0-1, 1-2, 2-0 (m, 3)."""
    pairs = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    size = int(faces.max()) + 1 if len(faces) else 1
    key, back = np.unique(pairs[:, 0] * size + pairs[:, 1], return_inverse=True)
    return np.stack([key // size, key % size], axis=1), back.reshape(-1, 3)


def _mark_edges(
    vertices: Array, edge: Ints, of_face: Ints, longest_m: float | Callable[[Array], Array], spared_m: float
) -> Mask:
    """Return the edges to split (e,): the long ones, and the longest edge of every face that splits any."""
    ends = vertices[edge]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    marked = np.zeros(len(edge), bool)
    asked = np.flatnonzero(length > spared_m)
    marked[asked] = length[asked] > (longest_m(ends[asked].mean(axis=1)) if callable(longest_m) else longest_m)
    if not marked.any():
        return marked
    longest = of_face[np.arange(len(of_face)), np.argmax(length[of_face], axis=1)]
    while True:
        follow = longest[marked[of_face].any(axis=1)]
        if marked[follow].all():
            return marked
        marked[follow] = True


def _split_faces(faces: Ints, middle: Ints, vertices: Array) -> Ints:
    """Return faces (m, 3) split at the new vertices on their edges 0-1, 1-2, 2-0 (m, 3), -1 where an edge stays whole."""
    count = (middle >= 0).sum(axis=1)
    one = _turn_faces(faces, middle, count == 1, np.argmax(middle >= 0, axis=1))
    two = _turn_faces(faces, middle, count == 2, np.argmax(middle < 0, axis=1) + 1)
    a, b, c, p, _, _ = one
    halves = [(a, p, c), (p, b, c)]
    a, b, c, p, q, _ = two
    short = np.linalg.norm(vertices[a] - vertices[q], axis=1) < np.linalg.norm(vertices[p] - vertices[c], axis=1)
    thirds = [(p, b, q), (a, p, np.where(short, q, c)), (np.where(short, a, p), q, c)]
    a, b, c, p, q, r = _turn_faces(faces, middle, count == 3, np.zeros(len(faces), np.int64))
    quarters = [(a, p, r), (p, b, q), (r, q, c), (p, q, r)]
    return np.vstack([faces[count == 0], *(np.stack(corner, axis=1) for corner in halves + thirds + quarters)])


def _turn_faces(faces: Ints, middle: Ints, which: Mask, first: Ints) -> Ints:
    """Return corners and middles of some faces, turned so that edge `first` becomes 0-1: (6, k)."""
    turn = (first[which, None] + np.arange(3)) % 3
    return np.hstack([np.take_along_axis(faces[which], turn, 1), np.take_along_axis(middle[which], turn, 1)]).T
