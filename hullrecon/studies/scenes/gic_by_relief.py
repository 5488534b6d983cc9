# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The relief from which an essential matrix explains two views better than a homography.

[KimEustice2009 Fig. 2].
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    PublishedFigure,
    finish_figure,
    label_log_axis,
    new_canvas,
)
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class CriterionTrials:
    """The geometric information criterion of both models."""

    peak_m: Array  # (h,) height of the highest peak over the plane, rising
    homography: Array  # (h, t) by height and trial
    essential: Array  # (h, t)

    def share_of_homography(self) -> Array:
        """Compute the share (h,) of the trials that choose the homography."""
        return np.asarray(np.mean(self.homography < self.essential, axis=1))

    def crossing_m(self) -> float | None:
        """Interpolate the first height where the mean criteria are equal. None without one."""
        ahead = self.homography.mean(axis=1) - self.essential.mean(axis=1)
        changes = np.flatnonzero((ahead[:-1] < 0) & (ahead[1:] >= 0))
        if len(changes) == 0:
            return None
        k = changes[0]
        return float(np.interp(0.0, ahead[k : k + 2], self.peak_m[k : k + 2]))


def gic_by_relief(scorings: Mapping[str, CriterionTrials]) -> PublishedFigure:
    """Draw [KimEustice2009 Fig. 2]: both models' criterion against relief."""
    figure, axes = new_canvas(4.2 * (len(scorings) + 1), 3.8, 1, len(scorings) + 1)
    *panels, shares = axes[0]
    table = [
        "scoring,peak_m,trials,homography_mean,homography_sigma,essential_mean,essential_sigma,share_homography"
    ]
    for axis, (name, trials), colour_of in zip(
        panels, scorings.items(), (INK, GREEN)[: len(scorings)], strict=True
    ):
        peak_mm, share, crossing = (
            1e3 * trials.peak_m,
            trials.share_of_homography(),
            trials.crossing_m(),
        )
        _draw_criteria(axis, trials)
        axis.set_title(name, fontsize=9)
        shares.plot(
            peak_mm,
            100 * share,
            color=colour_of,
            marker="o",
            markersize=4.5,
            linewidth=1.6,
            label=name,
        )
        if crossing is not None:
            axis.axvline(
                1e3 * crossing,
                color=INK,
                linestyle="--",
                linewidth=1.0,
                label=f"equal at {1e3 * crossing:.0f} mm",
            )
        axis.legend(fontsize=8, frameon=False, loc="upper left")
        for k, height in enumerate(trials.peak_m):
            row = [
                v
                for scores in (trials.homography, trials.essential)
                for v in (scores[k].mean(), scores[k].std())
            ]
            numbers = ",".join(f"{v:.3f}" for v in row)
            table.append(
                f"{name},{height:.3f},{trials.homography.shape[1]},{numbers},{share[k]:.3f}"
            )
    for axis in axes[0]:
        _label_relief(axis, 1e3 * next(iter(scorings.values())).peak_m)
    panels[0].set_ylabel("geometric information criterion\n(mean and one sigma of the trials)")
    shares.set(ylabel="trials that choose the homography (%)", ylim=(-4, 104), title=" ")
    shares.legend(fontsize=8, frameon=False, loc="lower left")
    words = "; ".join(_words(name, trials) for name, trials in scorings.items())
    return finish_figure(
        "gic_by_relief", figure, table, f"Homography or essential matrix by relief. {words}."
    )


def _draw_criteria(axis: Axes, trials: CriterionTrials) -> None:
    """Draw both models' criterion, on a logarithmic axis where it grows severalfold."""
    peak_mm = 1e3 * trials.peak_m
    for scores, label, method, marker in (
        (trials.homography, "homography", "geva", "o"),
        (trials.essential, "essential matrix", "maxmix", "s"),
    ):
        mean, spread = scores.mean(axis=1), scores.std(axis=1)
        axis.fill_between(
            peak_mm, mean - spread, mean + spread, color=COLOURS[method], alpha=0.16, linewidth=0
        )
        axis.plot(
            peak_mm,
            mean,
            color=COLOURS[method],
            marker=marker,
            markersize=4.5,
            linewidth=1.6,
            label=label,
        )
    if trials.homography.mean(axis=1).max() > 3 * trials.essential.mean():
        axis.set_yscale("log")
        label_log_axis(axis.yaxis)


def _label_relief(axis: Axes, peak_mm: Array) -> None:
    """Label the axis by heights (h,) mm, logarithmic above the lowest that is not zero."""
    from matplotlib.ticker import NullLocator

    lowest = float(peak_mm[peak_mm > 0].min())
    axis.set_xscale("symlog", linthresh=lowest, linscale=0.5)
    axis.set_xlim(-0.3 * lowest, 1.25 * peak_mm.max())
    axis.set_xticks(peak_mm, [f"{height:.0f}" for height in peak_mm])
    axis.xaxis.set_minor_locator(NullLocator())
    axis.set_xlabel("height of the highest peak over the plane (mm)")


def _words(name: str, trials: CriterionTrials) -> str:
    """Say where the criteria are equal and how often the homography is chosen at either end."""
    crossing, share = trials.crossing_m(), trials.share_of_homography()
    where = "nowhere equal" if crossing is None else f"equal at {1e3 * crossing:.0f} mm"
    ends = [
        f"{100 * share[k]:.0f} % of the trials at {1e3 * trials.peak_m[k]:.0f} mm" for k in (0, -1)
    ]
    return f"{name}: mean criteria {where}, the homography chosen in {ends[0]} and in {ends[1]}"
