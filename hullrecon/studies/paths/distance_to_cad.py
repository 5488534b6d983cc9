# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Distances of DVL returns from the CAD model on different paths [Ozog2016 Figs 2.22, 2.23]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hullrecon.studies.figure_style import (
    COLOURS,
    INK,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.typing import Array

MOST_DRAWN = 4000


@dataclass(frozen=True, kw_only=True)
class ReturnsOnHull:
    """DVL returns on one path, registered to the CAD model."""

    points: Array  # (n, 3) m in M
    distance: Array  # (n,) m from its surface


def distance_to_cad_model(paths: Mapping[str, ReturnsOnHull]) -> PublishedFigure:
    """Draw the returns from above, a panel a path, and their distances' spread."""
    figure, axes = new_canvas(4.2 * (len(paths) + 1), 3.6, 1, len(paths) + 1)
    palette = dict(zip(paths, (COLOURS["geva"], COLOURS["maxmix"], INK), strict=False))
    reach = max(float(np.percentile(np.abs(found.distance), 99)) for found in paths.values())
    edges = np.linspace(0, max(reach, 1e-3), 61)
    table, words = ["path,returns,mean_m,sigma_m,median_m,share_beyond_0.1_m"], []
    for axis, (name, found) in zip(axes[0], paths.items(), strict=False):
        few = slice(None, None, max(1, len(found.points) // MOST_DRAWN))
        axis.scatter(
            found.points[few, 0], found.points[few, 1], s=2, color=palette[name], linewidths=0
        )
        axis.set(title=name, xlabel="along the hull (m)", ylabel="across it (m)")
        away = np.abs(found.distance)
        share = 100 * np.histogram(away, edges)[0] / max(1, len(away))
        axes[0][-1].stairs(share, 1e3 * edges, color=palette[name], linewidth=1.8, label=name)
        beyond = float(np.mean(away > 0.1))
        table.append(
            f"{name},{len(away)},{np.mean(away):.5f},{np.std(away):.5f},{np.median(away):.5f},{beyond:.5f}"
        )
        words.append(
            f"{name} {1e3 * np.mean(away):.0f} mm in the mean, {100 * beyond:.0f} % beyond 0.1 m"
        )
    axes[0][-1].set(xlabel="distance of a DVL return from the CAD model (mm)", ylabel="returns (%)")
    axes[0][-1].legend(fontsize=8, frameon=False)
    return finish_figure(
        "distance_to_cad_model",
        figure,
        table,
        f"DVL returns laid onto the CAD model: {'; '.join(words)}.",
    )
