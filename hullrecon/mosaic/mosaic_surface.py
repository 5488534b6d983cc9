# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The surface that a mosaic is laid on, sampled at texels through the chart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh, corner_shares
from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.occlusion_horizon import (
    OcclusionHorizon,
    build_occlusion_horizon,
    free_below,
)
from hullrecon.native import incidence
from hullrecon.typing import Array, Floats32, Ints, Ints32, Mask

# The chart is evaluated at every 8th texel and linear between: 0.1 mm off on a radius of a metre at
# 4 mm texels
COARSE = 8
OFF_SURFACE_M = 0.004  # rays start this far off the surface, so as not to hit it at once
COUNTS = "support"  # name of the values of a surface that are counts. All others are metres
QUANTUM_M = 0.0001  # step of values in metres: finer digits are noise, and compress badly


@dataclass(frozen=True, kw_only=True)
class MosaicSurface:
    """A mesh, and the chart that unrolls it."""

    mesh: Mesh
    scene: Scene
    chart: Chart
    reach_m: float  # largest distance of the mesh from the chart's surface, along its normal
    # (n,) of the mesh's vertices, NaN where unknown, by the name of the raster that shows them
    values: Mapping[str, Array] = field(default_factory=dict)
    # Tells which texels cannot be occluded. None: a ray is cast for every texel.
    horizon: OcclusionHorizon | None = None

    def with_occlusion_horizon(self, grid: TexelGrid, span_m: float) -> MosaicSurface:
        """Add the horizon for texels of the grid and views from up to span_m away."""
        low = [grid.west, grid.north - grid.height * grid.step_m]
        bounds = np.array([low, [grid.west + grid.width * grid.step_m, grid.north]])
        return replace(self, horizon=build_occlusion_horizon(self.mesh, self.chart, bounds, span_m))


def build_mosaic_surface(
    mesh: Mesh, chart: Chart, reach_m: float, values: Mapping[str, Array] = MappingProxyType({})
) -> MosaicSurface:
    """Build the surface without a horizon. Parameters are those of `MosaicSurface`."""
    return MosaicSurface(mesh=mesh, scene=Scene(mesh), chart=chart, reach_m=reach_m, values=values)


@dataclass(frozen=True, kw_only=True)
class SurfacePatch:
    """The surface at the texels of a window."""

    point: Array  # (h, w, 3) m, NaN where there is no surface
    normal: Array  # (h, w, 3) of the chart, outward
    face: Ints32  # (h, w) face of the mesh that holds the point, -1 where there is none
    # (h, w) tangent of the incidence angle from which the surface may occlude the texel, inf if it
    # cannot
    free_below: Floats32

    def part(self, which: tuple[slice, slice]) -> SurfacePatch:
        """Cut some rows and columns of texels out of the patch."""
        return SurfacePatch(
            point=self.point[which],
            normal=self.normal[which],
            face=self.face[which],
            free_below=self.free_below[which],
        )

    def cosines(self, rows: Ints | None, sensor: Array) -> Array:
        """Compute cosines (n,) of the incidence of a sensor (3,) m at flat indices (n,).

        rows: all texels if None.
        """
        return incidence(*self.at(rows), sensor)

    def at(self, rows: Ints | None) -> tuple[Array, Array]:
        """Take points m and normals (n, 3) of the texels with flat indices `rows`, all if None."""
        point, normal = self.point.reshape(-1, 3), self.normal.reshape(-1, 3)
        if rows is None:
            return point, normal
        return point.take(rows, axis=0), normal.take(rows, axis=0)


def sample_surface(surface: MosaicSurface, grid: TexelGrid, window: Window) -> SurfacePatch:
    """Find the surface at each texel of a window, by a ray from outside along the chart's normal.

    A hit farther than reach_m from the chart's surface does not count. Texels without a hit, beyond
    the raster or off the chart have no surface (NaN).
    """
    base, normal = _chart_at(surface.chart, grid, window)
    shape = base.shape
    # Rays start reach_m outside of the chart's surface, and may go as far inside of it
    start = (base + surface.reach_m * normal).reshape(-1, 3)
    direction = -normal.reshape(-1, 3)
    inside = np.zeros(shape[:2], bool)
    inside[window.meet(grid.whole).within(window)] = True
    good = np.isfinite(start[:, 0] + start[:, 1] + start[:, 2]) & inside.ravel()
    distance, face = np.full(len(start), np.inf), np.full(len(start), -1, np.int32)
    distance[good], face[good] = surface.scene.hit(start[good], direction[good])
    too_far = distance > 2 * surface.reach_m
    distance[too_far], face[too_far] = np.nan, -1
    point = (start + distance[:, None] * direction).reshape(shape)
    # Without a horizon, zero: any texel may be occluded
    if surface.horizon is None:
        tangent = np.zeros(shape[:2], np.float32)
    else:
        tangent = free_below(surface.horizon, point, normal, grid.step_m)
    return SurfacePatch(
        point=point, normal=normal, face=face.reshape(shape[:2]), free_below=tangent
    )


