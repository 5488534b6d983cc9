# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How far a curved hull stands off the flat facets that draw it: heights of that size are the CAD model's, not a structure's."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Ints

SHARPEST_RAD = np.radians(40.0)  # a sharper edge is a real one (chine, keel), not a curve's facets


def facet_sagitta(mesh: Mesh) -> Array:
    """(m,) m for each face: the rise of the arc over the facet, from the angles to its neighbours.

    Across an edge with turn angle t, facets of widths a and b (square to the edge) follow a radius (a + b) / (2 t); the arc
    over a chord a rises a^2 t / (4 (a + b)).
    """
    corner = mesh.vertices[mesh.faces]
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    double_area = np.maximum(np.linalg.norm(cross, axis=1), 1e-15)
    normal = cross / double_area[:, None]
    side, left, right = _shared_edges(mesh)
    length = np.linalg.norm(mesh.vertices[side[:, 0]] - mesh.vertices[side[:, 1]], axis=1)
    cosine = np.einsum("ni,ni->n", normal[left], normal[right])
    turn = np.arccos(np.clip(cosine, -1, 1))
    turn[turn > SHARPEST_RAD] = 0.0
    width = [double_area[face] / np.maximum(length, 1e-12) for face in (left, right)]
    out = np.zeros(len(mesh.faces))
    for face, own in ((left, width[0]), (right, width[1])):
        np.maximum.at(out, face, own**2 * turn / (4 * np.maximum(width[0] + width[1], 1e-12)))
    return out


def _shared_edges(mesh: Mesh) -> tuple[Ints, Ints, Ints]:
    """Edges (e, 2) between two faces, and those faces (e,), (e,). Corners at equal places count as one."""
    _, same = np.unique(np.round(mesh.vertices, 6), axis=0, return_inverse=True)
    faces = same.reshape(-1)[mesh.faces]
    ends = np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
    pairs = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    twin = np.flatnonzero((pairs[order[:-1]] == pairs[order[1:]]).all(axis=1))
    first, second = order[twin], order[twin + 1]
    return ends[first], first // 3, second // 3
