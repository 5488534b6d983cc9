# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From which incidence on the surface may hide a texel: tells where rays must be cast."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.native import least_tangents
from hullrecon.typing import Array, Floats32, Ints, Ints32

# of the chart, for each of which the outermost point of the surface is kept. Cells of 0.1 m
# leave four times as many texels near some relief, for which rays are cast.
CELL_M = 0.05
BLOCK_M = 0.1  # texels that share one answer
MIN_RELIEF_M = 0.012  # lower relief is within the surface's own error and hides nothing


@dataclass(frozen=True, kw_only=True)
class OcclusionHorizon:
    """What of the surface stands out."""

    top: Array  # (n, 3) outermost point of the surface in each cell of the chart
    normal: Array  # (n, 3) of the chart there
    span_m: float  # what is farther from a texel stands behind every instrument


def build_occlusion_horizon(
    mesh: Mesh, chart: Chart, bounds: Array, span_m: float
) -> OcclusionHorizon:
    """Build the horizon of what lies within span_m of the texels."""
    charted = chart.to_chart(mesh.vertices)
    corner = charted[mesh.faces][..., :2]
    corner = np.where(np.isfinite(corner), corner, np.roll(corner, 1, axis=1))
    low, high = corner.min(axis=1), corner.max(axis=1)
    near = ((high >= bounds[0] - span_m) & (low <= bounds[1] + span_m)).all(axis=1)
    used, between = np.unique(mesh.faces[near]), _points_between(mesh.vertices, mesh.faces[near])
    point = np.concatenate([mesh.vertices[used], between])
    charted = np.concatenate([charted[used], chart.to_chart(between)])
    chosen = _outermost(charted)
    return OcclusionHorizon(
        top=point[chosen], normal=chart.from_chart(charted[chosen, :2])[1], span_m=span_m
    )


def _points_between(vertices: Array, faces: Ints32) -> Array:
    """Cover the faces that are larger than a cell with points (n, 3) no farther apart."""
    corner = vertices[faces]
    edge = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1, initial=0)
    parts = np.ceil(edge / CELL_M).astype(np.int64)
    covers = [np.zeros((0, 3))]
    for count in np.unique(parts[parts > 1]).tolist():
        first, second = np.mgrid[: count + 1, : count + 1].reshape(2, -1)
        share = np.stack([count - first - second, first, second], axis=1) / count
        covers.append((share[share[:, 0] >= 0] @ corner[parts == count]).reshape(-1, 3))
    return np.concatenate(covers)


def _outermost(charted: Array) -> Ints:
    """Select the outermost of charted points (n, 3) in each cell."""
    known = np.flatnonzero(np.isfinite(charted).all(axis=1))
    cell = np.floor(charted[known, :2] / CELL_M).astype(np.int64)
    cell -= cell.min(axis=0, initial=0)
    key = cell[:, 0] * (cell[:, 1].max(initial=0) + 1) + cell[:, 1]
    order = np.lexsort((-charted[known, 2], key))
    is_first = np.diff(key[order], prepend=-1) > 0
    return np.asarray(known[order[is_first]])


def hidden_from(horizon: OcclusionHorizon, point: Array, normal: Array, step_m: float) -> Floats32:
    """Bound the tangent (h, w) of the incidence up to which nothing hides a texel.

    A line of sight with the tangent t rises 1 m over t metres along the tangent plane. What stands
    h above that plane at the distance d can meet it only if t >= d / h. So the least d / h over all
    that stands out is a lower bound. Distances are taken too short, and heights too large, by the
    extent of blocks, cells and faces.

    `point`: of the texels (h, w, 3). `normal`: of the texels (h, w, 3).
    """
    height, width = point.shape[:2]
    side = max(1, round(BLOCK_M / step_m))
    near = _near(horizon, point)
    limits = (CELL_M, horizon.span_m, MIN_RELIEF_M)
    blocks = (_blocks(field, side) for field in (point, normal))
    bound = least_tangents(horizon.top[near], horizon.normal[near], limits, *blocks)
    rows = -(-height // side)
    spread = np.repeat(np.repeat(bound.reshape(rows, -1), side, axis=0), side, axis=1)
    return np.asarray(spread[:height, :width], np.float32)


def _near(horizon: OcclusionHorizon, point: Array) -> Ints:
    """Select what of the horizon is within its span of the texels (h, w, 3), and a little more."""
    axes = point.reshape(-1, 3).T  # one by one: along the short axis numpy takes five times as long
    reach = horizon.span_m + BLOCK_M + 4 * CELL_M
    low = np.array([np.fmin.reduce(axis, initial=np.inf) for axis in axes]) - reach
    high = np.array([np.fmax.reduce(axis, initial=-np.inf) for axis in axes]) + reach
    return np.flatnonzero(((horizon.top >= low) & (horizon.top <= high)).all(axis=1))


def _blocks(field: Array, side: int) -> Array:
    """Reshape to (blocks, side * side, 3) in row-major order, NaN beyond the field's ends."""
    height, width = field.shape[:2]
    rows, columns = -(-height // side), -(-width // side)
    padded = np.full((rows * side, columns * side, 3), np.nan)
    padded[:height, :width] = field
    return (
        padded.reshape(rows, side, columns, side, 3)
        .swapaxes(1, 2)
        .reshape(rows * columns, side * side, 3)
    )
