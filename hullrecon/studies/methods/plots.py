# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Cross-sections, ranges' residuals and a structure's height [Ozog2016 Figs 4.10, 4.14, 4.16]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from hullrecon.geometry.robust import robust_sigma
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    LIGHT,
    RED,
    PublishedFigure,
    colour,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue
from hullrecon.typing import Array

EXPLAINED = {
    "naive": "naive: no surface factors",
    "geva": "geva: every landmark pulled to the hull",
    "maxmix": "maxmix: on the hull or off it",
}


@dataclass(frozen=True, kw_only=True)
class CrossSection:
    """A thin slice across the hull at a structure, as (tangent, height) m."""

    method: str
    weighting: str
    dvl: Array  # (n, 2) returns
    on: Array  # (n, 2) landmarks of label 1
    off: Array  # (n, 2) landmarks of label 0
    steel: Array  # (m, 2) the true surface
    cad_model: Array  # (m, 2) or empty

    def parts(self) -> dict[str, Array]:
        """Group the points by their kind."""
        return {
            "dvl": self.dvl,
            "on": self.on,
            "off": self.off,
            "steel": self.steel,
            "cad_model": self.cad_model,
        }


@dataclass(frozen=True, kw_only=True)
class WholeSection:
    """The same slice over the whole hull: y across and z up (m) in M."""

    on: Array  # (n, 2) landmarks of label 1
    off: Array  # (n, 2) landmarks of label 0
    dvl: Array  # (k, 2)
    cad_model: Array  # (m, 2)
    at: Array  # (2,) the structure


@dataclass(frozen=True, kw_only=True)
class DeliveredHeight:
    """A structure's height over the hull as in objects.json, with one sigma, m."""

    height_m: float
    sigma_m: float
    views: int


def cross_sections(
    rows: Sequence[Sequence[CrossSection]], overviews: Sequence[WholeSection], kind: str
) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.10] (4.11 for one camera), a column a method."""
    figure, axes = new_canvas(
        4.1 * len(rows[0]), 2.9 + 2.5 * len(rows), 1 + len(rows), len(rows[0]), sharey="row"
    )
    table = ["method,weighting,kind,tangent_m,height_m"]
    for axis, overview, section in zip(axes[0], overviews, rows[0], strict=True):
        _draw_overview(axis, overview)
        axis.set_title(EXPLAINED.get(section.method, section.method), fontsize=9)
    for axis, section in zip(
        [a for row in axes[1:] for a in row], [s for row in rows for s in row], strict=True
    ):
        _draw_section(axis, section)
        for part, points in section.parts().items():
            table += [
                f"{section.method},{section.weighting},{part},{x:.5f},{y:.5f}"
                for x, y in points.tolist()
            ]
    for axis, row in zip([row[0] for row in axes[1:]], rows, strict=True):
        axis.set_ylabel(f"{row[0].weighting}\nheight over the steel (m),\nstretched")
    axes[0][0].set_ylabel("whole section\nup (m)")
    for axis in axes[-1]:
        axis.set_xlabel("along the girth (m)")
    names = {
        label: line
        for axis in [a for row in axes for a in row]
        for line, label in zip(*axis.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        names.values(),
        names.keys(),
        loc="outside lower center",
        ncols=len(names),
        fontsize=8,
        frameon=False,
    )
    caption = (
        f"Slices across the hull at the {kind}, landmarks and DVL returns after alignment with "
        "the true path."
    )
    return finish_figure("cross_sections", figure, table, caption)


def range_histogram(
    before: Mapping[str, Array], after: Mapping[str, Array], reach_m: float
) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.14]: the ranges' residuals (m), before and after adjustment."""
    figure, axes = new_canvas(9.6, 3.4)
    axis, edges = axes[0][0], np.linspace(-reach_m, reach_m, 101)
    counts = {name: np.histogram(values, edges)[0] for name, values in {**before, **after}.items()}
    colours = dict.fromkeys(before, LIGHT) | dict(
        zip(after, (COLOURS["geva"], COLOURS["maxmix"], GREEN), strict=False)
    )
    for name, values in {**before, **after}.items():
        share = 100 * counts[name] / max(1, len(values))
        label = f"{name}:\n{1e3 * robust_sigma(values):.1f} mm, {1e3 * np.median(values):+.1f} mm"
        axis.stairs(
            share, 1e3 * edges, label=label, color=colours[name], fill=name in before, linewidth=1.8
        )
    axis.set(
        xlabel="predicted minus measured range (mm)",
        ylabel="DVL returns (%)",
        xlim=(-1e3 * reach_m, 1e3 * reach_m),
    )
    figure.legend(
        fontsize=8,
        title="robust sigma, median",
        title_fontsize=8,
        frameon=False,
        loc="outside right upper",
    )
    middle = 0.5 * (edges[1:] + edges[:-1])
    rows = zip(middle.tolist(), *(count.tolist() for count in counts.values()), strict=True)
    table = [
        ",".join(["residual_m", *counts]),
        *(",".join(f"{value:.5g}" for value in row) for row in rows),
    ]
    sigmas = "; ".join(
        f"{name} {1e3 * robust_sigma(values):.0f} mm"
        for name, values in {**before, **after}.items()
    )
    return finish_figure(
        "range_residuals",
        figure,
        table,
        f"Robust sigma of the DVL's range residuals: {sigmas}.",
        tuple(
            ComparedValue(
                what=f"robust sigma of range residuals, {name}",
                unit="mm",
                ours=1e3 * float(robust_sigma(values)),
                note='printed: "significantly smaller variance" once adjusted',
            )
            for name, values in {**before, **after}.items()
        ),
    )


