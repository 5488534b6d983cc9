# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Difference of two surveys by cells: change of the hull's form, and of structures on it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hullrecon.change.options import ChangeOptions
from hullrecon.change.relief import Relief, local_median
from hullrecon.geometry.robust import robust_sigma
from hullrecon.typing import Array, Mask

CELL_SIGMAS = 3.0  # least change of each cell of a region, in its sigmas
RING_M = 0.15  # width of the ring of unchanged hull around a structure
RING_CELLS = 8  # largest number of independent measurements in the cells of that ring
TOP_SHARE = 0.8  # cells that change at least this share of the largest change are the top


@dataclass(frozen=True, kw_only=True)
class Difference:
    """The difference of two reliefs in cells (a, g), NaN unless both surveys saw the hull."""

    first: Relief  # relief of the first survey
    second: Relief  # relief of the second, in the first's frame
    total: Array  # m, second minus first
    form: Array  # m, the part of `total` that is wider than a structure: its running median
    local: Array  # m, the rest: structures
    # m, how far the second survey's height is outside the range of the first's heights within
    # edge_m: 0 inside, so that a shifted edge is no change
    beyond: Array
    sigma: Array  # m, of `local`
    both: Mask  # both surveys saw the cell well enough
    bare: Mask  # the first survey shows no structure in the cell


def difference(first: Relief, second: Relief, options: ChangeOptions) -> Difference:
    """Subtract the first survey from the second, on the same cells, and split the difference.

    Its wide part is form, in which the hull may have been dented. The rest is of structures. The
    sigma of a cell is that of both surveys, plus the robust sigma of all differences: surveys
    differ by this much where nothing changed.
    """
    total, width = second.height - first.height, round(options.smooth_m / options.cell_m)
    form = local_median(total, width)
    local = total - form
    seen = well_seen(first, options) & well_seen(second, options) & np.isfinite(local)
    own = np.hypot(first.sigma, second.sigma)
    rough = robust_sigma(local[seen], about=0.0) if seen.any() else np.nan
    with np.errstate(invalid="ignore"):
        bare = np.abs(first.height - local_median(first.height, width)) < options.min_change_m
    return Difference(
        first=first,
        second=second,
        total=total,
        form=form,
        local=local,
        beyond=_beyond(second.height - form, first.height, round(options.edge_m / options.cell_m)),
        sigma=np.hypot(own, rough),
        both=seen,
        bare=bare,
    )


def well_seen(relief: Relief, options: ChangeOptions) -> Mask:
    """Select cells (a, g) at which a survey would have shown a structure.

    It takes enough images and a surface that is known well enough.
    """
    with np.errstate(invalid="ignore"):
        return (relief.views >= options.min_views) & (relief.sigma <= options.max_sigma_m)


def _beyond(height: Array, other: Array, cells: int) -> Array:
    """Measure how far heights (a, g) lie outside the other survey's range [docs/methods.md (71)].

    An edge that lies a little beside where the other survey has it is inside that range.

    Parameters
    ----------
    height
        Heights of one survey.
    other
        Heights of the other one, which give the range.
    cells
        Radius of the neighbourhood in which the range of `other` is taken.

    Returns
    -------
    beyond
        m, positive above the range, negative below, 0 inside, NaN where either is unknown.
    """
    from scipy.ndimage import maximum_filter, minimum_filter

    # a disc of cells
    reach = np.hypot(*np.mgrid[-cells : cells + 1, -cells : cells + 1]) <= cells + 0.5
    known = np.isfinite(other)
    top = maximum_filter(
        np.where(known, other, -np.inf), footprint=reach, mode="constant", cval=-np.inf
    )
    bottom = minimum_filter(
        np.where(known, other, np.inf), footprint=reach, mode="constant", cval=np.inf
    )
    out = np.where(height > top, height - top, np.where(height < bottom, height - bottom, 0.0))
    return np.where(
        np.isfinite(height) & known & np.isfinite(top) & np.isfinite(bottom), out, np.nan
    )


@dataclass(frozen=True, kw_only=True)
class ChangedRegion:
    """A connected region of cells (a, g) at which a structure changed."""

    cells: Mask
    top: Mask  # (a, g) cells that changed most
    change: float  # m, of the top relative to the hull around
    sigma: float  # m, of the change
    before: float  # m, height of the top above the hull around in the first survey
    after: float  # m, the same in the second survey
    p_value: float  # of such a change by noise, corrected for the number of places tested


def changed_regions(found: Difference, places: int, options: ChangeOptions) -> list[ChangedRegion]:
    """Find regions that changed beyond both surveys' errors, the largest change first.

    Regions smaller than min_area_m2, and changes that are too small or that chance may explain, are
    left out. places: number of places tested, for which p-values are corrected.
    """
    from scipy import ndimage

    # Raised and sunken changes separately: connected cells beyond the threshold, small gaps closed
    threshold = np.maximum(options.min_change_m, CELL_SIGMAS * found.sigma)
    near = np.ones((3, 3), bool)
    regions: list[ChangedRegion] = []
    for sign in (1.0, -1.0):
        with np.errstate(invalid="ignore"):
            off = found.both & (sign * found.beyond > threshold)
        label, count = ndimage.label(ndimage.binary_closing(off, near), near)
        for number, window in enumerate(ndimage.find_objects(label, count), start=1):
            part = (label[window] == number) & found.both[window]
            if part.sum() * options.cell_m**2 >= options.min_area_m2:
                cells = np.zeros(label.shape, bool)
                cells[window] = part
                regions.append(
                    measure_change(
                        found, cells, _near_largest(sign * found.local, cells), places, options, off
                    )
                )
    # Those whose change is large enough, and beyond chance
    good = [
        r
        for r in regions
        if r.p_value <= options.max_p_value and abs(r.change) >= options.min_change_m
    ]
    return sorted(good, key=lambda region: -abs(region.change))


