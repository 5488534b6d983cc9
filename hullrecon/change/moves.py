# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Bare hull that moved, as a dent: patches without structures at which the surface is elsewhere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.change.difference import ChangedRegion, Difference, corrected_p_value
from hullrecon.change.offset import offset_sigma
from hullrecon.change.options import ChangeOptions
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.lattice import Lattice
from hullrecon.records.change import SurfaceMove, SurveyOffset
from hullrecon.typing import Array, Mask

MARGIN_CELLS = 3  # around a changed structure, which are not taken for bare hull
MIN_SHARE = 0.5  # least share of a patch's cells that must be bare hull that both surveys saw


def surface_moves(
    found: Difference,
    regions: Sequence[ChangedRegion],
    chart: Chart,
    lattice: Lattice,
    offset: SurveyOffset,
    options: ChangeOptions,
) -> tuple[SurfaceMove, ...]:
    """Find stretches of bare hull that moved beyond the errors, the largest move first.

    The hull is tested patch by patch. Patches of which too little was seen are left out, and
    patches that touch and all moved outward, or all inward, become one stretch. Empty if nothing
    moved.

    Parameters
    ----------
    found
        The difference of the surveys.
    regions
        Regions in which structures changed, which are no bare hull.
    chart, lattice
        The hull's chart, and the cells on it.
    offset
        Between the surveys, with its covariance, which adds to the error of a move.
    options
        Thresholds of a change.
    """
    from scipy import ndimage

    # Bare hull: cells that both surveys saw and where no structure changed, nor close by
    with np.errstate(invalid="ignore"):
        bare = found.both & (np.abs(found.local) < options.min_change_m)
    for region in regions:
        bare &= ~ndimage.binary_dilation(region.cells, iterations=MARGIN_CELLS)
    # Test each patch, with p-values corrected for the number of patches
    move, sigma, patch_cells = _measure_patches(found, bare, chart, lattice, offset, options)
    patches = int(np.isfinite(move).sum())
    p_value = np.ones(move.shape)
    for i, j in np.argwhere(np.isfinite(move)):
        p_value[i, j] = corrected_p_value(float(move[i, j]), float(sigma[i, j]), patches)
    moved = (p_value <= options.max_p_value) & (np.abs(np.nan_to_num(move)) >= options.min_move_m)
    # Join patches that moved outward, then those that moved inward
    rows = []
    for sign in (1.0, -1.0):
        label, count = ndimage.label(
            moved & (sign * np.nan_to_num(move) > 0), np.ones((3, 3), bool)
        )
        for number in range(1, count + 1):
            rows.append(
                _join_patches(label == number, move, sigma, p_value, bare, patch_cells, lattice)
            )
    return tuple(sorted(rows, key=lambda row: -abs(row.move)))


def _measure_patches(
    found: Difference,
    bare: Mask,
    chart: Chart,
    lattice: Lattice,
    offset: SurveyOffset,
    options: ChangeOptions,
) -> tuple[Array, Array, int]:
    """Measure by patch how far bare hull moved.

    Returns
    -------
    move
        (i, j) by patch, m along the CAD model's normal, outward positive, NaN where too little bare
        hull was seen.
    sigma
        (i, j) m.
    patch_cells
        Cells along a side of a patch.
    """
    patch_cells = max(1, round(options.patch_m / options.cell_m))
    shape = [-(-n // patch_cells) for n in found.total.shape]
    move, sigma = np.full(shape, np.nan), np.full(shape, np.nan)
    own, middles = np.hypot(found.first.sigma, found.second.sigma), lattice.points()
    for i, j in np.ndindex(*shape):
        block = np.s_[
            i * patch_cells : (i + 1) * patch_cells, j * patch_cells : (j + 1) * patch_cells
        ]
        cells = bare[block]
        if cells.sum() < MIN_SHARE * patch_cells**2:
            continue
        point, normal = chart.from_chart(middles[block][cells].mean(axis=0)[None])
        if not np.isfinite(point).all():
            continue
        move[i, j] = np.median(found.total[block][cells])
        sigma[i, j] = np.hypot(np.median(own[block][cells]), offset_sigma(offset, point, normal)[0])
    return move, sigma, patch_cells


def _join_patches(
    which: Mask,
    move: Array,
    sigma: Array,
    p_value: Array,
    bare: Mask,
    patch_cells: int,
    lattice: Lattice,
) -> SurfaceMove:
    """Join neighbouring patches that moved the same way, outward or inward, to one stretch.

    Its move and sigma are the patches' medians, its p-value the least of theirs.

    Parameters
    ----------
    which
        The patches (i, j) that are joined.
    move, sigma, p_value
        Move and sigma, m, and p-value of every patch (i, j).
    bare
        Cells (a, g) of bare hull. The stretch has no others.
    patch_cells
        Cells along a side of a patch.
    lattice
        Gives the cells' position and area.
    """
    cells = (
        np.kron(which, np.ones((patch_cells, patch_cells), bool))[: bare.shape[0], : bare.shape[1]]
        & bare
    )
    at = lattice.points()[cells].mean(axis=0)
    return SurfaceMove(
        along_girth=at,
        outline=lattice.outline(cells),
        move=float(np.median(move[which])),
        move_sigma=float(np.median(sigma[which])),
        p_value=float(p_value[which].min()),
        area=float(cells.sum() * lattice.step_m**2),
    )
