# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Heights of a hull as found over its CAD model, on the cells of the chart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.lattice import Lattice
from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.poses import Poses
from hullrecon.records.change import HullSurvey
from hullrecon.typing import Array, Ints

REACH_CELLS = 2.0  # a cell farther than this from every seen vertex counts as unseen


@dataclass(frozen=True, kw_only=True)
class Relief:
    """Heights of a survey over the CAD model, in cells (a, g) along the hull and in girth."""

    height: Array  # m, outward positive, NaN where unseen
    sigma: Array  # m, of the form: without the error by which the whole survey may be off
    views: Ints  # images that saw the cell


def seen_points(survey: HullSurvey, chart: Chart, move: Poses | None = None) -> tuple[Array, Ints]:
    """Convert a survey's seen vertices to chart coordinates.

    Those whose form (the deviation without the survey's offset and tilts) has no sigma cannot be
    compared, and are left out, as are those off the chart. Returns along, girth and offset (n, 3)
    m, and the row of each in `survey.as_found`. `move`: rigid motion in M that is applied to the
    vertices first.
    """
    found = survey.as_found
    rows = np.flatnonzero((found.support > 0) & np.isfinite(survey.form_sigma))
    vertices = found.vertices[rows] if move is None else move.apply(found.vertices[rows])
    at = chart.to_chart(vertices)
    known = np.isfinite(at).all(axis=1)
    return at[known], rows[known]


def relief_on(
    lattice: Lattice, chart: Chart, survey: HullSurvey, move: Poses | None = None
) -> Relief:
    """Sample a survey on a lattice: heights linear between vertices, the rest of the nearest one.

    Cells farther than REACH_CELLS from every seen vertex are unseen. So are all with fewer than
    four such vertices. `move`: rigid motion in M that is applied to the vertices first.
    """
    from scipy.interpolate import LinearNDInterpolator

    at, rows = seen_points(survey, chart, move)
    middles = lattice.points().reshape(-1, 2)
    if len(at) < 4:
        lost = np.full(lattice.shape, np.nan)
        return Relief(height=lost, sigma=lost, views=np.zeros(lattice.shape, np.int64))
    # Between vertices far apart, linear interpolation would invent a surface: such cells are unseen
    distance, row = nearest(at[:, :2], middles, 1)
    seen = distance[:, 0] <= REACH_CELLS * lattice.step_m
    height = np.full(len(middles), np.nan)
    height[seen] = LinearNDInterpolator(at[:, :2], at[:, 2])(middles[seen])
    seen &= np.isfinite(height)
    sigma = np.where(seen, survey.form_sigma[rows[row[:, 0]]], np.nan)
    views = np.where(seen, survey.as_found.support[rows[row[:, 0]]], 0)
    return Relief(
        height=height.reshape(lattice.shape),
        sigma=sigma.reshape(lattice.shape),
        views=views.astype(np.int64).reshape(lattice.shape),
    )


def blur(height: Array, cells: float) -> Array:
    """Blur heights (a, g) m by a Gaussian with a sigma of `cells`, over seen cells alone.

    NaN where less than half was seen. Blurred alike, two surveys have equally soft edges, over
    which a fit converges.
    """
    from scipy.ndimage import gaussian_filter

    seen = np.isfinite(height)
    weight = gaussian_filter(seen.astype(float), cells)
    total = gaussian_filter(np.where(seen, height, 0.0), cells)
    return np.where(seen & (weight > 0.5), total / np.maximum(weight, 1e-9), np.nan)


def local_median(height: Array, window: int) -> Array:
    """Compute a running median of heights (a, g), m, over squares of `window` cells.

    NaN where nothing was seen. a and g count cells of the chart along the hull and in girth. To
    save time it is computed once for each block of a fifth of the window, over the 5 by 5 blocks
    around it, and interpolated between blocks.
    """
    # All heights of each block, then of the 5 by 5 blocks around it
    coarse = max(1, window // 5)
    blocks = [-(-n // coarse) for n in height.shape]
    padded = np.full([n * coarse for n in blocks], np.nan)
    padded[: height.shape[0], : height.shape[1]] = height
    cells = (
        padded.reshape(blocks[0], coarse, blocks[1], coarse)
        .transpose(0, 2, 1, 3)
        .reshape(*blocks, -1)
    )
    around = np.pad(cells, ((2, 2), (2, 2), (0, 0)), constant_values=np.nan)
    views = np.lib.stride_tricks.sliding_window_view(around, (5, 5), axis=(0, 1))
    middle = np.full(blocks, np.nan)
    for i, j in np.ndindex(*blocks):
        values = views[i, j]
        values = values[np.isfinite(values)]
        if len(values):
            middle[i, j] = np.median(values)
    return _interpolate_blocks(middle, coarse, height.shape)


def _interpolate_blocks(middle: Array, coarse: int, shape: tuple[int, ...]) -> Array:
    """Interpolate values of blocks (i, j), each `coarse` cells wide, linearly at every cell.

    Blocks without a value take those of blocks near by. NaN where there are none.
    """
    # A weighted blur of 0.7 blocks fills such blocks
    from scipy.ndimage import gaussian_filter, map_coordinates

    known = np.isfinite(middle)
    weight = gaussian_filter(known.astype(float), 0.7)
    smooth = gaussian_filter(np.where(known, middle, 0.0), 0.7) / np.maximum(weight, 1e-9)
    rows, columns = (((np.arange(n) + 0.5) / coarse - 0.5) for n in shape)
    grid = np.meshgrid(rows, columns, indexing="ij")
    out = map_coordinates(smooth, grid, order=1, mode="nearest")
    near = map_coordinates(weight, grid, order=1, mode="nearest")
    return np.where(near > 1e-6, out, np.nan)
