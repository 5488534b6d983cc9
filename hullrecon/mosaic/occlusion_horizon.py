# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Bound the incidence from which the surface may occlude a texel, to cast fewer rays.

A texel of a smooth part of the hull cannot be occluded unless it is seen at a grazing angle. The
bound follows from the surface's outermost points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import FACES_AT_ONCE, Mesh
from hullrecon.native import least_tangents
from hullrecon.rows import blocks_of_rows
from hullrecon.typing import Array, Floats32, Ints, Ints32, Mask

# Side of a cell of the chart. The outermost point of the surface in each is kept. With cells of
# 0.1 m, rays are cast for four times as many texels near relief.
CELL_M = 0.05
BLOCK_M = 0.1  # side of a block of texels that share one bound
MIN_RELIEF_M = 0.012  # lower relief is within the surface's own error and does not occlude


@dataclass(frozen=True, kw_only=True)
class OcclusionHorizon:
    """The outermost points of the surface, which may occlude other points."""

    top: Array  # (n, 3) m, outermost point of the surface in each cell of the chart
    normal: Array  # (n, 3) of the chart at these points
    span_m: float  # points farther than this from a texel lie behind every camera or sonar


def build_occlusion_horizon(
    mesh: Mesh, chart: Chart, bounds: Array, span_m: float
) -> OcclusionHorizon:
    """Find the outermost points of a mesh within span_m of the texels.

    Only these can occlude a texel. One is kept for each cell of the chart. Vertices off the chart
    are left out.

    Parameters
    ----------
    mesh, chart
        The surface, and its chart.
    bounds
        (2, 2) least and largest along and girth, m, of the texels.
    span_m
        Largest distance of a view from a texel. What is farther off cannot be between the two.
    """
    charted = chart.to_chart(mesh.vertices)
    near = _meet(charted[:, :2], mesh.faces, bounds + np.array([[-span_m], [span_m]]))
    used, between = np.unique(mesh.faces[near]), _points_between(mesh.vertices, mesh.faces[near])
    point = np.concatenate([mesh.vertices[used], between])
    charted = np.concatenate([charted[used], chart.to_chart(between)])
    chosen = _outermost(charted)
    return OcclusionHorizon(
        top=point[chosen], normal=chart.from_chart(charted[chosen, :2])[1], span_m=span_m
    )


def _meet(charted: Array, faces: Ints32, limits: Array) -> Mask:
    """Mark the faces (m,) of charted vertices (n, 2) that reach into limits (2, 2) of the chart.

    Bounding boxes of the faces on the chart are tested: some are marked that only pass near.
    """
    out = np.zeros(len(faces), bool)
    for rows in blocks_of_rows(len(faces), FACES_AT_ONCE):
        corner = charted[faces[rows]]
        # A corner off the chart is taken to lie at its neighbour
        corner = np.where(np.isfinite(corner), corner, np.roll(corner, 1, axis=1))
        low, high = corner.min(axis=1), corner.max(axis=1)
        out[rows] = ((high >= limits[0]) & (low <= limits[1])).all(axis=1)
    return out


def _points_between(vertices: Array, faces: Ints32) -> Array:
    """Cover the faces that are larger than a cell with points (n, 3) m at most CELL_M apart.

    vertices, faces: (v, 3) m and (f, 3) of the surface. Otherwise cells inside a large face would
    have no point, and nothing would seem to occlude.
    """
    parts = np.zeros(len(faces), np.int64)
    for rows in blocks_of_rows(len(faces), FACES_AT_ONCE):
        corner = vertices[faces[rows]]
        edge = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1, initial=0)
        parts[rows] = np.ceil(edge / CELL_M)
    # Faces with as many parts along their longest edge get the same barycentric coordinates
    covers = [np.zeros((0, 3))]
    for count in np.unique(parts[parts > 1]).tolist():
        first, second = np.mgrid[: count + 1, : count + 1].reshape(2, -1)
        share = np.stack([count - first - second, first, second], axis=1) / count
        covers.append((share[share[:, 0] >= 0] @ vertices[faces[parts == count]]).reshape(-1, 3))
    return np.concatenate(covers)


def _outermost(charted: Array) -> Ints:
    """Select the outermost point in each cell of the chart: their rows (k,).

    charted: (n, 3) m, along, girth and offset of the points.
    """
    known = np.flatnonzero(np.isfinite(charted).all(axis=1))
    cell = np.floor(charted[known, :2] / CELL_M).astype(np.int64)
    cell -= cell.min(axis=0, initial=0)
    key = cell[:, 0] * (cell[:, 1].max(initial=0) + 1) + cell[:, 1]
    order = np.lexsort((-charted[known, 2], key))
    is_first = np.diff(key[order], prepend=-1) > 0
    return np.asarray(known[order[is_first]])


def free_below(horizon: OcclusionHorizon, point: Array, normal: Array, step_m: float) -> Floats32:
    """Compute the tangent of the incidence angle below which nothing occludes a texel.

    It is a lower bound, the same for all texels of a block. A line of sight with the tangent t
    rises 1 m over t metres along the tangent plane. A point at a height h above that plane and a
    distance d can meet it only if t >= d / h. So the least d / h over all points is a lower bound.
    To be safe, distances are taken too short, and heights too large, by the extent of blocks and
    cells.

    Parameters
    ----------
    horizon
        Outermost points of the surface, which may occlude texels.
    point, normal
        Points (h, w, 3) m of the texels, and the chart's outward normals there.
    step_m
        Side of a texel, from which the number of texels in a block follows.

    Returns
    -------
    Floats32
        (h, w), inf where nothing can occlude the texel.
    """
    height, width = point.shape[:2]
    side = max(1, round(BLOCK_M / step_m))
    near = _within_span(horizon, point)
    limits = (CELL_M, horizon.span_m, MIN_RELIEF_M)
    blocks = (_blocks(field, side) for field in (point, normal))
    bound = least_tangents(horizon.top[near], horizon.normal[near], limits, *blocks)
    block_rows = -(-height // side)
    spread = np.repeat(np.repeat(bound.reshape(block_rows, -1), side, axis=0), side, axis=1)
    return np.asarray(spread[:height, :width], np.float32)


def _within_span(horizon: OcclusionHorizon, point: Array) -> Ints:
    """Select the horizon's points near texels: in the box around these, widened by its span.

    point: (h, w, 3) m of the texels. Returns rows (k,) of the horizon's points.
    """
    axes = point.reshape(-1, 3).T  # one by one: along the short axis numpy takes five times as long
    reach = horizon.span_m + BLOCK_M + 4 * CELL_M
    low = np.array([np.fmin.reduce(axis, initial=np.inf) for axis in axes]) - reach
    high = np.array([np.fmax.reduce(axis, initial=-np.inf) for axis in axes]) + reach
    return np.flatnonzero(((horizon.top >= low) & (horizon.top <= high)).all(axis=1))


def _blocks(field: Array, side: int) -> Array:
    """Cut a field (h, w, 3) into blocks: (blocks, side * side, 3), row-major, padded with NaN."""
    height, width = field.shape[:2]
    rows, columns = -(-height // side), -(-width // side)
    padded = np.full((rows * side, columns * side, 3), np.nan)
    padded[:height, :width] = field
    return (
        padded.reshape(rows, side, columns, side, 3)
        .swapaxes(1, 2)
        .reshape(rows * columns, side * side, 3)
    )
