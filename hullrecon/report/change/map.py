# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The map of changes: the hull's chart seen from outside, coloured by how far the surface moved."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.change import CHANGED, ChangeMap, HullChange, ObjectChange
from hullrecon.report.figures.plan_view import nice_below
from hullrecon.report.figures.style import GRAY, INK, new_figure, png_bytes
from hullrecon.typing import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Polygon

# Ends of the colour scale. Structures exceed them: on a scale that holds structures, changes of the
# bare hull would be invisible.
LIMITS_MM = 50.0
MAX_PIXELS = 4_000_000  # of the picture's image
CHANGED_OBJECT, OTHER_OBJECT, MOVED_HULL, ONE_DIVE_ONLY = (
    "object that changed", "other object", "bare hull that moved", "seen by one dive only"
)  # fmt: skip


# How matplotlib draws each kind of outline: inside, line, its width in points
OUTLINES: dict[str, dict[str, Any]] = {
    CHANGED_OBJECT: {"fc": "none", "ec": INK, "lw": 1.4},
    OTHER_OBJECT: {"fc": "none", "ec": GRAY, "lw": 0.8},
    MOVED_HULL: {"fc": "none", "ec": INK, "lw": 1.0, "ls": "--"},
    ONE_DIVE_ONLY: {"fc": "#dadada", "ec": "none", "lw": 1.0},
}


def change_png(change: HullChange, outside: OutsideMap) -> bytes:
    """Draw the map as PNG."""
    low, step = change.map.lattice.origin, change.map.lattice.step_m
    ends = outside.to_map(np.stack([low, low + step * (np.array(change.map.lattice.shape) - 1)]))
    width, height = np.abs(ends[1] - ends[0])
    figure, (axis,) = new_figure(
        9.0, float(min(9.0, max(2.9, 8.0 * height / max(width, 1e-6) + 1.5)))
    )
    _draw_cells(axis, change.map, ends)
    axis.set(
        xlim=sorted(ends[:, 0]),
        ylim=sorted(ends[:, 1]),
        xlabel=f"x = {'−' * (outside.x_sign < 0)}along (m)",
        ylabel=f"y = {'−' * (outside.y_sign < 0)}girth (m)",
    )
    for row in change.objects:
        _draw_object(axis, row, outside)
    for move in change.moves:
        axis.add_patch(_outline(outside.to_map(move.outline), MOVED_HULL))
    _draw_scale(axis)
    kinds = [kind for kind in OUTLINES if kind != MOVED_HULL or change.moves]
    handles = [_outline(np.zeros((3, 2)), kind) for kind in kinds]
    figure.legend(
        handles, kinds, loc="outside lower center", ncols=len(kinds), fontsize=8, frameon=False
    )
    return png_bytes(figure)


def _draw_cells(axis: Axes, grid: ChangeMap, ends: Array) -> None:
    """Draw how far each cell moved, grey if only one dive saw it.

    `ends` (2, 2) are the first and last cell on the map, m.
    """
    skip = max(1, int(np.ceil(np.sqrt(grid.change.size / MAX_PIXELS))))
    extent = (float(ends[0, 0]), float(ends[1, 0]), float(ends[0, 1]), float(ends[1, 1]))
    one_only = np.where(grid.first_seen ^ grid.second_seen, 1.0, np.nan)
    pictures = {
        "Greys": (one_only, 0.0, 4.0),
        "RdBu_r": (1000 * grid.change, -LIMITS_MM, LIMITS_MM),
    }
    for colours, (values, least, most) in pictures.items():
        shown = axis.imshow(
            values[::skip, ::skip].T,
            origin="lower",
            extent=extent,
            cmap=colours,
            vmin=least,
            vmax=most,
            interpolation="nearest",
            aspect="equal",
        )
    bar = axis.figure.colorbar(shown, ax=axis, shrink=0.9, pad=0.01, extend="both")
    bar.set_label("change (mm), outward positive", size=9)
    bar.ax.tick_params(labelsize=8)


def _draw_object(axis: Axes, row: ObjectChange, outside: OutsideMap) -> None:
    """Draw an object's outline, with its label above."""
    if len(row.outline) >= 3:
        axis.add_patch(
            _outline(
                outside.to_map(row.outline),
                CHANGED_OBJECT if row.status in CHANGED else OTHER_OBJECT,
            )
        )
    if not np.isfinite(row.along_girth).all():
        return
    ring = outside.to_map(row.outline if len(row.outline) else row.along_girth[None])
    above = (float(ring[:, 0].mean()), float(ring[:, 1].max()))
    axis.annotate(
        _label(row),
        above,
        (0, 2),
        textcoords="offset points",
        fontsize=7,
        color=INK,
        ha="center",
        bbox={"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.7},
    )


def _draw_scale(axis: Axes) -> None:
    """Draw a bar of a round length in the lower left corner."""
    (left, right), (bottom, top) = axis.get_xlim(), axis.get_ylim()
    span = nice_below((right - left) / 4)
    start, level = left + 0.02 * (right - left), bottom + 0.05 * (top - bottom)
    axis.plot([start, start + span], [level, level], color=INK, lw=2.5, solid_capstyle="butt")
    axis.annotate(
        f"{span:g} m",
        (start + span / 2, level),
        (0, 3),
        textcoords="offset points",
        fontsize=8,
        color=INK,
        ha="center",
    )


def _outline(ring: Array, kind: str) -> Polygon:
    """Make the patch of an outline, ring (n, 2) on the map, in the style of its kind."""
    from matplotlib.patches import Polygon

    return Polygon(ring, **OUTLINES[kind])


def _label(row: ObjectChange) -> str:
    """Label an object by its number in the second dive, if it has one, and its status."""
    if row.second_id is not None:
        return f"{row.second_id} {row.status}"
    return row.status if row.first_id is None else f"{row.status} (was {row.first_id})"
