# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The surface of [KimEustice2009 Fig. 2(a)] in its two views, and which model is chosen for it.

The geometric information criterion (GIC) chooses between a homography, which holds for a plane, and
an essential matrix, which holds for any scene: the model whose criterion is smaller.
"""

from __future__ import annotations

import numpy as np

from hullrecon.studies.figure_style import COLOURS, RED, PublishedFigure, finish_figure, new_canvas
from hullrecon.studies.scenes import scene_figures as scenes
from hullrecon.studies.scenes.gic_by_relief import CriterionTrials
from hullrecon.studies.study import ComparedValue, StudyResult

DRAWN_PEAK_M = 0.2
GRID = 45  # points of the surface along either side


def study() -> StudyResult:
    """Draw the surface in both views, and compare the relief at which the choice changes."""
    return StudyResult(
        figures=(relief_views(),),
        compared=tuple(
            value
            for name, trials in scenes.criterion_trials().items()
            for value in _compare_choice(name, trials)
        ),
    )


def _compare_choice(name: str, trials: CriterionTrials) -> list[ComparedValue]:
    """Compare the relief at which both models' criteria are equal, and the choice on a plane.

    name: of how the trials score the models.
    """
    share, crossing = trials.share_of_homography(), trials.crossing_m()
    return [
        ComparedValue(
            what=f"relief at which the criteria are equal, {name}",
            unit="mm",
            ours=None if crossing is None else 1e3 * crossing,
            note="drawn as one crossing; the relief's unit is not printed",
        ),
        ComparedValue(
            what=f"homography chosen on the plane, {name}",
            unit="%",
            ours=100 * float(share[0]),
            note="the homography's criterion is the smaller one on a plane",
        ),
        ComparedValue(
            what=f"spread of the essential matrix' criterion, {name}",
            unit="%",
            ours=100 * float(np.ptp(trials.essential.mean(axis=1)) / trials.essential.mean()),
            note="drawn flat",
        ),
    ]


def relief_views() -> PublishedFigure:
    """Draw the surface's points, and the matches sampled from it, in both views."""
    figure, axes = new_canvas(9.6, 3.9, 1, 2, sharey="all")
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, GRID), np.linspace(-0.5, 0.5, GRID))
    across = scenes.PEAKS_SIZE_M * np.column_stack([x.ravel(), y.ravel()])
    height = DRAWN_PEAK_M * scenes.peaks(*(6 * across / scenes.PEAKS_SIZE_M).T)
    middle = np.array([0.5 * scenes.BASELINE_M, 0.0])
    surface = np.column_stack([across + middle, scenes.DISTANCE_M - height])
    matches = scenes.views_of_peaks(np.random.default_rng(0), DRAWN_PEAK_M)
    table = ["view,kind,u,v"]
    for k, (axis, name, seen, points) in enumerate(
        zip(
            axes[0],
            ("first view", "second view"),
            matches,
            (surface, scenes.SECOND_FROM_FIRST.apply(surface)),
            strict=True,
        )
    ):
        structure, sampled = scenes.CAMERA.project(points), scenes.CAMERA.distort(seen)
        axis.plot(*structure.T, ".", color=COLOURS["maxmix"], markersize=1.6, label="surface")
        axis.plot(*sampled.T, ".", color=RED, markersize=4.5, label="matches")
        axis.set(xlim=(0, scenes.CAMERA.width), ylim=(scenes.CAMERA.height, 0), title=name)
        axis.set(xlabel="u (px)", ylabel="v (px)" if k == 0 else "", aspect="equal")
        axis.legend(fontsize=8, loc="lower right")
        table += [f"{k + 1},surface,{u:.2f},{v:.2f}" for u, v in structure]
        table += [f"{k + 1},match,{u:.2f},{v:.2f}" for u, v in sampled]
    caption = (
        f"The surface of the trials with peaks of {1e3 * DRAWN_PEAK_M:.0f} mm, "
        f"{scenes.DISTANCE_M:g} m ahead of two views {scenes.BASELINE_M:g} m apart: its points, "
        "and the matches that both models are fitted to."
    )
    return finish_figure("relief_views", figure, table, caption)
