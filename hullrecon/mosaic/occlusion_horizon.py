# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From which incidence on the surface may hide a texel: tells where rays must be cast."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.typing import Array, Floats32, Ints32

CELL_M = 0.1  # of the chart, for each of which the outermost point of the surface is kept
BLOCK_M = 0.1  # texels that share one answer
MIN_RELIEF_M = 0.012  # lower relief is within the surface's own error and hides nothing
PAIRS = 50_000  # of blocks and cells at a time, which a processor's cache holds


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
    at = chart.to_chart(mesh.vertices)[:, :2]
    corner = at[mesh.faces]
    corner = np.where(np.isfinite(corner), corner, np.roll(corner, 1, axis=1))
    low, high = corner.min(axis=1), corner.max(axis=1)
    near = ((high >= bounds[0] - span_m) & (low <= bounds[1] + span_m)).all(axis=1)
    vertices = _cover(mesh.vertices, mesh.faces[near])
    charted = chart.to_chart(vertices)
    known = np.flatnonzero(np.isfinite(charted).all(axis=1))
    known = known[np.argsort(-charted[known, 2], kind="stable")]
    _, first = np.unique(np.floor(charted[known, :2] / CELL_M), axis=0, return_index=True)
    chosen = known[first]
    return OcclusionHorizon(
        top=vertices[chosen], normal=chart.from_chart(charted[chosen, :2])[1], span_m=span_m
    )


def _cover(vertices: Array, faces: Ints32) -> Array:
    """Cover faces with points (n, 3) no farther apart than a cell, their corners among them."""
    corner = vertices[faces]
    edge = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)
    used, coarse = np.unique(faces[edge.max(axis=1) > CELL_M], return_inverse=True)
    fine, _ = refine(Mesh(vertices[used], coarse.reshape(-1, 3).astype(np.int32)), CELL_M)
    return np.vstack([vertices[np.unique(faces)], fine.vertices[len(used) :]])


def hidden_from(horizon: OcclusionHorizon, point: Array, normal: Array, step_m: float) -> Floats32:
    """Return the tangent (h, w) of the incidence up to which nothing hides a texel.

    A line of sight with the tangent t rises 1 m over t metres along the tangent plane. What stands
    h above that plane at the distance d can meet it only if t >= d / h. The least d / h over the
    horizon is a lower bound: distances are taken too short and heights too large by as much as
    blocks, cells and faces extend. `point`: of the texels (h, w, 3). `normal`: of the texels (h, w,
    3).
    """
    height, width = point.shape[:2]
    side = max(1, round(BLOCK_M / step_m))
    blocks = _blocks(point, side), _blocks(normal, side)
    some = np.flatnonzero(np.isfinite(blocks[0][..., 0]).any(axis=1))
    bound = np.full(len(blocks[0]), np.inf)
    if len(some):
        bound[some] = _least_tangent(horizon, blocks[0][some], blocks[1][some])
    rows = -(-height // side)
    spread = np.repeat(np.repeat(bound.reshape(rows, -1), side, axis=0), side, axis=1)
    return np.asarray(spread[:height, :width], np.float32)


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


def _least_tangent(horizon: OcclusionHorizon, points: Array, normals: Array) -> Array:
    """Minimise d / h (blocks,) over the horizon, inf where nothing stands out."""
    middle, up = np.nanmean(points, axis=1), np.nanmean(normals, axis=1)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    off = points - middle[:, None]
    level = np.einsum("bki,bi->bk", off, up)
    floor = np.nanmin(level, axis=1)
    radius = np.sqrt(np.nanmax(np.einsum("bki,bki->bk", off, off), axis=1))
    center = 0.5 * (middle.min(axis=0) + middle.max(axis=0))
    extent = float(np.linalg.norm(middle - center, axis=1).max() + radius.max())
    near = np.linalg.norm(horizon.top - center, axis=1) < extent + horizon.span_m + 3 * CELL_M
    top, normal = horizon.top[near] - center, horizon.normal[near]
    least = np.full(len(middle), np.inf)
    if not len(top):
        return least
    chunk = max(1, PAIRS // len(top))
    for i in range(0, len(middle), chunk):
        part = slice(i, i + chunk)
        at, n = middle[part] - center, up[part]
        above = n @ top.T
        above -= np.einsum("bi,bi->b", n, at)[:, None]
        # other points of the cell may stand higher by its tilt
        rise = n @ normal.T
        np.square(rise, out=rise)
        np.sqrt(np.maximum(np.subtract(1, rise, out=rise), 0, out=rise), out=rise)
        rise *= np.sqrt(2) * CELL_M
        rise += above
        rise -= floor[part, None]
        # of most pairs the cell does not stand out
        block, cell = np.nonzero(rise > MIN_RELIEF_M)
        off = top[cell] - at[block]
        level = np.einsum("ki,ki->k", off, off) - above[block, cell] ** 2
        away = np.sqrt(np.maximum(level, 0)) - radius[part][block] - (1 + np.sqrt(2)) * CELL_M
        bound = np.where(away < horizon.span_m, np.maximum(away, 0) / rise[block, cell], np.inf)
        np.minimum.at(least[part], block, bound)
    return least
