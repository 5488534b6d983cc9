# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare two surveys of one hull (docs/methods.md 19)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hullrecon.change.difference import Difference, changed_regions, difference, smallest_change
from hullrecon.change.moves import surface_moves
from hullrecon.change.objects import ObjectComparison, compare_objects
from hullrecon.change.offset import estimate_offset
from hullrecon.change.options import ChangeOptions
from hullrecon.change.relief import relief_on, seen_points
from hullrecon.errors import StageError
from hullrecon.geometry.charts.address import AddressSigma
from hullrecon.geometry.charts.lattice import Lattice, lattice_around
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.change import ChangeMap, HullChange, HullSurvey
from hullrecon.typing import Array, Mask

MARGIN_M = 0.3  # by which the lattice reaches beyond what either survey saw
MAX_CELLS = 40_000_000  # most cells of the lattice: a larger survey is compared on larger cells
# About as many vertices of a CAD model are looked at when its distance to another is measured
MOST_VERTICES = 20_000
SAME_CAD_M = 0.002  # largest distance between CAD models that are taken to be of one hull
Address = Callable[[Array, AddressSigma], str]  # names a point (3,) of M, no finer than the sigma


def compare_surveys(
    first: HullSurvey,
    second: HullSurvey,
    address: Address,
    options: ChangeOptions = ChangeOptions(),  # noqa: B008
) -> HullChange:
    """Find what changed between two surveys of one hull.

    The offset between the two surveys is estimated first, and is no change of the hull. What only
    one of them saw is not compared: its objects are given as not seen before, or not seen again.

    Parameters
    ----------
    first, second
        The surveys, each in its own hull frame M. Positions are given in that of the first.
    address
        Names a point (3,) of M in words, no finer than a sigma.
    options
        Thresholds of a change. Cells are larger than its `cell_m` where they were too many.

    Raises
    ------
    StageError
        They saw too little of the same hull.
    """
    chart = first.chart
    seen = [seen_points(survey, chart)[0][:, :2] for survey in (first, second)]
    if min(len(at) for at in seen) == 0:
        raise StageError(
            "one of the dives saw nothing of the hull",
            remedy="compare dives with cameras that found the hull",
        )
    lattice = _lattice(np.vstack(seen), options)
    options = replace(options, cell_m=lattice.step_m)
    # Estimate the second survey's offset in the first survey's frame
    before = relief_on(lattice, chart, first)
    offset = estimate_offset(
        first, second, chart, lattice, (before, relief_on(lattice, chart, second))
    )
    # Subtract the surveys and find regions that differ
    after = relief_on(lattice, chart, second, offset.first_from_second)
    found = difference(before, after, options)
    # Number of places where an unchanged hull may look changed by chance: p-values are corrected
    # for it
    places = max(1, round(float(found.both.sum()) * options.cell_m**2 / options.min_area_m2))
    regions = changed_regions(found, places, options)
    # Conclude what became of objects and of bare hull
    context = ObjectComparison(
        chart=chart,
        lattice=lattice,
        offset=offset,
        difference=found,
        options=options,
        places=places,
    )
    objects = compare_objects(first, second, regions, context)
    moves = surface_moves(found, regions, chart, lattice, offset, options)
    # The offset's prior covariance is the sum of both hull poses', an address has the error of one.
    # Only words follow from the sigmas of girth and depth, for which a few centimetres are assumed.
    place = AddressSigma(
        along=float(np.sqrt(offset.prior_covariance[0, 0] / 2)), girth=0.05, depth=0.1
    )
    return HullChange(
        first=first.name,
        second=second.name,
        offset=offset,
        objects=tuple(
            replace(row, address=address(row.center, _address_sigma(row.sigma))) for row in objects
        ),
        moves=tuple(
            replace(row, address=address(chart.from_chart(row.along_girth[None])[0][0], place))
            for row in moves
        ),
        map=_change_map(lattice, found),
        area_both=_area(found.both, options),
        area_first=_area(np.isfinite(before.height), options),
        area_second=_area(np.isfinite(after.height), options),
        detectable_m=smallest_change(found, places, options),
        places=places,
    )


def _lattice(seen: Array, options: ChangeOptions) -> Lattice:
    """Lay cells with sides of cell_m over seen points (n, 2), larger ones if they were too many."""
    lattice = lattice_around(seen, options.cell_m, MARGIN_M)
    more = np.prod(lattice.shape) / MAX_CELLS
    return (
        lattice
        if more <= 1
        else lattice_around(seen, options.cell_m * float(np.sqrt(more)), MARGIN_M)
    )


def _change_map(lattice: Lattice, found: Difference) -> ChangeMap:
    """Keep what is drawn of a difference: the change where both surveys saw a cell, and who saw it.

    lattice: the cells of the difference.
    """
    return ChangeMap(
        lattice=lattice,
        change=np.where(found.both, found.total, np.nan),
        sigma=np.where(found.both, found.sigma, np.nan),
        first_seen=np.isfinite(found.first.height),
        second_seen=np.isfinite(found.second.height),
    )


def _address_sigma(sigma: Array) -> AddressSigma:
    return AddressSigma(
        along=float(sigma[0]), girth=float(sigma[1]), depth=float(np.hypot(sigma[1], sigma[2]))
    )


def _area(cells: Mask, options: ChangeOptions) -> float:
    return float(cells.sum() * options.cell_m**2)


def cad_model_gap(first: Mesh, second: Mesh) -> float:
    """Measure the largest distance between two CAD models, m, however they are meshed."""
    return max(_farthest_vertex(first, second), _farthest_vertex(second, first))


def _farthest_vertex(mesh: Mesh, other: Mesh) -> float:
    """Measure the largest distance of a mesh's vertices from another mesh, m.

    At most about MOST_VERTICES are looked at.
    """
    some = mesh.vertices[:: max(1, len(mesh.vertices) // MOST_VERTICES)]
    return float(np.abs(Scene(other).closest(some).distance).max(initial=0.0))
