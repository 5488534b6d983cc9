# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where a feature changes from the hull to off the hull [Ozog2016 Fig. 4.4]."""

from __future__ import annotations

import numpy as np

from hullrecon.adjustment.problem.selection import label_boundary
from hullrecon.studies.figure_style import (
    COLOURS,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array

SIGMA_OFF_M, SIGMA_ON_M = 1.0, 0.02  # sigma_0 and sigma_1 of [Ozog2016 Fig. 4.4]


def mixture_cost(distance_m: Array) -> Array:
    """Evaluate -log of the larger of both normal densities at distances (n,) m.

    [Ozog2016 eqs 4.6, 4.7]. Equal weights and what both share are left out.
    """
    return np.asarray(
        np.min(
            [
                0.5 * (distance_m / sigma) ** 2 + np.log(sigma)
                for sigma in (SIGMA_ON_M, SIGMA_OFF_M)
            ],
            axis=0,
        )
    )


def study() -> StudyResult:
    """Draw the cost and its boundary."""
    return StudyResult(figures=(draw(),))


def draw() -> PublishedFigure:
    """Draw the mixture's cost over the signed distance to the hull."""
    boundary = label_boundary(SIGMA_ON_M, SIGMA_OFF_M)
    distance = np.linspace(-0.15, 0.15, 601)
    cost = mixture_cost(distance)
    figure, axes = new_canvas(7.0, 3.4)
    axis = axes[0][0]
    axis.plot(100 * distance, cost, color=INK, linewidth=1.8)
    on = np.abs(distance) <= boundary
    axis.fill_between(
        100 * distance, cost, cost.min(), where=on, color=COLOURS["maxmix"], alpha=0.25,
        label="on the hull (label 1)",
    )  # fmt: skip
    axis.fill_between(
        100 * distance, cost, cost.min(), where=~on, color=RED, alpha=0.15,
        label="off the hull (label 0)",
    )  # fmt: skip
    axis.set(xlabel="signed distance to the hull (cm)", ylabel="cost (-log density)")
    axis.legend(fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0.0, 0.05))
    return finish_figure(
        "label_boundary",
        figure,
        [
            "distance_m,cost,label",
            *(f"{d:.4f},{c:.6f},{o:d}" for d, c, o in zip(distance, cost, on, strict=True)),
        ],
        f"With sigmas of {SIGMA_OFF_M:g} and {SIGMA_ON_M:g} m a feature is off the hull beyond "
        f"{100 * boundary:.2f} cm.",
        (
            ComparedValue(
                what="boundary between the labels, sigmas 1 m and 0.02 m",
                unit="cm",
                ours=100 * boundary,
                note="printed as a picture alone",
            ),
        ),
    )
