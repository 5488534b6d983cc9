# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How a landmark by inverse depth finds its depth [Aulinas2011 5.3.2, Civera2008]."""

from __future__ import annotations

import numpy as np

from hullrecon.studies.figure_style import (
    COLOURS,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.studies.vehicles.convergence import STEP_SHARE, STEPS, Trials, converge
from hullrecon.studies.vehicles.inverse_depth import PUBLISHED_RHO

SEED, TRIALS = 0, 300
STANDOFF_RHO = 1 / 1.5  # 1/m, at the usual distance from a hull


def study_convergence() -> StudyResult:
    """Start landmarks from the thesis' inverse depth and from a hull's, and follow them."""
    both = {rho: converge(SEED, TRIALS, rho) for rho in (STANDOFF_RHO, PUBLISHED_RHO)}
    rows = tuple(
        (
            f"{rho:.2f}",
            f"{100 * first_inside(trials):.1f}",
            f"{100 * trials.converged.mean():.1f}",
            f"{100 * float(np.median(trials.sigma[:, -1] / trials.truth)):.2f}",
        )
        for rho, trials in both.items()
    )
    return StudyResult(
        figures=(_draw(both),),
        heads=(
            "start, 1/m",
            f"inside 3 sigma after one step of {STEP_SHARE:g} of the depth, %",
            f"converged after {STEPS} steps, %",
            "sigma of the depth then, %",
        ),
        rows=rows,
        compared=tuple(
            ComparedValue(
                what=f"landmarks that converge from {rho:.2f} 1/m",
                unit="%",
                ours=100 * float(trials.converged.mean()),
                note=f"depths of 0.75 to 3 m, steps of {STEP_SHARE:g} of the depth"
                + ("; the thesis takes 0.1 as appropriate" if rho == PUBLISHED_RHO else ""),
            )
            for rho, trials in both.items()
        ),
    )


def first_inside(trials: Trials) -> float:
    """Compute the share of landmarks within 3 sigma after the first step."""
    return float((np.abs(trials.rho[:, 1] - trials.truth) < 3 * trials.sigma[:, 1]).mean())


def _draw(both: dict[float, Trials]) -> PublishedFigure:
    """Draw the relative error of the inverse depth and its sigma over frames.

    both: trials by the inverse depth from which they start, 1/m.
    """
    canvas, axes = new_canvas(9.0, 3.6, 1, len(both), sharey="all")
    table = ["start,frame,error_95,sigma"]
    frames = np.arange(STEPS + 1)
    for axis, (rho, trials) in zip(axes[0], both.items(), strict=True):
        off = np.abs(trials.rho - trials.truth[:, None]) / trials.truth[:, None]
        error = np.quantile(off, 0.95, axis=0)
        sigma = np.median(trials.sigma / trials.truth[:, None], axis=0)
        axis.semilogy(frames, off[:40].T, color=COLOURS["naive"], lw=0.4, alpha=0.6)
        axis.semilogy(frames, error, color=COLOURS["maxmix"], label="error of 95 %")
        axis.semilogy(frames, 2 * sigma, color=RED, ls=":", label="2 sigma")
        axis.set_ylim(1e-4, 10)
        axis.set_title(f"from {rho:.2f} 1/m", fontsize=9, loc="left")
        axis.set_xlabel(f"frame, each {STEP_SHARE:g} of the depth further")
        axis.legend(fontsize=8, frameon=False)
        for k in frames:
            table.append(f"{rho:.4f},{k},{error[k]:.5f},{sigma[k]:.5f}")
    axes[0][0].set_ylabel("error of the inverse depth, share")
    return finish_figure(
        "inverse-depth",
        canvas,
        table,
        "Landmarks started at a wrong inverse depth and seen in passing (some grey), the error "
        "that 95 % keep, and what the filter believes.",
    )
