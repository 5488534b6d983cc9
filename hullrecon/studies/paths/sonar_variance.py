# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Variance of a sonar mosaic's pixels, by source of the poses [Ozog2016 Figs 3.11, 3.12]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.typing import Array

MOST_DRAWN_PX = 700  # along either side of a map
INKS = (COLOURS["geva"], COLOURS["naive"], GREEN, COLOURS["maxmix"])


@dataclass(frozen=True, kw_only=True)
class VarianceMap:
    """The variance of the intensities blended in each pixel."""

    variance: Array  # (height, width) gray levels squared, NaN where fewer than two were blended
    extent: tuple[float, float, float, float]  # left, right, bottom, top in m of the chart


def sonar_variance(maps: Mapping[str, VarianceMap]) -> PublishedFigure:
    """Draw a map per source of poses, and the share of pixels above each variance."""
    figure, axes = new_canvas(9.6, 2.0 * -(-len(maps) // 2) + 3.2, -(-len(maps) // 2) + 1, 2)
    blended = {name: found.variance[np.isfinite(found.variance)] for name, found in maps.items()}
    most = max(
        float(np.percentile(values, 95)) if len(values) else 1.0 for values in blended.values()
    )
    panels = [axis for row in axes[:-1] for axis in row]
    for axis, (name, found) in zip(panels, maps.items(), strict=False):
        step = max(1, max(found.variance.shape) // MOST_DRAWN_PX)
        drawn = axis.imshow(
            found.variance[::step, ::step],
            extent=found.extent,
            cmap="coolwarm",
            vmin=0,
            vmax=most,
            aspect="equal",
            interpolation="none",
        )
        axis.grid(False)
        axis.set_title(name, fontsize=9)
        axis.set(xlabel="along the hull (m)", ylabel="girth (m)")
    for axis in panels[len(maps) :]:
        axis.set_axis_off()
    figure.colorbar(drawn, ax=panels, label="variance (gray levels squared)", shrink=0.8)
    edges = np.linspace(0, 4 * most, 161)
    table = [",".join(["variance_at_least", *(f"share_{name.replace(' ', '_')}" for name in maps)])]
    beyond = {
        name: 1 - np.searchsorted(np.sort(v), edges) / max(len(v), 1) for name, v in blended.items()
    }
    for (name, share), ink in zip(beyond.items(), (*INKS, INK), strict=False):
        for axis in axes[-1]:
            axis.plot(edges, 100 * share, color=ink, linewidth=1.6, label=name)
    axes[-1][0].set(xlabel="variance of at least", ylabel="pixels (%)", xlim=(0, most))
    axes[-1][1].set(
        xlabel="variance of at least (the tail)",
        ylabel="pixels (%)",
        xlim=(most, 4 * most),
        yscale="log",
    )
    axes[-1][0].legend(fontsize=8, frameon=False)
    table += [
        f"{edge:.3f}," + ",".join(f"{share[k]:.6f}" for share in beyond.values())
        for k, edge in enumerate(edges)
    ]
    words = "; ".join(f"{name} {np.mean(v):.0f}" for name, v in blended.items() if len(v))
    caption = (
        "Variance of the intensities that a pixel of the sonar mosaic blends, by what the poses "
        f"are from; means: {words}."
    )
    return finish_figure("sonar_variance", figure, table, caption)
