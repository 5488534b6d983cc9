# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Turn normals outward: one winding within each connected piece, then each piece to its open side.

The signed volume of a closed piece tells which side is outside. An open piece (a half hull, a hull
without deck, a patch of bottom plate) has none. Rays decide there: from its outer side more of
them escape than from its inner side, where the rest of the hull stops them.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from hullrecon.dive.hull.mirrors import Plane, find_possible_cuts, reflect_mesh
from hullrecon.findings.finding import Finding
from hullrecon.geometry.meshes.mesh import Mesh, face_areas, face_normals
from hullrecon.geometry.meshes.topology import SharedEdges, find_edges, find_shared_edges
from hullrecon.typing import Array, Ints, Ints32, Mask

SAMPLES = 200  # faces of a piece from which rays start
# open pieces that are judged by rays, the largest first; smaller ones have no clear outer side
MOST_PIECES = 20_000
RAYS = 32  # directions over the hemisphere of each side
LIFT = 1e-5  # of the largest extent: how far from its face a ray starts
CLEAR = 0.05  # difference of the escaping shares below which a piece's outer side is unclear


def orient_outward(mesh: Mesh, notes: list[Finding]) -> Mesh:
    """Wind every face counter-clockwise as seen from outside, so that normals point outward.

    Added to notes is how many faces were turned, how many pieces have no clear outer side, and at
    how many edges no winding makes both faces agree.
    """
    shared = find_shared_edges(mesh.faces)
    piece, sign = _unify_winding(len(mesh.faces), shared)
    faces = _flip_faces(mesh.faces, sign < 0)
    side = _find_outer_sides(Mesh(mesh.vertices, faces), piece)
    flip = (side < 0)[piece]
    turned, unclear = int(((sign < 0) ^ flip).sum()), int((np.abs(side) < CLEAR).sum())
    twisted = int(((sign[shared.first] == sign[shared.second]) != shared.same_winding).sum())
    if turned:
        notes.append(Finding("mesh-faces-turned", {"turned": turned, "count": len(faces)}))
    if unclear:
        notes.append(Finding("mesh-pieces-unclear", {"unclear": unclear, "count": len(side)}))
    if twisted:
        notes.append(Finding("mesh-edges-twisted", {"count": twisted}))
    return Mesh(mesh.vertices, _flip_faces(faces, flip))


def _unify_winding(count: int, shared: SharedEdges) -> tuple[Ints32, Ints]:
    """Label the connected piece of each face, and tell which faces are wound against the others.

    The sign is passed on from face to face by a breadth-first search from the first face of each
    piece.

    Parameters
    ----------
    count : number of faces
    shared : edges of two faces each, with whether both faces wind alike

    Returns
    -------
    piece (count,), and sign (count,): 1 where a face winds as the first of its piece, else -1
    """
    pairs = np.stack([shared.first, shared.second], axis=1)
    agree = np.where(shared.same_winding, 1, -1)
    graph = coo_matrix(
        (np.ones(len(pairs)), (shared.first, shared.second)), shape=(count, count)
    ).tocsr()
    piece = connected_components(graph, directed=False)[1]
    relation = dict(zip(map(tuple, pairs.tolist()), agree.tolist(), strict=True))
    # One search for all pieces, from a node beyond the faces that leads to the first face of each:
    # a mesh may have as many pieces as faces.
    root, first = count, np.unique(piece, return_index=True)[1]
    rows, columns = np.r_[shared.first, np.full(len(first), root)], np.r_[shared.second, first]
    joined = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(count + 1, count + 1)).tocsr()
    order, parent = breadth_first_order(joined, root, directed=False)
    sign = np.ones(count, np.int64)
    for face, above in zip(order[1:].tolist(), parent[order[1:]].tolist(), strict=True):
        if above != root:
            sign[face] = sign[above] * (relation.get((above, face)) or relation[face, above])
    return piece, sign


def _find_outer_sides(mesh: Mesh, piece: Ints32) -> Array:
    """Rate each piece (p,) from -1 (normals point inward) to 1 (outward), near 0 where unclear.

    Closed pieces are rated by the sign of their volume, open ones by rays.
    """
    corners = mesh.vertices[mesh.faces] - 0.5 * (
        mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)
    )
    volume = np.bincount(
        piece, np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    )
    edges = find_edges(mesh.faces)
    unpaired = (edges.face_count[edges.of_face] != 2).any(axis=1)
    is_open = np.bincount(piece, unpaired) > 0
    side = np.sign(volume)
    size = np.bincount(piece, face_areas(mesh)) * is_open
    picked = sample_faces(
        mesh,
        piece,
        np.sort(np.argsort(-size, kind="stable")[: min(int(is_open.sum()), MOST_PIECES)]),
    )
    return np.where(is_open, _measure_sides(mesh, piece, picked), side) if len(picked) else side