def _near_largest(values: Array, cells: Mask) -> Mask:
    """Select the cells whose values are at least TOP_SHARE of their 90th percentile.

    All cells where none is.
    """
    top = cells & (values >= TOP_SHARE * float(np.percentile(values[cells], 90)))
    return top if top.any() else cells


def top_of(heights: Array, cells: Mask, sign: float) -> Mask:
    """Select the top of a structure, raised (sign 1) or sunken (-1), on which its height is taken.

    heights: (a, g) m. cells: (a, g) those of the structure.
    """
    above = sign * heights
    return _near_largest(
        above - float(np.nanpercentile(above[cells], 2)), cells & np.isfinite(heights)
    )


def measure_change(
    found: Difference,
    cells: Mask,
    top: Mask,
    places: int,
    options: ChangeOptions,
    off: Mask | None = None,
) -> ChangedRegion:
    """Measure the change at the top of a region, relative to the hull around it.

    Where no unchanged bare hull is around, the change is not relative, and the heights are NaN.

    Parameters
    ----------
    found
        The difference of the surveys, with their reliefs.
    cells
        Cells (a, g) of the region, around which unchanged hull is looked for.
    top
        Cells (a, g) of its top, over which medians are taken.
    places
        Number of places tested, for which the p-value is corrected.
    options
        Thresholds of a change.
    off
        All cells (a, g) that changed, which are no unchanged hull around the region.
    """
    ring = ring_around(cells, np.zeros_like(cells) if off is None else off, found, options)
    level = spread = 0.0
    heights = [np.nan, np.nan]
    if ring.any():
        level = float(np.median(found.local[ring]))
        spread = robust_sigma(found.local[ring]) / np.sqrt(min(RING_CELLS, int(ring.sum())))
        reliefs = (found.first.height, found.second.height)
        heights = [float(np.median(height[top]) - np.median(height[ring])) for height in reliefs]
    change = float(np.median(found.local[top])) - level
    sigma = float(np.hypot(np.median(found.sigma[top]), spread))
    return ChangedRegion(
        cells=cells, top=top, change=change, sigma=sigma, before=heights[0], after=heights[1],
        p_value=corrected_p_value(change, sigma, places),
    )  # fmt: skip


def smallest_change(found: Difference, places: int, options: ChangeOptions) -> float:
    """Estimate the smallest change of height that would be reported, m, as a median over cells.

    Cells are those that both surveys saw. NaN without such cells. The hull around a structure is
    assumed to be as rough as elsewhere. places: number of places tested.
    """
    sigma = found.sigma[found.both] * np.sqrt(1 + 1 / RING_CELLS)
    if not len(sigma):
        return float("nan")
    return float(
        np.median(np.maximum(options.min_change_m, significant_sigmas(places, options) * sigma))
    )


def ring_around(cells: Mask, off: Mask, found: Difference, options: ChangeOptions) -> Mask:
    """Select the ring of unchanged bare hull around a region's cells (a, g).

    Heights of the region are counted from it. It may be empty. It begins 2 edge_m from the region,
    beyond the blur of edges. off: cells of all regions that changed, which are left out.
    """
    from scipy.ndimage import distance_transform_edt

    within_m, reach_m = 2 * options.edge_m, 2 * options.edge_m + RING_M
    window = _window(cells, math.ceil(reach_m / options.cell_m))
    distance = np.asarray(distance_transform_edt(~cells[window])) * options.cell_m
    ring = np.zeros(cells.shape, bool)
    ring[window] = (distance > within_m) & (distance < reach_m)
    return ring & found.both & ~off & found.bare


def _window(cells: Mask, margin: int) -> tuple[slice, slice]:
    """Choose the part of the lattice around a region's cells, with a margin of `margin` cells.

    It is the whole lattice where the region has no cell. Distances are computed in that part alone,
    as a lattice has millions of cells.
    """
    rows, columns = (np.flatnonzero(cells.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return slice(None), slice(None)
    along, girth = (
        slice(max(0, int(k[0]) - margin), int(k[-1]) + margin + 1) for k in (rows, columns)
    )
    return along, girth


def corrected_p_value(value: float, sigma: float, places: int) -> float:
    """Compute the two-sided p-value of a value with this sigma [docs/methods.md (72)].

    It is corrected for the number of independent places at which as large a value may turn up.
    """
    from scipy.special import log_ndtr

    one = np.log(2.0) + float(log_ndtr(-abs(value) / max(sigma, 1e-9)))
    return float(-np.expm1(max(1, places) * np.log1p(-min(np.exp(one), 1 - 1e-16))))


def significant_sigmas(places: int, options: ChangeOptions) -> float:
    """Compute how many sigmas a change needs: the inverse of `corrected_p_value`.

    It is at least CELL_SIGMAS, which each cell of a region needs.
    """
    from scipy.special import ndtri

    one = -np.expm1(np.log1p(-options.max_p_value) / max(1, places))
    return max(CELL_SIGMAS, float(-ndtri(one / 2)))
