# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The outline of a part of a mesh."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Ints


def outline(mesh: Mesh, part: Ints, most: int = 60) -> Array:
    """Return the longest closed line (k, 3) around the faces whose corners all belong to the part, counter-clockwise seen from
    outside; at most `most` of its vertices. Empty when the part holds no face."""
    inside = np.zeros(len(mesh.vertices), bool)
    inside[part] = True
    faces = mesh.faces[inside[mesh.faces].all(axis=1)].astype(np.int64)
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    size = len(mesh.vertices)
    key = sides[:, 0] * size + sides[:, 1]
    rim = sides[~np.isin(key, sides[:, 1] * size + sides[:, 0])]
    loop = max(_loops(rim), key=lambda rows: _length(mesh.vertices[rows]), default=[])
    return mesh.vertices[loop[:: max(1, -(-len(loop) // most))]]


def _loops(rim: Ints) -> list[list[int]]:
    """Join directed edges (e, 2) to closed lines; at a vertex that two lines touch, the one begun first goes on."""
    follow: dict[int, list[int]] = {}
    for a, b in rim.tolist():
        follow.setdefault(a, []).append(b)
    loops = []
    for start in sorted(follow):
        while follow[start]:
            loop, at = [start], follow[start].pop(0)
            while at != start and follow.get(at):
                loop.append(at)
                at = follow[at].pop(0)
            loops.append(loop)
    return loops


def _length(line: Array) -> float:
    return float(np.linalg.norm(line - np.roll(line, 1, axis=0), axis=1).sum())
