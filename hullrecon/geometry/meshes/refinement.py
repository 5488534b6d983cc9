# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Midpoint subdivision of a mesh, without cracks, until its edges are short [Ozog2016 3.2.2.1]."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.rows import blocks_of_rows
from hullrecon.typing import Array, Ints, Mask

# Two angles opposite an edge count as half a turn, and the edge is not flipped, if the sine of
# their sum is smaller
FLAT = 1e-9
# Passes of flips after a split. Lawson's flips end by themselves, except for rounding in nearly
# degenerate faces.
MOST_PASSES = 60
EDGES_AT_ONCE = 1 << 18  # whose end points, and vectors between them, are in memory


def refine(
    mesh: Mesh,
    longest_m: float | Callable[[Array], Array],
    attributes: Array | None = None,
    spared_m: float = 0.0,
) -> tuple[Mesh, Array]:
    """Split edges at their midpoints until none is longer than wanted.

    Neighbouring faces split their common edge together, so no crack opens. The longest edges are
    split first, and edges of the old faces before edges inside them. Inside every old face the new
    faces are kept a Delaunay triangulation. So a long narrow face, as CAD programs export them, is
    cut across and not into many narrow faces.

    Parameters
    ----------
    mesh
        Its vertices are the first of the result, unmoved.
    longest_m
        The longest edge allowed, or a function that gives it for the edges' midpoints (n, 3),
        inf where the mesh may stay coarse.
    attributes
        (n, k) of the vertices, averaged at midpoints.
    spared_m
        Edges up to this length are never split.

    Returns
    -------
    mesh, attributes
        The refined mesh, and the attributes of its vertices.
    """
    table = np.hstack(
        [mesh.vertices, np.zeros((len(mesh.vertices), 0)) if attributes is None else attributes]
    )
    faces, old_face = mesh.faces.astype(np.int64), np.arange(len(mesh.faces))
    limits = _Limits(longest_m, spared_m)
    while True:
        edge, of_face = _edges(faces)
        marked = _mark_edges(table[:, :3], edge, of_face, old_face, limits)
        if not marked.any():
            return Mesh(table[:, :3].copy(), faces.astype(np.int32)), table[:, 3:].copy()
        # A new vertex in the middle of each marked edge
        middle = np.full(len(edge), -1)
        middle[marked] = len(table) + np.arange(marked.sum())
        table = np.vstack([table, table[edge[marked]].mean(axis=1)])
        split = marked[of_face].any(axis=1)
        parts, of_part = _split_faces(
            faces[split], old_face[split], middle[of_face[split]], table[:, :3]
        )
        faces = np.vstack([faces[~split], parts])
        old_face = np.concatenate([old_face[~split], of_part])
        _flip_edges(faces, old_face, np.isin(old_face, of_part), table[:, :3])


class _Limits:
    """Largest lengths of edges. The limit of an edge is computed once and kept."""

    def __init__(self, longest_m: float | Callable[[Array], Array], spared_m: float) -> None:
        self._longest_m, self._spared_m = longest_m, spared_m
        self._key: Ints = np.zeros(0, np.int64)
        self._limit: Array = np.zeros(0)

    def exceeded(self, edge: Ints, vertices: Array, length: Array) -> Mask:
        """Tell which edges (e, 2) between vertices (n, 3), of lengths (e,), are too long.

        Limits of the edges asked for last are kept, as most edges are asked for again after a
        split.
        """
        if not callable(self._longest_m):
            return np.asarray(length > max(self._longest_m, self._spared_m))
        asked = np.flatnonzero(length > self._spared_m)
        key = edge[asked, 0] << 32 | edge[asked, 1]
        limit = np.full(len(key), np.nan)
        _, old, new = np.intersect1d(self._key, key, assume_unique=True, return_indices=True)
        limit[new] = self._limit[old]
        unknown = np.flatnonzero(np.isnan(limit))
        limit[unknown] = self._longest_m(vertices[edge[asked[unknown]]].mean(axis=1))
        self._key, self._limit = key, limit
        out = np.zeros(len(edge), bool)
        out[asked] = length[asked] > limit
        return out