def structure_heights(
    heights: Mapping[str, Array], true_m: float, kind: str, delivered: DeliveredHeight | None
) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.16]: landmarks' heights on one structure by method."""
    figure, axes = new_canvas(7.2, 3.6)
    axis, table = axes[0][0], ["what,height_m,sigma_m"]
    for k, (name, values) in enumerate(heights.items()):
        spread = np.linspace(-0.28, 0.28, len(values)) if len(values) > 1 else np.zeros(len(values))
        axis.scatter(k + spread, np.sort(values), s=7, color=colour(name), alpha=0.8, linewidths=0)
        if len(values):
            axis.hlines(np.median(values), k - 0.38, k + 0.38, color=INK, linewidth=1.6)
            _write_height(axis, k, f"{np.median(values):.3f} m")
        table += [f"{name},{value:.5f}," for value in values.tolist()]
    ticks, delivery = (
        [name.replace(" ", "\n", 1).replace("weighted ", "weighted\n") for name in heights],
        "",
    )
    if delivered is not None:
        at, height, sigma = len(heights), delivered.height_m, delivered.sigma_m
        axis.errorbar(at, height, sigma, fmt="D", color=GREEN, capsize=4, markersize=6)
        _write_height(axis, at, f"{height:.3f} ± {sigma:.3f} m")
        ticks.append("delivered\n(objects.json)")
        table.append(f"delivered,{height:.5f},{sigma:.5f}")
        delivery = (
            f"; delivered {height:.3f} m with a sigma of {sigma:.3f} m from "
            f"{delivered.views} images"
        )
    axis.axhline(
        true_m, color=GREEN, linestyle="--", linewidth=1.2, label=f"true height: {true_m:.3f} m"
    )
    axis.legend(fontsize=8, frameon=False, loc="upper left")
    axis.set_xticks(range(len(ticks)), ticks, fontsize=8)
    axis.set_ylabel(f"height of the {kind} over the hull (m)")
    ends = [
        0.0,
        true_m,
        *(float(f(v)) for v in heights.values() if len(v) for f in (np.min, np.max)),
    ]
    axis.set(
        ylim=(min(ends) - 0.2 * true_m, max(ends) + 0.25 * true_m), xlim=(-0.6, len(ticks) - 0.3)
    )
    axis.grid(False, axis="x")
    return finish_figure(
        "structure_height",
        figure,
        [*table, f"true,{true_m:.5f},"],
        f"The {kind} is {true_m:.3f} m high{delivery}.",
        ()
        if delivered is None
        else (
            ComparedValue(
                what=f"height of the {kind} over its true height",
                printed=0.10 / 0.11,
                ours=delivered.height_m / true_m,
                note="printed as 0.10 m of 0.11 m",
            ),
        ),
    )


def _write_height(axis: Axes, at: int, text: str) -> None:
    """Write a height below its column, the number `at`, at the foot of the plot."""
    axis.annotate(text, (at, 0.02), xycoords=("data", "axes fraction"), fontsize=8, ha="center")


def _draw_overview(axis: Axes, overview: WholeSection) -> None:
    """Draw the slice over the whole hull, with a ring around the structure."""
    _draw_line(axis, overview.cad_model, INK, "CAD model")
    axis.scatter(*_xy(overview.dvl), s=6, color="#8a949e", marker="x", linewidth=0.6)
    axis.scatter(*_xy(overview.on), s=2, color=COLOURS["maxmix"], linewidths=0)
    axis.scatter(*_xy(overview.off), s=2, color=RED, linewidths=0)
    axis.scatter(*_xy(overview.at[None]), s=320, facecolors="none", edgecolors=INK, linewidth=1.2)
    axis.annotate(
        "shown below",
        (overview.at[0], overview.at[1]),
        xytext=(14, -10),
        textcoords="offset points",
        fontsize=8,
        color=INK,
    )
    axis.set(xlabel="across the hull (m)", aspect="equal", adjustable="datalim")


def _draw_section(axis: Axes, section: CrossSection) -> None:
    """Draw the slice at the structure: CAD model, true steel, DVL returns, landmarks by label."""
    _draw_line(axis, section.cad_model, INK, "CAD model")
    _draw_line(axis, section.steel, GREEN, "true steel")
    axis.scatter(
        *_xy(section.dvl), s=14, color="#8a949e", marker="x", linewidth=0.8, label="DVL returns"
    )
    axis.scatter(
        *_xy(section.on),
        s=5,
        color=COLOURS["maxmix"],
        linewidths=0,
        label="landmarks on the hull (label 1)",
    )
    axis.scatter(
        *_xy(section.off), s=5, color=RED, linewidths=0, label="landmarks off the hull (label 0)"
    )
    axis.set_ylim(-0.08, 0.18)


def _xy(points: Array) -> tuple[Array, Array]:
    return points[:, 0], points[:, 1]


def _draw_line(axis: Axes, points: Array, colour_of: str, name: str) -> None:
    if len(points):
        axis.plot(*_xy(points), color=colour_of, linewidth=1.0, label=name)
