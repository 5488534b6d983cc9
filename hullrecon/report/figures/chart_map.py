# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Values of a surface on the hull's chart: the deviation map, and the background of the plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.figures.style import new_figure, png_bytes
from hullrecon.report.format_limits import reduction
from hullrecon.typing import Array, Ints32

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_NARROW = 12.0  # sides of a map of the form, as drawn


@dataclass(frozen=True, kw_only=True)
class Extent:
    """A rectangle of the chart, metres. flips: shown with along to the left, girth downwards
    (charts.viewing_side).
    """

    along: tuple[float, float]
    girth: tuple[float, float]
    flips: tuple[bool, bool] = (False, False)

    @property
    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return left and right, bottom and top of a picture of it."""
        along, girth = (
            s[::-1] if f else s for s, f in zip((self.along, self.girth), self.flips, strict=True)
        )
        return (along[0], along[1]), (girth[0], girth[1])

    @property
    def size(self) -> tuple[float, float]:
        """Return the spans along and in girth, m."""
        return self.along[1] - self.along[0], self.girth[1] - self.girth[0]


@dataclass(frozen=True, kw_only=True)
class ChartedSurface:
    """A surface with its vertices on the chart, at (n, 2); faces outside the chart or across its
    seam are left out.
    """

    surface: Surface
    at: Array
    faces: Ints32


def project_surface(surface: Surface, chart: Chart) -> ChartedSurface:
    """Return a surface with its vertices on the chart."""
    at = chart.to_chart(surface.vertices)[:, :2]
    corners = at[surface.faces]
    span = np.ptp(corners, axis=1).max(axis=1)
    edge = np.linalg.norm(
        surface.vertices[surface.faces[:, 0]] - surface.vertices[surface.faces[:, 1]], axis=1
    )
    return ChartedSurface(
        surface=surface, at=at, faces=surface.faces[np.isfinite(span) & (span < 4 * edge + 0.5)]
    )


def extent_of(points: Array, flips: tuple[bool, bool], margin_m: float = 0.4) -> Extent:
    """Return the bounds of chart points (n, 2) with a margin; rows with NaN are left out."""
    good = points[np.isfinite(points).all(axis=1)]
    low, high = good.min(axis=0) - margin_m, good.max(axis=0) + margin_m
    along, girth = (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))
    return Extent(along=along, girth=girth, flips=flips)


def seen_faces(found: ChartedSurface, min_support: int = 1) -> Ints32:
    """Return the faces whose three corners have that support."""
    return found.faces[(found.surface.support[found.faces] >= min_support).all(axis=1)]


def weighted_percentiles(values: Array, weights: Array, percent: tuple[float, ...]) -> Array:
    """Return percentiles of values (n,) with weights (n,), by linear interpolation of the cumulated
    weight.
    """
    order = np.argsort(values, kind="stable")
    share = np.cumsum(weights[order]) - 0.5 * weights[order]
    return np.asarray(np.interp(np.array(percent) / 100 * weights.sum(), share, values[order]))


def ground_png(found: ChartedSurface, extent: Extent, width_px: int = 1400) -> bytes:
    """Return a picture of the seen faces, tinted by views, transparent elsewhere.

    It fills the extent without a frame; a tall one is at most twice width_px high.
    """
    from matplotlib.figure import Figure

    width, height = extent.size
    height_px = width_px * height / width
    shrink = 100 * reduction(width_px, height_px, 2 * width_px)
    figure = Figure(
        figsize=(max(0.01, width_px / shrink), max(0.01, height_px / shrink)),
        dpi=100,
        frameon=False,
    )
    axis = figure.add_axes((0, 0, 1, 1))
    axis.set(xlim=extent.limits[0], ylim=extent.limits[1])
    axis.axis("off")
    faces = seen_faces(found)
    if len(faces):
        views = np.minimum(found.surface.support, 8).astype(float)
        axis.tripcolor(
            *_finite(found.at), faces, views, cmap="GnBu", vmin=-4, vmax=12, shading="gouraud"
        )
    return png_bytes(figure, transparent=True)


@dataclass(frozen=True, kw_only=True)
class Shading:
    """How values are coloured: the colours' name, the values at their ends, the legend, and which
    end goes on.
    """

    colours: str
    low: float
    high: float
    label: str
    extend: str


def form_shadings(found: ChartedSurface, split: DeviationSplit) -> tuple[Shading, Shading] | None:
    """Return how the form of the deviation (mm) and its sigma (mm) are coloured; None where nothing
    was seen. The bare hull sets the ends: five times the median, since it is most of the area;
    structures are beyond them.
    """
    weight = np.where(np.isfinite(split.form), vertex_areas(found.surface.mesh()), 0.0)
    if not weight.sum() > 0:
        return None
    form, sigma = 1000 * np.nan_to_num(split.form), 1000 * np.nan_to_num(split.form_sigma)
    top = max(5.0, 5 * float(weighted_percentiles(np.abs(form), weight, (50,))[0]))
    most = max(2.0, float(weighted_percentiles(sigma, weight, (95,))[0]))
    return (
        Shading(colours="RdBu_r", low=-top, high=top, label="form (mm)", extend="both"),
        Shading(
            colours="viridis", low=0, high=most, label="one sigma of the form (mm)", extend="max"
        ),
    )


def form_png(
    found: ChartedSurface,
    split: DeviationSplit,
    extent: Extent,
    marks: list[tuple[str, float, float]],
) -> bytes:
    """Draw maps of the form (blue inward, red outward) and of its sigma, of the seen faces, in mm.

    They lie below each other, those of a tall hull beside each other. marks: labels at along and
    girth.
    """
    width, height = extent.size
    if height > 1.5 * width:
        figure, axes = new_figure(7.6, min(9.0, max(4.0, 3.0 * height / width)), columns=2)
    else:
        figure, axes = new_figure(7.6, 2 * min(5.0, max(1.8, 6.0 * height / width + 0.6)), rows=2)
    fields = (1000 * np.nan_to_num(split.form), 1000 * np.nan_to_num(split.form_sigma))
    for axis, values, shading in zip(axes, fields, form_shadings(found, split) or (), strict=False):
        _draw_field(axis, found, values, shading)
    # a strip is drawn wider than it is: of 330 m by 2 m nothing would be seen
    stretch = max(1.0, width / height / MOST_NARROW) / max(1.0, height / width / MOST_NARROW)
    for axis in axes:
        axis.set(
            xlim=extent.limits[0],
            ylim=extent.limits[1],
            aspect="equal" if stretch == 1 else stretch,
            xlabel="along (m)" + (f", {1 / stretch:.0f} times as large" if stretch < 1 else ""),
            ylabel="girth (m)" + (f",\n{stretch:.0f} times as large" if stretch > 1 else ""),
        )
    for text, along, girth in marks:
        axes[0].annotate(
            text,
            (along, girth),
            fontsize=8,
            ha="center",
            va="center",
            bbox={"boxstyle": "circle", "fc": "white", "lw": 0.8},
        )
    return png_bytes(figure)


def _draw_field(axis: Axes, found: ChartedSurface, values: Array, shading: Shading) -> None:
    faces = seen_faces(found)
    if not len(faces):
        return
    drawn = axis.tripcolor(
        *_finite(found.at),
        faces,
        values,
        cmap=shading.colours,
        vmin=shading.low,
        vmax=shading.high,
        shading="gouraud",
    )
    bar = axis.figure.colorbar(drawn, ax=axis, shrink=0.9, pad=0.01, extend=shading.extend)
    bar.set_label(shading.label, size=9)
    bar.ax.tick_params(labelsize=8)


def _finite(at: Array) -> tuple[Array, Array]:
    """Return along and girth without NaN: matplotlib wants numbers for vertices off the chart,
    which no shown face uses.
    """
    along, girth = np.nan_to_num(at).T
    return along, girth
