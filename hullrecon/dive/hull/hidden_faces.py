# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Leave out faces that nothing outside the hull sees: inner sides of plates, tanks, structure.

A beam of the DVL meets the outer skin, but the face closest to where it ends may lie behind that:
the inner side of the plate, or a frame. A face counts as seen if rays from it leave the mesh. One
ray in a thousand slips through the gaps between plates that share no corners, so one ray alone
proves nothing.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hullrecon.dive.hull.mirrors import find_openings, reflect_mesh
from hullrecon.dive.hull.orientation import frames_about, sample_faces
from hullrecon.findings.finding import Finding
from hullrecon.geometry.meshes.mesh import Mesh, face_areas, face_normals
from hullrecon.geometry.meshes.topology import SharedEdges, find_shared_edges
from hullrecon.typing import Array, Ints, Mask

LIFT = 1e-6  # of the largest extent: how far from its face a ray starts, 0.3 mm at 300 m
INNER = 0.8  # of a face, about its middle, from which rays start: edges may stick through a plate
# Rays to each side of a face, and how many of them have to leave the mesh. FIRST is for all faces,
# NEXT for some that are not seen yet, NEXT and LAST for those beside a seen face. LAST finds a face
# that is open to 2 % of the directions with a probability of 88 %. It takes one hidden face in 500
# for seen where one ray in a thousand slips through.
FIRST, NEXT, LAST = (2, 2), (16, 2), (256, 3)
MOST_RINGS = 100  # of faces, from one into its neighbours, that a recess is followed inward
AT_ONCE = 2_000_000  # rays: 0.1 GB
# of the area; hidden faces of less, as in the hubs of propellers, are not left out
LEAST_SHARE = 1e-5
THICKEST_M = 0.1  # of a plate; shells of ships have 6 to 40 mm
GOLDEN = 1.1673039782614187  # root of x**5 = x + 1: the golden ratio of a sequence in 4 dimensions


def leave_out_hidden(mesh: Mesh, notes: list[Finding]) -> Mesh:
    """Keep the faces that are seen from outside. How many were left out is added to notes.

    Measurements are matched to the closest face, which has to be one that a sensor can see.
    Faces that are seen only through an open end of the mesh (a half hull, a hull without deck) are
    kept too, except where they are the inner side of a plate whose outer side is seen when that end
    is closed by reflection. The mesh is returned unchanged where hardly any face is hidden, or all
    are.
    """
    seen = find_seen(mesh, mesh)
    openings = find_openings(mesh)
    if openings and ((close := _find_close_faces(mesh))[seen] >= 0).any():
        from_elsewhere = find_seen(mesh, reflect_mesh(mesh, openings))
        # close faces that are seen from elsewhere than the open end: outer sides of a plate
        behind = (close >= 0) & from_elsewhere[close]
        seen &= from_elsewhere | ~behind.any(axis=1)
    area = face_areas(mesh)
    if area[~seen].sum() < LEAST_SHARE * area.sum() or not seen.any():
        return mesh
    hidden = int((~seen).sum())
    notes.append(Finding("mesh-faces-hidden", {"hidden": hidden, "count": len(mesh.faces)}))
    used, renumbered = np.unique(mesh.faces[seen], return_inverse=True)
    return Mesh(mesh.vertices[used], renumbered.reshape(-1, 3).astype(np.int32))


def find_seen(mesh: Mesh, whole: Mesh) -> Mask:
    """Find the faces (m,) of a mesh that are seen from outside, by casting rays from them.

    All faces are tested with few rays. Of each connected patch of unseen faces some are tested with
    more, as a few rays miss narrow openings. Then the neighbours of seen faces are tested, ring by
    ring, so that recesses are followed inward. A face with three seen neighbours counts as seen.

    Parameters
    ----------
    mesh : the mesh whose faces are tested
    whole : what stops the rays: the mesh, or the mesh completed by reflection. Its first faces are
        those of the mesh
    """
    seen = _are_seen(mesh, whole, np.arange(len(mesh.faces)), *FIRST)
    if seen.all():
        return seen
    shared = find_shared_edges(mesh.faces)
    rows = _sample_unseen(mesh, shared, seen)
    seen[rows] = _are_seen(mesh, whole, rows, *NEXT)
    face = np.concatenate([shared.first, shared.second])
    neighbour = np.concatenate([shared.second, shared.first])
    tried = seen.copy()
    for _ in range(MOST_RINGS):
        rows = np.unique(face[seen[neighbour] & ~tried[face]])
        if not len(rows):
            break
        tried[rows] = True
        for effort in (NEXT, LAST):
            left = rows[~seen[rows]]
            seen[left] = _are_seen(mesh, whole, left, *effort)
    beside = np.bincount(face, seen[neighbour], minlength=len(seen))
    return np.asarray(seen | (beside == 3))


