# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull in patches of some 0.1 m, of which each sensor saw some."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh, vertex_areas, vertex_normals
from hullrecon.typing import Array, Ints, Mask

Facts = dict[str, Any]  # members of coverage.json
PATCH_M = 0.12  # edges of the patches on which coverage is summed
CUBE_M = 0.5  # patches in one cube are ruled out at once where a fan passes it


@dataclass(frozen=True, kw_only=True)
class HullPatches:
    """The base surface as n patches of some 0.1 m, on which seen area is summed."""

    mesh: Mesh  # whose vertices (n, 3) are the middles of the patches
    normal: Array  # (n, 3) outward
    area: Array  # (n,) m2

    @cached_property
    def cubes(self) -> Cubes:
        """Group the patches by position."""
        return _group_in_cubes(self.mesh.vertices)


@dataclass(frozen=True, kw_only=True)
class Cubes:
    """Points grouped in cubes, with a sphere around those of each, to rule out many at once."""

    order: Ints  # (n,) rows of the points, cube by cube
    start: Ints  # (k + 1,) where in `order` each cube's begin, and the end
    middle: Array  # (k, 3) m, of the sphere
    radius: Array  # (k,) m, of the sphere

    def rows(self, which: Mask) -> Ints:
        """List the rows of the points in some cubes (k,)."""
        spans = zip(self.start[:-1][which], self.start[1:][which], strict=True)
        return np.concatenate([self.order[:0], *(self.order[a:b] for a, b in spans)])


def _group_in_cubes(points: Array) -> Cubes:
    """Group points (n, 3) m in cubes with sides of CUBE_M, without empty ones. See `Cubes`."""
    cube = np.floor(points / CUBE_M).astype(np.int64)
    order = np.lexsort(cube.T)
    cube = cube[order]
    first = np.ones(len(cube), bool)
    first[1:] = (cube[1:] != cube[:-1]).any(axis=1)
    start = np.append(np.flatnonzero(first), len(cube))
    middle = np.add.reduceat(points[order], start[:-1]) / np.diff(start)[:, None]
    away = np.linalg.norm(points[order] - np.repeat(middle, np.diff(start), axis=0), axis=1)
    radius = np.maximum.reduceat(away, start[:-1])
    return Cubes(order=order, start=start, middle=middle, radius=radius)


def hull_patches(mesh: Mesh) -> HullPatches:
    """Take the vertices of a mesh as patches, with their shares of its area."""
    return HullPatches(mesh=mesh, normal=vertex_normals(mesh), area=vertex_areas(mesh))
