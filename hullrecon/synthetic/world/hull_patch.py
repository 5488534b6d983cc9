# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The surveyed part of a hull as a regular grid in (along, girth): sections of the CAD model, cut by arc length."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.errors import InputError
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.world.ray_casting import Rays

Array = NDArray[np.float64]
GAP_M = 0.6  # a wider gap between neighbouring rays' hits ends a section: an edge, not a facet


@dataclass(frozen=True)
class HullPatch:
    """point (a, g, 3) on the CAD model and outward unit normal (a, g, 3), in M, at evenly spaced along_m and girth_m."""

    along_m: Array
    girth_m: Array
    point: Array
    normal: Array

    def sample(self, grid: Array, along_m: Array, girth_m: Array) -> Array:
        """Values (n, k) of a grid (a, g, k) by bilinear interpolation; outside, the edge's."""
        i, p = _place(self.along_m, along_m)
        j, q = _place(self.girth_m, girth_m)
        p, q = p[:, None], q[:, None]
        low = (1 - p) * grid[i, j] + p * grid[i + 1, j]
        high = (1 - p) * grid[i, j + 1] + p * grid[i + 1, j + 1]
        return np.asarray((1 - q) * low + q * high)

    def smoothed(self, width_m: float) -> HullPatch:
        """The same with facets ironed out over that width: what a vehicle follows."""
        from scipy.ndimage import gaussian_filter

        sigma = width_m / (self.along_m[1] - self.along_m[0])
        blur = np.stack([gaussian_filter(self.normal[..., k], sigma, mode="nearest") for k in range(3)], -1)
        return HullPatch(self.along_m, self.girth_m, self.point, blur / np.linalg.norm(blur, axis=2, keepdims=True))


def cut_hull_patch(
    cad_model: Mesh, span_m: tuple[float, float], zero_z_m: float, top_z_m: float, down_m: float, step_m: float = 0.03
) -> HullPatch:
    """Sections of the CAD model between two positions along it. Girth is 0 where the port side passes `zero_z_m` (so that legs
    of constant girth keep their depth near bow and stern), grows up to the height `top_z_m`, and falls over `down_m`, past the
    keel if need be. Raises InputError where the CAD model has no skin there."""
    along = np.arange(np.floor(span_m[0] / step_m), np.ceil(span_m[1] / step_m) + 1) * step_m
    caster = Rays(cad_model)
    low, high = -down_m, np.inf
    for arc, line in _sections(caster, cad_model, along, zero_z_m):
        low, high = max(low, float(arc[0])), min(high, _arc_at(arc, line, top_z_m))
    girth = np.arange(np.ceil(low / step_m), np.floor(high / step_m) + 1) * step_m
    if len(girth) < 10:
        raise InputError("the hull has too little skin where the dive is", remedy="move `along_m`, or dive deeper with `top_m`")
    point = np.empty((len(along), len(girth), 3))
    for row, (arc, line) in zip(point, _sections(caster, cad_model, along, zero_z_m), strict=True):  # cut again: all at
        row[:] = np.stack([np.interp(girth, arc, line[:, k]) for k in range(3)], -1)  # once they would fill the memory
    return HullPatch(along, girth, point, _normals(point))


def _sections(caster: Rays, cad_model: Mesh, along: Array, zero_z_m: float, rays: int = 3000) -> Iterator[tuple[Array, Array]]:
    """Yield each section as (arc length from where the port side passes that height, points): rays from far outside towards
    a spine within."""
    high = cad_model.vertices[:, 2].max()
    spine = np.array([0.0, 1e-3 * high, 0.55 * high])
    angle = np.linspace(-1.25, 2.5, rays)
    out = np.stack([np.zeros(rays), np.sin(angle), -np.cos(angle)], 1)
    far = 2.0 * float(np.abs(cad_model.vertices[:, 1:]).max())
    for x in along:
        arc, line = _section(caster, spine + np.array([x, 0.0, 0.0]), out, far, angle)
        yield arc - _arc_at(arc, line, zero_z_m), line


def _section(caster: Rays, spine: Array, out: Array, far: float, angle: Array) -> tuple[Array, Array]:
    hits = caster.cast(spine + far * out, -out)
    good = hits.hit & (hits.range_m < far)
    if good.sum() < 2:
        raise InputError("the hull has no section", where=f"x = {spine[0]:.2f} m", remedy="move `along_m`")
    line = spine + (far - hits.range_m[good, None].astype(float)) * out[good]
    middle = int(np.argmin(np.abs(angle[good])))
    jump = np.linalg.norm(np.diff(line, axis=0), axis=1)
    gap = np.flatnonzero(jump > GAP_M)
    first, last = int(np.max(gap[gap < middle], initial=-1)) + 1, int(np.min(gap[gap >= middle], initial=len(jump)))
    arc = np.concatenate([[0.0], np.cumsum(jump[first:last])])
    return arc - arc[middle - first], line[first : last + 1]


def _arc_at(arc: Array, line: Array, z_m: float) -> float:
    """Where the port side of a section first passes that height."""
    lowest = int(np.argmin(line[:, 2]))
    return float(np.interp(z_m, np.maximum.accumulate(line[lowest:, 2]), arc[lowest:]))


def _normals(point: Array) -> Array:
    along, girth = np.gradient(point, axis=0), np.gradient(point, axis=1)
    normal = np.cross(girth, along)
    return np.asarray(normal / np.linalg.norm(normal, axis=2, keepdims=True))


def _place(axis: Array, value: Array) -> tuple[NDArray[np.int64], Array]:
    at = np.clip((value - axis[0]) / (axis[1] - axis[0]), 0, len(axis) - 1 - 1e-9)
    cell = np.floor(at).astype(np.int64)
    return cell, at - cell