def _edges(faces: Ints) -> tuple[Ints, Ints]:
    """Find the unique edges (e, 2) of faces (m, 3), lower vertex first.

    Also returned are the rows (m, 3) of each face's edges 0-1, 1-2, 2-0 among them.
    """
    size = int(faces.max()) + 1 if len(faces) else 1
    following = np.roll(faces, -1, axis=1)
    both = np.minimum(faces, following)  # lower * size + higher, with few arrays of all corners
    both *= size
    both += np.maximum(faces, following, out=following)
    key, back = np.unique(both, return_inverse=True)
    return np.stack([key // size, key % size], axis=1), back.reshape(-1, 3)


def _mark_edges(
    vertices: Array, edge: Ints, of_face: Ints, old_face: Ints, limits: _Limits
) -> Mask:
    """Tell which edges (e,) are split next. None where the mesh is fine enough.

    Of the edges that are too long, they are those within a factor of two of the longest. If edges
    of old faces are among them, these are split first.

    Parameters
    ----------
    vertices, edge
        Positions (n, 3), and edges (e, 2).
    of_face
        Rows (m, 3) of each face's edges.
    old_face
        Face (m,) of the mesh before refinement from which each face was cut.
    limits
        Largest length allowed for each edge.
    """
    length = np.empty(len(edge))
    for rows in blocks_of_rows(len(edge), EDGES_AT_ONCE):
        ends = vertices[edge[rows]]
        length[rows] = _lengths(ends[:, 1] - ends[:, 0])
    marked = limits.exceeded(edge, vertices, length)
    if not marked.any():
        return marked
    # The limit is the largest power of two that is not above the longest
    marked &= length >= np.ldexp(1.0, np.frexp(length[marked].max())[1] - 1)
    inside, _ = _inner_edges(of_face, old_face, len(edge))
    outer = marked.copy()
    outer[inside] = False
    return _close_marks(outer if outer.any() else marked, length[of_face], of_face)


def _close_marks(marked: Mask, length: Array, of_face: Ints) -> Mask:
    """Mark the longest edge of a face too, where it is over twice as long as a marked edge of it.

    Otherwise fans of narrow faces would form towards parts where the mesh may stay coarse.

    Parameters
    ----------
    marked
        Edges (e,) that are split.
    length, of_face
        Lengths (m, 3) and rows (m, 3) of each face's edges.
    """
    longest = of_face[np.arange(len(of_face)), np.argmax(length, axis=1)]
    steep = length.max(axis=1)[:, None] > 2 * length
    while True:
        follow = longest[(marked[of_face] & steep).any(axis=1)]
        if marked[follow].all():
            return marked
        marked[follow] = True


def _inner_edges(of_face: Ints, old_face: Ints, count: int) -> tuple[Ints, Ints]:
    """Find the edges between two faces that were cut from the same old face.

    Only these may be flipped, as all others are of the old mesh.

    Parameters
    ----------
    of_face
        Rows (m, 3) of each face's edges.
    old_face
        Face (m,) from which each face was cut.
    count
        Number of edges.

    Returns
    -------
    edges, places
        Rows (k,) of these edges, and where the two faces have each, (k, 2) as 3 * face + corner.
    """
    flat = of_face.ravel()
    place = np.argsort(flat, kind="stable")
    start = np.searchsorted(flat[place], np.arange(count))
    twice = np.flatnonzero(np.bincount(flat, minlength=count) == 2)
    pair = np.stack([place[start[twice]], place[start[twice] + 1]], axis=1)
    one = old_face[pair[:, 0] // 3] == old_face[pair[:, 1] // 3]
    return twice[one], pair[one]


def _split_faces(faces: Ints, old_face: Ints, middle: Ints, vertices: Array) -> tuple[Ints, Ints]:
    """Split faces at the new vertices on their edges.

    Parameters
    ----------
    faces, old_face
        Faces (m, 3), and the old face (m,) from which each was cut.
    middle
        New vertex (m, 3) on each face's edges 0-1, 1-2 and 2-0. -1 where an edge is not split.
    vertices
        Positions (n, 3), new vertices included.

    Returns
    -------
    parts, old_face
        Faces (k, 3), and the old face (k,) of each.
    """
    # Corners a, b, c, and new vertices p on a-b, q on b-c, r on c-a. Faces are turned so that the
    # edges which are split come first.
    count = (middle >= 0).sum(axis=1)
    first_split = np.argmax(middle >= 0, axis=1)
    a, b, c, p, _, _ = _turn_faces(faces, middle, count == 1, first_split)
    halves = [(a, p, c), (p, b, c)]

    # Two new vertices leave a quadrilateral a, p, q, c: cut it along its shorter diagonal.
    after_whole = np.argmax(middle < 0, axis=1) + 1
    a, b, c, p, q, _ = _turn_faces(faces, middle, count == 2, after_whole)
    short = np.linalg.norm(vertices[a] - vertices[q], axis=1) < np.linalg.norm(
        vertices[p] - vertices[c], axis=1
    )
    thirds = [(p, b, q), (a, p, np.where(short, q, c)), (np.where(short, a, p), q, c)]

    a, b, c, p, q, r = _turn_faces(faces, middle, count == 3, np.zeros(len(faces), np.int64))
    quarters = [(a, p, r), (p, b, q), (r, q, c), (p, q, r)]
    parts = np.vstack([np.stack(corner, axis=1) for corner in halves + thirds + quarters])
    of = [np.tile(old_face[count == n], n + 1) for n in (1, 2, 3)]
    return parts, np.concatenate(of)


def _turn_faces(faces: Ints, middle: Ints, which: Mask, first: Ints) -> Ints:
    """Rotate the corners of some faces so that the edge `first` becomes 0-1.

    faces, middle: (m, 3) corners, and the vertex in the middle of each edge. Returns (6, k): three
    corners and three middles of each of the faces `which`.
    """
    turn = (first[which, None] + np.arange(3)) % 3
    return np.hstack(
        [np.take_along_axis(faces[which], turn, 1), np.take_along_axis(middle[which], turn, 1)]
    ).T


def _flip_edges(faces: Ints, old_face: Ints, which: Mask, vertices: Array) -> None:
    """Flip edges of faces, in place, until the parts of every old face are Delaunay [Lawson1977].

    Parts of one old face lie in a plane, so that a flip does not change the surface. Only old faces
    with a part in `which` are looked at. faces: (m, 3). old_face: (m,) of which each is a part.
    vertices: (n, 3).
    """
    for _ in range(MOST_PASSES):
        # Edges between two parts of one old face, with the corner opposite to each on either side.
        active = np.flatnonzero(which)
        edge, of_face = _edges(faces[active])
        inside, pair = _inner_edges(of_face, old_face[active], len(edge))
        face, corner = active[pair // 3], pair % 3
        opposite = faces[face, (corner + 2) % 3]
        # Flip the worst edge of both its faces, in one pass each face at most once.
        excess = _angle_excess(vertices, edge[inside], opposite)
        worst = np.zeros(len(faces))
        np.maximum.at(worst, face.ravel(), np.repeat(excess, 2))
        worst_beside = np.maximum(worst[face[:, 0]], worst[face[:, 1]])
        chosen = np.flatnonzero((excess > FLAT) & (excess >= worst_beside))
        first = _one_by_face(face[chosen], len(faces))
        chosen = chosen[first]
        if not len(chosen):
            return
        which = np.isin(old_face, old_face[face[chosen, 0]])  # the others are done
        flipped, (c, d) = face[chosen], opposite[chosen].T
        a = faces[flipped[:, 0], corner[chosen, 0]]
        b = faces[flipped[:, 0], (corner[chosen, 0] + 1) % 3]
        faces[flipped[:, 0]] = np.stack([a, d, c], axis=1)
        faces[flipped[:, 1]] = np.stack([d, b, c], axis=1)


def _angle_excess(vertices: Array, edge: Ints, opposite: Ints) -> Array:
    """Compute minus the sine (k,) of the sum of the two angles opposite each edge.

    It is positive where the sum is above half a turn, so that the edge has to be flipped.

    edge (k, 2): vertices. opposite (k, 2): the third vertices of its two faces.
    """
    out = np.empty(len(edge))
    for rows in blocks_of_rows(len(edge), EDGES_AT_ONCE):
        a, b = vertices[edge[rows, 0]], vertices[edge[rows, 1]]
        cosine, sine = np.zeros((2, len(a))), np.zeros((2, len(a)))
        for side in (0, 1):
            at = vertices[opposite[rows, side]]
            to_a, to_b = a - at, b - at
            size = _lengths(to_a) * _lengths(to_b)
            size = np.where(size > 0, size, 1.0)
            cosine[side] = np.einsum("ij,ij->i", to_a, to_b) / size
            sine[side] = _lengths(np.cross(to_a, to_b)) / size
        out[rows] = -(cosine[0] * sine[1] + sine[0] * cosine[1])
    return out


def _lengths(vectors: Array) -> Array:
    """Compute the lengths (n,) of vectors (n, 3), in a third of the time of numpy's norm."""
    x, y, z = vectors.T
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def _one_by_face(face: Ints, count: int) -> Ints:
    """Choose rows (k,) of pairs of faces (n, 2) so that no face is in two pairs."""
    owner = np.full(count, len(face))
    for side in (0, 1):
        np.minimum.at(owner, face[:, side], np.arange(len(face)))
    return np.flatnonzero((owner[face] == np.arange(len(face))[:, None]).all(axis=1))
