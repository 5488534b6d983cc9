# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Values on a surface drawn on the hull's chart: the deviation map, and the painted ground of the plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.records.surface import Surface
from hullrecon.report.figures.style import new_figure, png_bytes
from hullrecon.typing import Array, Ints32


@dataclass(frozen=True)
class Extent:
    """A rectangle of the chart, metres. flips: drawn with along to the left, girth downwards (geometry.outside)."""

    along: tuple[float, float]
    girth: tuple[float, float]
    flips: tuple[bool, bool] = (False, False)

    @property
    def drawn(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Left and right, bottom and top of a CAD model."""
        along, girth = (s[::-1] if f else s for s, f in zip((self.along, self.girth), self.flips, strict=True))
        return (along[0], along[1]), (girth[0], girth[1])

    @property
    def size(self) -> tuple[float, float]:
        return self.along[1] - self.along[0], self.girth[1] - self.girth[0]


@dataclass(frozen=True)
class ChartedSurface:
    """A surface with its vertices on the chart, at (n, 2); faces outside the chart or across its seam are left out."""

    surface: Surface
    at: Array
    faces: Ints32


def charted(surface: Surface, chart: Chart) -> ChartedSurface:
    at = chart.to_chart(surface.vertices)[:, :2]
    corners = at[surface.faces]
    span = np.ptp(corners, axis=1).max(axis=1)
    edge = np.linalg.norm(surface.vertices[surface.faces[:, 0]] - surface.vertices[surface.faces[:, 1]], axis=1)
    return ChartedSurface(surface, at, surface.faces[np.isfinite(span) & (span < 4 * edge + 0.5)])


def extent_of(points: Array, flips: tuple[bool, bool], margin_m: float = 0.4) -> Extent:
    """Bounds of chart points (n, 2) with a margin; rows with NaN are left out."""
    good = points[np.isfinite(points).all(axis=1)]
    low, high = good.min(axis=0) - margin_m, good.max(axis=0) + margin_m
    return Extent((float(low[0]), float(high[0])), (float(low[1]), float(high[1])), flips)


def seen_faces(found: ChartedSurface, least: int = 1) -> Ints32:
    """Faces whose three corners have that support."""
    return found.faces[(found.surface.support[found.faces] >= least).all(axis=1)]


def weighted_percentiles(values: Array, weights: Array, percent: tuple[float, ...]) -> Array:
    """Of values (n,) with weights (n,), by linear interpolation of the cumulated weight."""
    order = np.argsort(values, kind="stable")
    share = np.cumsum(weights[order]) - 0.5 * weights[order]
    return np.asarray(np.interp(np.array(percent) / 100 * weights.sum(), share, values[order]))


def ground_png(found: ChartedSurface, extent: Extent, width_px: int = 1400) -> bytes:
    """Seen faces in a tint that deepens with the views, transparent elsewhere; fills the extent exactly, without a frame."""
    from matplotlib.figure import Figure

    width, height = extent.size
    figure = Figure(figsize=(width_px / 100, width_px / 100 * height / width), dpi=100, frameon=False)
    axis = figure.add_axes((0, 0, 1, 1))
    axis.set(xlim=extent.drawn[0], ylim=extent.drawn[1])
    axis.axis("off")
    faces = seen_faces(found)
    if len(faces):
        views = np.minimum(found.surface.support, 8).astype(float)
        axis.tripcolor(*_safe(found.at).T, faces, views, cmap="GnBu", vmin=-4, vmax=12, shading="gouraud")
    return png_bytes(figure, transparent=True)


def deviation_png(found: ChartedSurface, extent: Extent, marks: list[tuple[str, float, float]]) -> bytes:
    """The deviation of seen faces in millimetres, blue inward, red outward; marks are labels at along, girth."""
    width, height = extent.size
    figure, axis = new_figure(7.6, min(7.0, max(2.2, 6.3 * height / width + 0.8)))
    faces = seen_faces(found)
    axis.set(xlim=extent.drawn[0], ylim=extent.drawn[1], aspect="equal", xlabel="along (m)", ylabel="girth (m)")
    if len(faces):
        value = 1000 * found.surface.deviation
        weight = np.where(np.isin(np.arange(len(value)), faces) & np.isfinite(value), vertex_areas(found.surface.mesh()), 0.0)
        top = max(10.0, float(weighted_percentiles(np.abs(np.nan_to_num(value)), weight, (99,))[0]))
        filled = np.nan_to_num(value)
        drawn: Any = axis.tripcolor(*_safe(found.at).T, faces, filled, cmap="RdBu_r", vmin=-top, vmax=top, shading="gouraud")
        bar = figure.colorbar(drawn, ax=axis, shrink=0.9, pad=0.01, extend="both")
        bar.set_label("deviation from the CAD model (mm)", size=9)
        bar.ax.tick_params(labelsize=8)
    for text, along, girth in marks:
        axis.annotate(
            text, (along, girth), fontsize=8, ha="center", va="center", bbox={"boxstyle": "circle", "fc": "white", "lw": 0.8}
        )
    return png_bytes(figure)


def _safe(at: Array) -> Array:
    """Vertices that no drawn face uses may be lost on the chart; matplotlib wants numbers all the same."""
    return np.nan_to_num(at)
