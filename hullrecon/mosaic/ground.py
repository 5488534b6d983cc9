# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The surface that a mosaic is laid on, sampled at texels through the chart."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.casting import Scene
from hullrecon.geometry.chart import Chart
from hullrecon.mosaic.grid import TexelGrid, Window

Array = NDArray[np.float64]
COARSE = 8  # texels between points of the chart; between them it is linear, 0.1 mm off on a radius of a metre at 4 mm texels
SHADOW_RINGS_M = (0.0, 0.03, 0.1, 0.3)  # rings around a texel in which structures are looked for that may hide it
SHADOW_HEIGHT_M = 0.012  # lower relief hides nothing that matters at 4 mm texels
OFF_SURFACE_M = 0.004  # rays start so far off the surface, not to hit it where they start


@dataclass(frozen=True)
class Ground:
    """A mesh, and the chart that unrolls it; reach_m: how far from the chart's surface the mesh may lie."""

    scene: Scene
    chart: Chart
    reach_m: float


@dataclass(frozen=True)
class Patch:
    """The surface at the texels of a window: point (h, w, 3), NaN where there is none, normal (h, w, 3) of the chart,
    hidden_from (h, w): the tangent of the incidence from which on something near may hide the texel, inf where nothing does."""

    point: Array
    normal: Array
    hidden_from: NDArray[np.float32]


def patch_of(ground: Ground, grid: TexelGrid, window: Window) -> Patch:
    """The outermost surface at each texel: a ray along the chart's normal from outside."""
    base, normal = _chart_at(ground.chart, grid, window)
    shape = base.shape
    start = (base + ground.reach_m * normal).reshape(-1, 3)
    direction = -normal.reshape(-1, 3)
    good = np.isfinite(start).all(axis=1)
    gone = np.full(len(start), np.inf)
    gone[good] = ground.scene.cast(start[good], direction[good])
    gone[gone > 2 * ground.reach_m] = np.nan
    point = (start + gone[:, None] * direction).reshape(shape)
    offset = (ground.reach_m - gone).reshape(shape[:2])
    return Patch(point, normal, _hidden_from(offset, grid.step_m))


def _chart_at(chart: Chart, grid: TexelGrid, window: Window) -> tuple[Array, Array]:
    """Points and unit normals of the chart at texel centres, linear between every COARSE-th."""
    height, width = window.shape
    rows, columns = (np.arange(0, n + COARSE, COARSE, dtype=float) for n in (height, width))
    nodes = grid.centers(rows + window.top, columns + window.left)
    point, normal = chart.from_chart(nodes.reshape(-1, 2))
    fields = np.concatenate([point, normal], axis=1).reshape(len(rows), len(columns), 6)
    fine = _between(_between(fields, height, 0), width, 1)
    turned = fine[..., 3:]
    return fine[..., :3], turned / np.linalg.norm(turned, axis=-1, keepdims=True)


def _between(values: Array, count: int, axis: int) -> Array:
    """Linear interpolation to every texel along one axis."""
    at = np.arange(count) / COARSE
    low = at.astype(int)
    share = (at - low).reshape([-1 if k == axis else 1 for k in range(values.ndim)])
    return np.asarray(np.take(values, low, axis) * (1 - share) + np.take(values, low + 1, axis) * share)


def _hidden_from(offset: Array, step_m: float) -> NDArray[np.float32]:
    """What stands a height above a texel, nearest at some distance, can hide it only from a flatter view than their ratio."""
    import cv2

    level = np.where(np.isfinite(offset), offset, -1e3).astype(np.float32)
    least = np.full(level.shape, np.inf, np.float32)
    for near, far in pairwise(SHADOW_RINGS_M):
        side = 2 * max(1, round(far / step_m)) + 1
        rise = np.asarray(cv2.dilate(level, np.ones((side, side), np.uint8))) - level
        least = np.where(rise > SHADOW_HEIGHT_M, np.minimum(least, near / np.maximum(rise, 1e-6)), least)
    return least.astype(np.float32)


def unobstructed(ground: Ground, points: Array, normals: Array, eye: Array) -> NDArray[np.bool_]:
    """Whether the straight line from each point (n, 3) to the eye (3,) is free."""
    start = points + OFF_SURFACE_M * normals
    away = eye - start
    distance = np.linalg.norm(away, axis=1)
    return np.asarray(ground.scene.cast(start, away / distance[:, None]) >= distance)