def _sample_unseen(mesh: Mesh, shared: SharedEdges, seen: Mask) -> Ints:
    """Pick rows (k,) of unseen faces, evenly over the area of each connected patch of them.

    Testing these finds a patch that is seen after all, without testing all of its faces.
    """
    both = ~seen[shared.first] & ~seen[shared.second]
    pairs = (np.ones(int(both.sum())), (shared.first[both], shared.second[both]))
    patch = connected_components(coo_matrix(pairs, shape=(len(seen), len(seen))), directed=False)[1]
    return sample_faces(mesh, patch, np.unique(patch[~seen]))


def _are_seen(mesh: Mesh, whole: Mesh, rows: Ints, rays: int, enough: int) -> Mask:
    """Find faces from which enough rays leave the mesh, on one side or the other.

    Parameters
    ----------
    mesh, whole : as of find_seen
    rows : (k,) faces to test
    rays : number of rays cast from each side of a face
    enough : number of these that have to hit nothing, for the face to count as seen

    Returns
    -------
    mask (k,)
    """
    out = np.zeros(len(rows), bool)
    block = AT_ONCE // rays
    for start in range(0, len(rows), block):
        part = rows[start : start + block]
        normal = face_normals(Mesh(mesh.vertices, mesh.faces[part]))
        for side in (1.0, -1.0):
            left = np.flatnonzero(~out[start : start + block])
            origin, direction = _spread_rays(mesh, part[left], side * normal[left], rays)
            free = whole.index.cast(origin, direction).face < 0
            out[start + left] = free.reshape(-1, rays).sum(axis=1) >= enough
    return out


def _spread_rays(mesh: Mesh, rows: Ints, normal: Array, rays: int) -> tuple[Array, Array]:
    """Spread rays over faces and over the directions on the side of their normals.

    Origins are spread over each face, directions about its normal with cosine weight. The pattern
    is the same for all faces, an additive recurrence of low discrepancy [Roberts2018].

    Parameters
    ----------
    mesh : the mesh that the faces are of
    rows : (k,) faces from which rays start
    normal : (k, 3) their unit normals, towards the side to which the rays go
    rays : number of rays cast from each face

    Returns
    -------
    origins and directions (k * rays, 3)
    """
    u, v, w, turn = (np.mod(0.5 + np.arange(rays) / GOLDEN**k, 1.0) for k in range(1, 5))
    # points of the unit square beyond its diagonal are folded back into the triangle
    u, v = np.where(u + v > 1, [1 - u, 1 - v], [u, v])
    weight = (1 - INNER) / 3 + INNER * np.stack([1 - u - v, u, v], axis=1)
    lift = LIFT * float(np.ptp(mesh.vertices, axis=0).max())
    origin = np.einsum("kc,nci->nki", weight, mesh.vertices[mesh.faces[rows]])
    origin += lift * normal[:, None]
    radius, angle = np.sqrt(w), 2 * np.pi * turn
    local = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - w)], axis=1)
    direction = np.einsum("kj,nji->nki", local, frames_about(normal))
    return origin.reshape(-1, 3), direction.reshape(-1, 3)


def _find_close_faces(mesh: Mesh) -> Ints:
    """Find the faces (m, 2) in front of and behind each face's middle within THICKEST_M.

    One of the two may be the other side of the same plate. -1 where there is none.
    """
    middle, normal = mesh.vertices[mesh.faces].mean(axis=1), face_normals(mesh)
    lift = LIFT * float(np.ptp(mesh.vertices, axis=0).max()) * normal
    hits = [mesh.index.cast(middle + side * lift, side * normal) for side in (1.0, -1.0)]
    return np.stack([np.where(hit.range < THICKEST_M, hit.face, -1) for hit in hits], axis=1)
