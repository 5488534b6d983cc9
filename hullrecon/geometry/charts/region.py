# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A part of the hull between limits of its chart, as small cells whose areas can be summed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Mask

CELL_M = 0.05  # side of a cell
MOST_CELLS = 200_000  # cells of larger parts are wider

LOOK = 400  # points along and in girth at which the chart is sampled to find its ends

Limits = tuple[float, float] | None


@dataclass(frozen=True, kw_only=True)
class RegionCells:
    """The n cells of a part of a surface."""

    middle: Array  # (n, 3) m in the frame of the chart
    normal: Array  # (n, 3) outward unit
    area: Array  # (n,) m2


def region_cells(chart: Chart, mesh: Mesh, along: Limits, girth: Limits) -> RegionCells:
    """Divide the chart's surface between limits of along and girth into cells, to sum areas.

    Areas are those of hull: of the region due to be inspected, and of what was covered. Limits are
    (low, high) m, None for as far as the mesh reaches. The mesh only bounds the chart: cells
    outside its bounding box are left out.
    """
    given = np.array([(-np.inf, np.inf) if limits is None else limits for limits in (along, girth)])
    reach = chart_limits(chart, mesh)
    low, high = np.maximum(given[:, 0], reach[:, 0]), np.minimum(given[:, 1], reach[:, 1])
    width = np.maximum(high - low, 0.0)
    size = np.ceil(width / max(CELL_M, float(np.sqrt(width.prod() / MOST_CELLS)))).astype(int)
    ticks = [np.linspace(low[k], max(low[k], high[k]), size[k] + 1) for k in range(2)]
    corner = _grid(ticks[0], ticks[1])
    middle = _grid((ticks[0][1:] + ticks[0][:-1]) / 2, (ticks[1][1:] + ticks[1][:-1]) / 2)
    points, normals = chart.from_chart(middle.reshape(-1, 2))
    area = _areas(chart.from_chart(corner.reshape(-1, 2))[0].reshape(*corner.shape[:2], 3)).ravel()
    # A cell at a rim has a corner beyond the chart, so that its area in space is unknown. Its area
    # in chart coordinates stands in.
    area = np.where(np.isfinite(area), area, width.prod() / max(1, size.prod()))
    on = _in_box(points, mesh)
    return RegionCells(middle=points[on], normal=normals[on], area=area[on])


def chart_limits(chart: Chart, mesh: Mesh) -> Array:
    """Find the limits of a mesh on its chart: (2, 2) low and high of along, and of girth, m.

    The chart is sampled as far as a mesh of this size can reach. Zeros if the chart has
    no point on the mesh. An end narrower than a LOOK-th of the mesh's size may be missed.
    """
    if not len(mesh.vertices):
        return np.zeros((2, 2))
    # along lies within the farthest vertex's distance of that of the origin, girth within twice the
    # diagonal of the mesh
    farthest, around = (
        np.linalg.norm(mesh.vertices, axis=1).max(),
        2 * np.linalg.norm(np.ptp(mesh.vertices, axis=0)),
    )
    limits = np.array([[-farthest, farthest], [-around, around]])
    limits[0] += chart.along_of_origin
    for _ in range(2):  # the second round samples the limits of the first more finely
        step = np.diff(limits) / (LOOK - 1)
        at = _grid(*(np.linspace(low, high, LOOK) for low, high in limits)).reshape(-1, 2)
        at = at[_in_box(chart.from_chart(at)[0], mesh)]
        if not len(at):
            return np.zeros((2, 2))
        limits = np.stack([at.min(axis=0), at.max(axis=0)], axis=1) + step * [-1, 1]
    return np.asarray(limits)


def _in_box(points: Array, mesh: Mesh) -> Mask:
    """Tell which points (n, 3) are finite and in the mesh's bounding box.

    It bounds the chart, as a plane has no ends of its own.
    """
    low, high = mesh.vertices.min(axis=0) - CELL_M, mesh.vertices.max(axis=0) + CELL_M
    return np.asarray(((points >= low) & (points <= high)).all(axis=1))


def _grid(along: Array, girth: Array) -> Array:
    return np.stack(np.meshgrid(along, girth, indexing="ij"), axis=-1)


def _areas(corner: Array) -> Array:
    """Compute the areas (a, g) of quadrilaterals between corners (a + 1, g + 1, 3).

    Each is half the cross product of its diagonals.
    """
    diagonals = corner[1:, 1:] - corner[:-1, :-1], corner[1:, :-1] - corner[:-1, 1:]
    return np.asarray(np.linalg.norm(np.cross(*diagonals), axis=-1) / 2)
