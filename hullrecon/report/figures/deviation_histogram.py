# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How much of the hull deviates by how much from its CAD model."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.records.solution import Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.content.phrases import signed_range
from hullrecon.report.export.csv_export import numbers
from hullrecon.report.figures.chart_map import weighted_percentiles
from hullrecon.report.figures.style import BLUE, GRAY, GREEN, ORANGE, Plot, new_figure, png_bytes
from hullrecon.typing import Array

NAMES = {
    "landmarks": "landmarks, offset included",
    "as_found": "area seen, offset included",
    "form": "form of the area seen",
}


def deviation_histogram(
    solution: Solution | None, as_found: Surface | None, split: DeviationSplit | None
) -> Plot | None:
    """Draw the share of landmarks, and of the area seen, by signed distance to the CAD model, that
    of its form, and the offset with its sigma; None without a parted deviation.
    """
    if as_found is None or split is None:
        return None
    area = np.where(as_found.support > 0, vertex_areas(as_found.mesh()), 0.0)
    groups = {"as_found": (as_found.deviation, area), "form": (split.form, area)}
    if solution is not None:
        groups = {
            "landmarks": (solution.landmarks.deviation, np.ones(len(solution.landmarks))),
            **groups,
        }
    shares = {n: (v[np.isfinite(v)], w[np.isfinite(v)]) for n, (v, w) in groups.items()}
    shares = {n: (v, w / w.sum()) for n, (v, w) in shares.items() if w.sum() > 0}
    if "form" not in shares:
        return None
    # on the CAD model is the middle of a bin, not a border
    edges = np.asarray(0.004 * (np.arange(-50, 52) - 0.5), float)
    figure, (axis,) = new_figure()
    table = {"from_m": numbers(edges[:-1], ".3f"), "to_m": numbers(edges[1:], ".3f")}
    for (name, (values, weights)), color in zip(
        shares.items(), (BLUE, ORANGE, GREEN), strict=False
    ):
        share = (
            100
            * np.histogram(np.clip(values, edges[0], edges[-1] - 1e-9), edges, weights=weights)[0]
        )
        axis.stairs(share, 1000 * edges, color=color, linewidth=1.6, label=NAMES[name])
        table[f"{name}_percent"] = numbers(np.asarray(share, float), ".6f")
    offset, sigma = 1000 * float(split.offset), 1000 * float(split.offset_sigma)
    axis.errorbar(
        [offset],
        [60],
        xerr=[sigma],
        color=ORANGE,
        marker="o",
        markersize=4,
        capsize=3,
        label="offset, one sigma",
    )
    axis.axvline(0, color=GRAY, linewidth=1)
    axis.set(xlabel="distance to the CAD model, outward positive (mm)", ylabel="share (%)")
    axis.set_yscale("symlog", linthresh=0.1)
    axis.legend(fontsize=8, frameon=False)
    return Plot(
        name="deviation_histogram",
        title="Deviation from the CAD model",
        alt=f"{_form_words(*shares['form'], split)}; offset of the whole patch {offset:+.0f} mm, one sigma {sigma:.0f} mm.",
        png=png_bytes(figure),
        table=table,
    )


def _form_words(form: Array, weight: Array, split: DeviationSplit) -> str:
    low, high = 1000 * weighted_percentiles(form, weight, (5, 95))
    sigma = 1000 * float(np.nanmedian(split.form_sigma))
    return f"Form: 5th to 95th percentile {signed_range(low, high, 1)} mm, median one sigma {sigma:.1f} mm"