def value_type(name: str) -> str:
    """Name the type in which a surface's values of that name are stored."""
    return "uint16" if name == COUNTS else "float32"


def interpolate_values(surface: MosaicSurface, patch: SurfacePatch) -> dict[str, NDArray[Any]]:
    """Interpolate the values of a surface at the texels (h, w) of a patch.

    Metres are interpolated linearly on each face, counts are those of the nearest corner. Without
    a value, metres are NaN and counts 0.
    """
    on_surface = patch.face >= 0
    corners = surface.mesh.faces[patch.face[on_surface]]
    share = corner_shares(surface.mesh.vertices[corners], patch.point[on_surface])
    # vertices and shares corner by corner: numpy is slow along an axis of three
    (a, b, c), (of_a, of_b, of_c) = np.ascontiguousarray(corners.T), np.ascontiguousarray(share.T)
    nearest = np.where(of_c > np.maximum(of_a, of_b), c, np.where(of_b > of_a, b, a))
    found = {}
    for name, value in surface.values.items():
        texels = np.full(on_surface.shape, 0 if name == COUNTS else np.nan, value_type(name))
        if name == COUNTS:
            texels[on_surface] = np.nan_to_num(value[nearest])
        else:
            linear = value[a] * of_a + value[b] * of_b + value[c] * of_c
            texels[on_surface] = np.rint(linear / QUANTUM_M) * QUANTUM_M
        found[name] = texels
    return found


def _chart_at(chart: Chart, grid: TexelGrid, window: Window) -> tuple[Array, Array]:
    """Compute the chart's points and normals (h, w, 3) at texel centres. NaN off the chart.

    They are exact at every COARSE-th centre, and linearly interpolated between.
    """
    height, width = window.shape
    rows, columns = (np.arange(0, n + COARSE, COARSE, dtype=float) for n in (height, width))
    nodes = grid.centers(rows + window.top, columns + window.left)
    point, normal = chart.from_chart(nodes.reshape(-1, 2))
    fields = np.concatenate([point, normal], axis=1).reshape(len(rows), len(columns), 6)
    fine = _interpolate_axis(_interpolate_axis(fields, height, 0), width, 1)
    x, y, z = (fine[..., k] for k in (3, 4, 5))
    return fine[..., :3], fine[..., 3:] / np.sqrt(x * x + y * y + z * z)[..., None]


def _interpolate_axis(values: Array, count: int, axis: int) -> Array:
    """Interpolate values at every COARSE-th texel linearly to `count` texels along one axis."""
    at = np.arange(count) / COARSE
    low = at.astype(int)
    share = (at - low).reshape([-1 if k == axis else 1 for k in range(values.ndim)])
    return np.asarray(
        np.take(values, low, axis) * (1 - share) + np.take(values, low + 1, axis) * share
    )


def find_visible(
    surface: MosaicSurface, patch: SurfacePatch, rows: Ints, sensor: Array, min_cosine: float
) -> tuple[Mask, Array]:
    """Find the texels that a sensor sees.

    A texel is seen if the cosine of the incidence is above min_cosine and the straight line to the
    sensor does not meet the surface. Rays are cast only where the tangent of the incidence reaches
    `SurfacePatch.free_below`: below it nothing can occlude the texel.

    Parameters
    ----------
    surface, patch
        The surface, and its points at texels.
    rows
        (n,) flat indices of the texels that are tested.
    sensor
        (3,) m, position of the sensor.
    min_cosine
        Cosine of the flattest incidence at which a texel counts as seen.

    Returns
    -------
    visible, cosine
        (n,) whether each texel is seen, and the cosine of its incidence.
    """
    point, normal = patch.at(rows)
    cosine = incidence(point, normal, sensor)
    visible = cosine > min_cosine
    tangent = np.sqrt(np.maximum(1 - cosine**2, 0)) / np.maximum(cosine, 1e-6)
    doubtful = np.flatnonzero(visible & (tangent >= patch.free_below.ravel().take(rows)))
    visible[doubtful] = find_unobstructed(
        surface, point.take(doubtful, axis=0), normal.take(doubtful, axis=0), sensor
    )
    return visible, cosine


def find_unobstructed(surface: MosaicSurface, points: Array, normals: Array, sensor: Array) -> Mask:
    """Tell which points (n, 3) m with normals (n, 3) have a free line of sight to a sensor (3,)."""
    return surface.scene.is_free(points + OFF_SURFACE_M * normals, sensor)
