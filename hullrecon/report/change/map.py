# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The map of changes: the hull's chart seen from outside, coloured by how far the surface moved."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.change import CHANGED, HullChange, ObjectChange
from hullrecon.report.figures.style import GRAY, INK, new_figure, png_bytes

LIMITS_MM = 50.0  # structures go beyond; the hull's own form would be invisible on their scale
MAX_PIXELS = 4_000_000  # of the picture's image


def change_png(change: HullChange, outside: OutsideMap) -> bytes:
    """Return the picture."""
    from matplotlib.patches import Polygon

    grid = change.map
    low, step = grid.lattice.origin, grid.lattice.step_m
    high = low + step * (np.array(grid.lattice.shape) - 1)
    ends = outside.to_map(np.stack([low, high]))
    width, height = np.abs(ends[1] - ends[0])
    figure, (axis,) = new_figure(9.0, float(min(9.0, max(2.6, 8.0 * height / max(width, 1e-6) + 1.2))))
    skip = max(1, int(np.ceil(np.sqrt(grid.change.size / MAX_PIXELS))))
    extent = (float(ends[0, 0]), float(ends[1, 0]), float(ends[0, 1]), float(ends[1, 1]))
    seen = np.where(grid.first_seen & grid.second_seen, np.nan, np.where(grid.first_seen | grid.second_seen, 1.0, np.nan))
    pictures = {"Greys": (seen, 0.0, 4.0), "RdBu_r": (1000 * grid.change, -LIMITS_MM, LIMITS_MM)}
    for colours, (values, least, most) in pictures.items():
        shown = axis.imshow(values[::skip, ::skip].T, origin="lower", extent=extent, cmap=colours, vmin=least, vmax=most,
                            interpolation="nearest", aspect="equal")  # fmt: skip
    bar = figure.colorbar(shown, ax=axis, shrink=0.9, pad=0.01, extend="both")
    bar.set_label("change (mm), outward positive", size=9)
    bar.ax.tick_params(labelsize=8)
    axis.set(
        xlim=(min(extent[:2]), max(extent[:2])), ylim=(min(extent[2:]), max(extent[2:])),
        xlabel=f"x = {'-' * (outside.x_sign < 0)}along (m)", ylabel=f"y = {'-' * (outside.y_sign < 0)}girth (m)",
    )  # fmt: skip
    for row in change.objects:
        changed = row.status in CHANGED
        if len(row.outline) >= 3:
            line = Polygon(outside.to_map(row.outline), fill=False, ec=INK if changed else GRAY, lw=1.4 if changed else 0.8)
            axis.add_patch(line)
        if np.isfinite(row.along_girth).all():
            ring = outside.to_map(row.outline if len(row.outline) else row.along_girth[None])
            above = (float(ring[:, 0].mean()), float(ring[:, 1].max()))
            axis.annotate(_label(row), above, (0, 2), textcoords="offset points", fontsize=7, color=INK, ha="center",
                          bbox={"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.7})  # fmt: skip
    for move in change.moves:
        axis.add_patch(Polygon(outside.to_map(move.outline), fill=False, ec=INK, lw=1.0, ls="--"))
    return png_bytes(figure)


def _label(row: ObjectChange) -> str:
    number = row.second_id if row.second_id is not None else row.first_id
    return row.status if number is None else f"{number} {row.status}"
