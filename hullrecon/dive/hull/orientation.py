# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Normals outward: winding made one within each piece, then each piece turned to the side from which the open sea is seen.

A closed piece has a signed volume. An open one (a half hull, a hull without deck, a patch of bottom plate) has not; but rays
from its outer side escape in more directions than rays from its inner side, which the rest of the hull stops.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from hullrecon.dive.hull.mirrors import Plane, possible_cuts, reflected
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Ints, Ints32, Mask

SAMPLES = 200  # faces of a piece from which rays start
RAYS = 32  # directions over the hemisphere of each side
LIFT = 1e-5  # of the largest extent: how far from its face a ray starts
CLEAR = 0.05  # difference of the escaping shares below which a piece's side is in doubt


def outward(mesh: Mesh, words: list[str]) -> Mesh:
    """The mesh with every face counter-clockwise seen from outside; what was turned, and what is in doubt, goes to words."""
    neighbours, agree = _adjacency(mesh.faces)
    piece, sign = _consistent(len(mesh.faces), neighbours, agree)
    faces = _turned(mesh.faces, sign < 0)
    side = _sides(mesh.vertices, faces, piece)
    flip = (side < 0)[piece]
    turned, doubtful = int(((sign < 0) ^ flip).sum()), int((np.abs(side) < CLEAR).sum())
    broken = int((sign[neighbours[:, 0]] * sign[neighbours[:, 1]] != agree).sum())
    if turned:
        words.append(f"{turned} of {len(faces)} faces had their normals inward and were turned")
    if doubtful:
        words.append(f"{doubtful} of {len(side)} separate pieces have no clear outer side")
    if broken:
        words.append(f"{broken} edges join faces that cannot be wound alike")
    return Mesh(mesh.vertices, _turned(faces, flip))


def _adjacency(faces: Ints32) -> tuple[Ints, Ints]:
    """Pairs of faces (k, 2) that share an edge which no third face has; +1 where they are wound alike, -1 where not."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    key, forward = np.sort(edges, axis=1), edges[:, 0] < edges[:, 1]
    _, number, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    shared = np.flatnonzero(count[number.ravel()] == 2)
    pairs = shared[np.argsort(number.ravel()[shared], kind="stable")].reshape(-1, 2)
    agree = np.where(forward[pairs[:, 0]] != forward[pairs[:, 1]], 1, -1)
    return pairs // 3, agree


def _consistent(count: int, pairs: Ints, agree: Ints) -> tuple[Ints32, Ints]:
    """Piece of each face, and the sign that winds every piece like its first face."""
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count)).tocsr()
    pieces, piece = connected_components(graph, directed=False)
    relation = dict(zip(map(tuple, pairs.tolist()), agree.tolist(), strict=True))
    sign = np.ones(count, np.int64)
    first = np.unique(piece, return_index=True)[1]
    for number in range(pieces):
        order, parent = breadth_first_order(graph, int(first[number]), directed=False)
        for face in order[1:].tolist():
            above = int(parent[face])
            sign[face] = sign[above] * (relation.get((above, face)) or relation[face, above])
    return piece, sign


def _sides(vertices: Array, faces: Ints32, piece: Ints32) -> Array:
    """Of each piece: positive where its normals point outward, negative where inward; between -1 and 1."""
    corners = vertices[faces] - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    volume = np.bincount(piece, np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, number, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    unpaired = (count[number.ravel()] != 2).reshape(-1, 3).any(axis=1)
    is_open = np.bincount(piece, unpaired) > 0
    side = np.sign(volume)
    picked = _spread(vertices, faces, piece, np.flatnonzero(is_open))
    if len(picked):
        side = np.where(is_open, _seen(Mesh(vertices, faces), piece, picked), side)
    return side


def _seen(mesh: Mesh, piece: Ints32, picked: Ints) -> Array:
    """Of each piece, how much more its picked faces see in front than behind. A hull that was cut at a plane is made whole
    there, if that makes the difference clearer."""
    count = np.maximum(1, np.bincount(piece[picked], minlength=int(piece.max()) + 1))
    weight = np.bincount(piece, _areas(mesh.vertices, mesh.faces)) * (np.bincount(piece[picked], minlength=len(count)) > 0)

    def measure(planes: list[Plane]) -> tuple[float, Array]:
        whole = reflected(mesh, planes)
        share = _escaping(whole, picked, 1.0) - _escaping(whole, picked, -1.0)
        mean = np.bincount(piece[picked], share, len(count)) / count
        return float(weight @ np.abs(mean) / weight.sum()), mean

    planes: list[Plane] = []
    best, seen = measure(planes)
    cuts = possible_cuts(mesh)
    while cuts:
        tried = [(*measure([*planes, cut]), cut) for cut in cuts]
        score, mean, cut = max(tried, key=lambda t: t[0])
        if score < best + CLEAR:
            break
        best, seen, planes = score, mean, [*planes, cut]
        cuts = [c for c in cuts if c[0] != cut[0]]
    return seen


def _spread(vertices: Array, faces: Ints32, piece: Ints32, wanted: Ints) -> Ints:
    """Up to SAMPLES faces of each wanted piece, spread over its area."""
    area = _areas(vertices, faces)
    order = np.argsort(piece, kind="stable")
    start = np.searchsorted(piece[order], np.arange(int(piece.max()) + 2))
    out = [np.zeros(0, np.int64)]
    for number in wanted:
        mine = order[start[number] : start[number + 1]]
        share = np.cumsum(area[mine]) / area[mine].sum()
        out.append(mine[np.unique(np.searchsorted(share, (np.arange(SAMPLES) + 0.5) / SAMPLES))])
    return np.concatenate(out)


def _escaping(whole: Mesh, picked: Ints, way: float) -> Array:
    """Of each picked face, the share of the rays from one side of it that meet nothing of the whole hull."""
    from hullrecon.native import MeshIndex

    vertices, faces = whole.vertices, whole.faces
    a, b, c = (vertices[faces[picked, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal *= way / np.linalg.norm(normal, axis=1, keepdims=True)
    lift = LIFT * float(np.ptp(vertices, axis=0).max())
    origin = np.repeat((a + b + c) / 3 + lift * normal, RAYS, axis=0)
    hits = MeshIndex(vertices, faces).cast(origin, _hemisphere(normal))
    return np.asarray((hits.face < 0).reshape(-1, RAYS).mean(axis=1))


def _hemisphere(normal: Array) -> Array:
    """(n * RAYS, 3) unit directions about each normal (n, 3), cosine-weighted, the same for each."""
    k = np.arange(RAYS) + 0.5
    radius, angle = np.sqrt(k / RAYS), np.pi * (1 + 5**0.5) * k
    local = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - k / RAYS)], axis=1)
    helper = np.where(np.abs(normal[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    frame = np.stack([first, np.cross(normal, first), normal], axis=1)
    return np.asarray(np.einsum("kj,nji->nki", local, frame).reshape(-1, 3))


def _areas(vertices: Array, faces: Ints32) -> Array:
    """(m,) twice the area of each face."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1))


def _turned(faces: Ints32, which: Mask) -> Ints32:
    out = faces.copy()
    out[which] = out[which][:, ::-1]
    return out
