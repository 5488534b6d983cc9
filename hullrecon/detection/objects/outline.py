# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The outline of a part of a mesh."""

from __future__ import annotations

import numpy as np

from hullrecon.detection.objects.size import EDGE_SIGMA_M
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Ints

LEAST_SHARE = 0.02  # of the outlined area: what is larger is a shape, however small the part


def outline(mesh: Mesh, part: Ints, most: int = 60) -> Array:
    """Return the longest closed line (k, 3) around the faces whose corners all belong to the part,
    counter-clockwise seen from outside, through vertices of the mesh, without teeth that are
    smaller than an edge is known; at most `most` of them. Empty when the part holds no face.
    """
    inside = np.zeros(len(mesh.vertices), bool)
    inside[part] = True
    faces = mesh.faces[inside[mesh.faces].all(axis=1)].astype(np.int64)
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    size = len(mesh.vertices)
    key = sides[:, 0] * size + sides[:, 1]
    rim = sides[~np.isin(key, sides[:, 1] * size + sides[:, 0])]
    loop = max(_loops(rim), key=lambda rows: _length(mesh.vertices[rows]), default=[])
    line = mesh.vertices[loop]
    return line[_without_teeth(_flatten(line), most)]


def _flatten(line: Array) -> Array:
    """Return a closed line (k, 3) in the plane (k, 2) that it spans: up and down a structure's wall
    is not along its edge.
    """
    centred = line - line.mean(axis=0) if len(line) else line
    area = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    normal = area / max(float(np.linalg.norm(area)), 1e-12)
    across = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    across /= max(float(np.linalg.norm(across)), 1e-12)
    return np.asarray(centred @ np.stack([across, np.cross(normal, across)], axis=1))


def _without_teeth(line: Array, most: int) -> list[int]:
    """Return the rows that are left of a closed line (k, 2): the point that spans the smallest
    triangle with its neighbours goes first [VisvalingamWhyatt1993], until none is smaller than the
    square of an edge's sigma and at most `most` are left.
    """
    tooth = min(
        EDGE_SIGMA_M**2, LEAST_SHARE * abs(_double_area(line, np.roll(line, -1, axis=0)).sum()) / 2
    )
    left = list(range(len(line)))
    while len(left) > 4:
        here = line[left]
        to_last, to_next = np.roll(here, 1, axis=0) - here, np.roll(here, -1, axis=0) - here
        area = 0.5 * np.abs(_double_area(to_last, to_next))
        least = int(np.argmin(area))
        if area[least] > tooth and len(left) <= most:
            break
        del left[least]
    return left


def _double_area(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _loops(rim: Ints) -> list[list[int]]:
    """Join directed edges (e, 2) to closed lines; at a vertex that two lines touch, the one begun
    first goes on.
    """
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
