# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How far a CAD model of flat facets stands off the curved hull that it means.

A facet of width w between neighbours turned by an angle has a sagitta of w * angle / 8. Slid along the hull, the pattern of
facets makes false minima a facet apart; registration and its profile must not take them for information about the place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Ints, Ints32


@dataclass(frozen=True)
class Facets:
    """sigma: of the facets' offset from a smooth hull, metres; length: over which it is the same, metres."""

    sigma: float
    length: float


def facets_near(mesh: Mesh, points: Array, reach_m: float = 1.0) -> Facets:
    """Of the faces within reach of points (n, 3) in M. A sharp edge (over 30 degrees) is meant, and does not count."""
    corner = mesh.vertices[mesh.faces]
    size = np.linalg.norm(corner - corner.mean(1, keepdims=True), axis=2).max(1)
    gap, _ = cKDTree(points).query(corner.mean(1))
    faces = mesh.faces[gap <= reach_m + size]
    first, second, edge = _shared_edges(faces)
    normal, area = _normals(mesh.vertices, faces)
    turned = np.arccos(np.clip(np.einsum("nk,nk->n", normal[first], normal[second]), -1, 1))
    long = np.linalg.norm(mesh.vertices[edge[:, 0]] - mesh.vertices[edge[:, 1]], axis=1)
    width = (area[first] + area[second]) / np.maximum(long, 1e-9)  # the mean height of two triangles over their edge
    smooth = (turned < np.radians(30)) & (area[first] > 0) & (area[second] > 0)
    if not smooth.any():
        return Facets(0.0, 1.0)
    sagitta = np.where(smooth, width * turned / 8, 0.0)
    worst = np.zeros(len(faces))
    np.maximum.at(worst, first, sagitta)
    np.maximum.at(worst, second, sagitta)
    weight = sagitta[smooth] + 1e-12
    return Facets(float(np.sqrt(np.average(worst**2, weights=area + 1e-12))), float(np.average(width[smooth], weights=weight)))


def _shared_edges(faces: Ints32) -> tuple[Ints, Ints, Ints32]:
    """Pairs of faces that share an edge, (k,) each, and the edges' vertices (k, 2)."""
    edges = np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(faces)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    same = np.flatnonzero((edges[1:] == edges[:-1]).all(1))
    return owner[same], owner[same + 1], edges[same]


def _normals(vertices: Array, faces: Ints32) -> tuple[Array, Array]:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    twice = np.linalg.norm(across, axis=1)
    return across / np.maximum(twice, 1e-12)[:, None], 0.5 * twice