def _measure_sides(mesh: Mesh, piece: Ints32, picked: Ints) -> Array:
    """Compare the shares of rays that escape in front of and behind each piece's picked faces.

    Through an open end rays escape from the inner side too. Where the hull may have been cut at a
    plane, its reflection there is therefore added for the rays, and kept if it makes the difference
    between the two sides clearer. Planes are tried until none does.

    Parameters
    ----------
    mesh : whole CAD model
    piece : (m,) piece of each face
    picked : (k,) faces from which rays start

    Returns
    -------
    (p,) share in front minus share behind, 0 for pieces without a picked face
    """
    count = np.maximum(1, np.bincount(piece[picked], minlength=int(piece.max()) + 1))
    weight = np.bincount(piece, face_areas(mesh)) * (
        np.bincount(piece[picked], minlength=len(count)) > 0
    )

    def measure(planes: list[Plane]) -> tuple[float, Array]:
        """Measure how clear the sides are, averaged by area, and the difference of each piece."""
        whole = reflect_mesh(mesh, planes)
        share = _share_escaping(whole, picked, 1.0) - _share_escaping(whole, picked, -1.0)
        mean = np.bincount(piece[picked], share, len(count)) / count
        return float(weight @ np.abs(mean) / weight.sum()), mean

    planes: list[Plane] = []
    clearest, difference = measure(planes)
    cuts = find_possible_cuts(mesh)
    while cuts:
        tried = [(*measure([*planes, cut]), cut) for cut in cuts]
        score, mean, cut = max(tried, key=lambda t: t[0])
        if score < clearest + CLEAR:
            break
        clearest, difference, planes = score, mean, [*planes, cut]
        cuts = [c for c in cuts if c[0] != cut[0]]
    return difference


def sample_faces(mesh: Mesh, piece: Ints32, wanted: Ints) -> Ints:
    """Pick up to SAMPLES faces of each wanted piece, evenly over its area.

    Parameters
    ----------
    mesh : the mesh, whose face areas count
    piece : (m,) piece of each face
    wanted : (w,) pieces from which faces are picked

    Returns
    -------
    rows of faces (k,)
    """
    area = face_areas(mesh)
    order = np.argsort(piece, kind="stable")
    start = np.searchsorted(piece[order], np.arange(int(piece.max()) + 2))
    out = [np.zeros(0, np.int64)]
    for number in wanted:
        rows = order[start[number] : start[number + 1]]
        share = np.cumsum(area[rows]) / area[rows].sum()
        out.append(rows[np.unique(np.searchsorted(share, (np.arange(SAMPLES) + 0.5) / SAMPLES))])
    return np.concatenate(out)


def _share_escaping(whole: Mesh, picked: Ints, side: float) -> Array:
    """Measure the share of rays from each picked face that hit nothing of the hull.

    side: 1 for the faces' front, -1 for their back.
    """
    normal = side * face_normals(Mesh(whole.vertices, whole.faces[picked]))
    lift = LIFT * float(np.ptp(whole.vertices, axis=0).max())
    origin = np.repeat(
        whole.vertices[whole.faces[picked]].mean(axis=1) + lift * normal, RAYS, axis=0
    )
    hits = whole.index.cast(origin, _hemisphere(normal))
    return np.asarray((hits.face < 0).reshape(-1, RAYS).mean(axis=1))


def _hemisphere(normal: Array) -> Array:
    """Spread directions (n * RAYS, 3) about each normal (n, 3), cosine-weighted, in one pattern.

    The pattern is a golden spiral on the disc, lifted to the half sphere.
    """
    k = np.arange(RAYS) + 0.5
    radius, angle = np.sqrt(k / RAYS), np.pi * (1 + 5**0.5) * k
    local = np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - k / RAYS)], axis=1
    )
    return np.asarray(np.einsum("kj,nji->nki", local, frames_about(normal)).reshape(-1, 3))


def frames_about(normal: Array) -> Array:
    """Make axes (n, 3, 3), in rows, whose last is the unit normal (n, 3). The others are any."""
    helper = np.where(np.abs(normal[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normal, first), normal], axis=1)


def _flip_faces(faces: Ints32, which: Mask) -> Ints32:
    """Reverse the winding of the faces of the mask."""
    out = faces.copy()
    out[which] = out[which][:, ::-1]
    return out
