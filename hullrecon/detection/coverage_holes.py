# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the holes of a survey: unseen parts of the hull's chart inside the surveyed area."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.detection.base_surface import BaseSurface, hull_position
from hullrecon.detection.hull_patches import PATCH_M, Facts, HullPatches
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.neighbours import nearest
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.typing import Array, Ints, Mask

CELL_M = 0.1  # side of a cell of the chart, in which holes are found
# Radius of the morphological closing of the surveyed area, in cells: bays of its rim up to twice as
# wide count as holes. Inside of it, gaps of any width do.
BRIDGE_CELLS = 6
# Side of the least bay of the rim that counts, in cells: whether one of a single cell's depth is
# closed depends on where the cells begin
BAY_CELLS = 2
MIN_HOLE_M2 = 0.03  # least area of a hole in what the camera saw


def find_holes(
    hull: HullPatches,
    seen: Mask,
    chart: Chart,
    locate: Callable[[Array], Facts],
    min_hole_m2: float = MIN_HOLE_M2,
) -> list[Facts]:
    """Find unseen parts of the chart inside the surveyed area, the largest first.

    The surveyed area is the seen cells, with bays of its rim up to 2 BRIDGE_CELLS wide and all gaps
    inside of it. Cells of the chart without hull are no holes. Cells without a patch are: without a
    CAD model the hull has patches only where something was seen. Holes smaller than `min_hole_m2`
    are left out, and bays into which no square of BAY_CELLS fits. None is found where nothing was
    seen.

    Parameters
    ----------
    hull
        Position and area of each patch.
    seen
        (n,) which patches were seen.
    chart
        Chart of the hull, in whose cells holes are found.
    locate
        Computes members of coverage.json, an address among them, from the center (3,) of a hole.
    min_hole_m2
        Least area of a hole that is returned.
    """
    from scipy import ndimage

    if not seen.any():
        return []
    cells = _chart_cells(hull, seen, chart)
    disc = (
        np.hypot(*np.mgrid[-BRIDGE_CELLS : BRIDGE_CELLS + 1, -BRIDGE_CELLS : BRIDGE_CELLS + 1])
        <= BRIDGE_CELLS
    )
    surveyed = ndimage.binary_fill_holes(ndimage.binary_closing(cells.seen, disc))
    label, count = ndimage.label(surveyed & ~cells.seen & cells.on_hull)
    rim = ndimage.binary_dilation(~surveyed)
    bay = np.ones((BAY_CELLS, BAY_CELLS), bool)
    holes = (label == k for k in range(1, count + 1))  # one mask of the chart at a time
    found = [
        _hole_facts(cells, hole, chart, locate)
        for hole in holes
        if not (hole & rim).any() or ndimage.binary_opening(hole, bay).any()
    ]
    large = [hole for hole in found if hole["area_m2"] >= min_hole_m2]
    return sorted(large, key=lambda hole: (-hole["area_m2"], hole["address"]))


@dataclass(frozen=True, kw_only=True)
class _ChartCells:
    """Square cells of the chart, CELL_M wide: arrays (a, g) by along and girth."""

    low: Ints  # (2,) number of the first cell along and in girth
    seen: Mask  # (a, g) whether a patch in the cell was seen
    unseen: Array  # (a, g) m2 of the cell's unseen patches, or of the cell where there is no patch
    on_hull: Mask  # (a, g) whether the chart has hull there


def _chart_cells(hull: HullPatches, seen: Mask, chart: Chart) -> _ChartCells:
    """Sort patches into cells of the chart, which reach BRIDGE_CELLS beyond the seen patches.

    Patches off the chart, or beyond these cells, are left out. A cell without a patch of its own is
    seen if the nearest patch is.
    """
    at = chart.to_chart(hull.mesh.vertices)[:, :2]
    known = np.asarray(np.isfinite(at).all(axis=1))
    low = np.floor(at[known & seen].min(axis=0) / CELL_M).astype(np.int64) - BRIDGE_CELLS
    size = np.floor(at[known & seen].max(axis=0) / CELL_M).astype(np.int64) + BRIDGE_CELLS + 1 - low
    cell = np.floor(np.where(known[:, None], at, 0.0) / CELL_M).astype(np.int64) - low
    known &= ((cell >= 0) & (cell < size)).all(axis=1)
    is_seen, has_patch, unseen = (
        np.zeros(tuple(size), bool),
        np.zeros(tuple(size), bool),
        np.zeros(tuple(size)),
    )
    is_seen[tuple(cell[known & seen].T)] = True
    has_patch[tuple(cell[known].T)] = True
    np.add.at(unseen, tuple(cell[known & ~seen].T), hull.area[known & ~seen])
    middle = (np.argwhere(np.ones_like(is_seen)) + low + 0.5) * CELL_M
    # Patches are hardly smaller than cells, so a cell may hold none. It is as its nearest patch is
    distance, row = nearest(at[known], middle, 1, 0.75 * PATCH_M)
    near = np.isfinite(distance[:, 0]) & ~has_patch.ravel()
    is_seen.ravel()[near] = seen[known][row[near, 0]]
    on_hull = np.asarray(np.isfinite(chart.from_chart(middle)[0]).all(axis=1)).reshape(
        is_seen.shape
    )
    return _ChartCells(
        low=low,
        seen=is_seen,
        unseen=np.where(has_patch | is_seen, unseen, CELL_M**2),
        on_hull=on_hull,
    )


def _hole_facts(
    cells: _ChartCells, hole: Mask, chart: Chart, locate: Callable[[Array], Facts]
) -> Facts:
    """Measure a hole: centre, address and area, for coverage.json.

    The centre is the cell of the hole nearest to the mean of its cells, as the mean itself may lie
    outside. The area counts unseen patches in the seen cells around the hole too, as one
    seen patch makes its cell seen.

    Parameters
    ----------
    cells
        The cells of the chart.
    hole
        (a, g) the hole's cells.
    chart
        From along and girth to positions in its frame, M or g.
    locate
        Computes address and sigmas from the center (3,) m in that frame.
    """
    from scipy import ndimage

    which = np.argwhere(hole)
    inner = which[np.argmin(np.linalg.norm(which - which.mean(axis=0), axis=1))]
    center = chart.from_chart(((inner + cells.low + 0.5) * CELL_M)[None])[0][0]
    around = ndimage.binary_dilation(hole, np.ones((3, 3), bool)) & (hole | cells.seen)
    return {
        **locate(center),
        "center": [round(float(v), 3) for v in center],
        "area_m2": round(float(cells.unseen[around].sum()), 4),
    }


def locate_hole(center: Array, base: BaseSurface, track: VehicleTrack) -> Facts:
    """Compute the position of a hole's middle (3,), as members of coverage.json.

    Nothing was measured in a hole. So its covariance is that of the nearest pose of the path, with
    the sigma of a cell of the chart added. Its normal points to that pose. center: m, in the frame
    of the base.
    """
    near = int(np.argmin(np.linalg.norm(track.poses.translation - center, axis=1)))
    toward = track.poses.translation[near] - center
    normal = toward / max(float(np.linalg.norm(toward)), 1e-9)
    covariance = track.covariance[near : near + 1, :3, :3]
    return hull_position(center, normal, covariance, 0.0, CELL_M / np.sqrt(12), base).members(base)
