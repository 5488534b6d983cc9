# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of REMUS' run [Aulinas2011 Figs 5.5 to 5.7]."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    RED,
    PublishedFigure,
    draw_ellipse,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.targets.detector_trials import try_thresholds
from hullrecon.studies.vehicles.remus import Run, Survey, discrepancy
from hullrecon.typing import Array

PIECES = ((4000, 4050), (9000, 9050), (15000, 15050))  # steps


def draw_run(survey: Survey, run: Run) -> PublishedFigure:
    """Draw sonar image, map from above, depth over time and side view [Aulinas2011 Fig. 5.5]."""
    canvas, axes = new_canvas(10.0, 7.6, 2, 2)
    (sonar, above), (time, side) = axes
    seen = try_thresholds(5, 1)
    sonar.imshow(seen.tile, cmap="gray", vmin=0, vmax=200, aspect="auto")
    sonar.plot(seen.detection.column, seen.detection.row, "s", mec=GREEN, mfc="none", ms=12)
    sonar.set_title("side-scan image with detections", fontsize=9, loc="left")
    sonar.grid(visible=False)
    sonar.set(xticks=[], yticks=[])
    _from_above(above, survey, run)
    hours = survey.mission.time_s / 3600
    time.plot(hours, run.path[:, 2], color=COLOURS["maxmix"], lw=1, label="vehicle")
    time.plot(hours, survey.mission.floor_m, color=INK, lw=1, label="floor")
    time.invert_yaxis()
    time.set(xlabel="time, h", ylabel="depth, m")
    time.legend(fontsize=8, frameon=False)
    side.scatter(run.path[:, 0], run.path[:, 2], c=run.submap % 10, cmap="tab10", s=1)
    points = run.map.points
    side.plot(points[:, 0] + survey.mission.truth[0, 0], points[:, 2], "+", color=RED, ms=5)
    side.invert_yaxis()
    side.set(xlabel="x, m", ylabel="depth, m")
    side.set_title("from the side", fontsize=9, loc="left")
    table = ["x_m,y_m,depth_m"] + [f"{x:.3f},{y:.3f},{z:.3f}" for x, y, z in points]
    return finish_figure(
        "remus-run",
        canvas,
        table,
        f"REMUS' simulated mission: {len(run.map.starts) - 1} submaps in colours, landmarks with "
        "ellipses of 3 sigma, and depth, with the surfacing in between.",
    )


def _from_above(axis: Axes, survey: Survey, run: Run) -> None:
    """Draw track by submap, landmarks and their ellipses."""
    shift = survey.mission.truth[0, :2]
    axis.scatter(run.path[:, 0], run.path[:, 1], c=run.submap % 10, cmap="tab10", s=0.4)
    for k, point in enumerate(run.map.points):
        draw_ellipse(axis, point[:2] + shift, run.map.point_covariance(k)[:2, :2], 3, RED, 0.8)
    axis.plot(*survey.targets[:, :2].T, "+", color=INK, ms=4)
    axis.set(xlabel="x, m", ylabel="y, m", aspect="equal")
    axis.set_title("from above, targets black", fontsize=9, loc="left")


def draw_pieces(survey: Survey, run: Run, reckoned: Array) -> PublishedFigure:
    """Draw short pieces of track by LBL, dead reckoning and SLAM [Aulinas2011 Fig. 5.6].

    reckoned: (n, 3) m, the positions that dead reckoning gives.
    """
    canvas, axes = new_canvas(10.0, 3.6, 1, len(PIECES))
    table = ["step,lbl_x,lbl_y,reckoned_x,reckoned_y,slam_x,slam_y"]
    for axis, (first, last) in zip(axes[0], PIECES, strict=True):
        last = min(last, len(run.path))
        fixes = (survey.lbl_step >= first) & (survey.lbl_step < last)
        axis.plot(*survey.lbl[fixes].T, ".", color=COLOURS["naive"], ms=4, label="LBL")
        part = slice(first, last)
        axis.plot(*reckoned[part, :2].T, color=COLOURS["geva"], lw=1.2, label="dead reckoning")
        axis.plot(*run.path[part, :2].T, color=COLOURS["maxmix"], lw=1.2, label="submaps")
        axis.set(xlabel="x, m", aspect="equal", adjustable="datalim")
        for step, fix in zip(survey.lbl_step[fixes], survey.lbl[fixes], strict=True):
            row = np.r_[fix, reckoned[step, :2], run.path[step, :2]]
            table.append(f"{step}," + ",".join(f"{value:.3f}" for value in row))
    axes[0][0].set_ylabel("y, m")
    axes[0][0].legend(fontsize=7, frameon=False)
    return finish_figure(
        "remus-pieces",
        canvas,
        table,
        "Pieces of REMUS' track early, in the middle and late: LBL, dead reckoning, and SLAM by "
        "submaps.",
    )


def draw_discrepancy(survey: Survey, runs: Mapping[str, Run]) -> PublishedFigure:
    """Draw LBL less SLAM over time with its bound [Aulinas2011 Fig. 5.7]."""
    canvas, axes = new_canvas(10.0, 5.2, 2, len(runs), sharex="all", sharey="all")
    hours = survey.lbl_step * survey.mission.step_s / 3600
    columns, heads = [hours], ["hours"]
    for column, (name, run) in enumerate(runs.items()):
        off, bound = discrepancy(survey, run)
        for row, what in enumerate(("x", "y")):
            axis = axes[row][column]
            axis.plot(hours, off[:, row], color=COLOURS["maxmix"], lw=0.5)
            for sign, label in ((-1, "3 sigma"), (1, None)):
                axis.plot(hours, sign * bound[:, row], color=RED, lw=1, ls=":", label=label)
            columns += [off[:, row], bound[:, row]]
            heads += [f"{name} {what}_m", f"{name} {what} bound_m"]
            if column == 0:
                axis.set_ylabel(f"LBL less SLAM, {what}, m")
        share = (np.abs(off) < bound).all(axis=1).mean()
        axes[0][column].set_title(f"{name}: {100 * share:.1f} % inside", fontsize=9, loc="left")
        axes[1][column].set_xlabel("time, h")
    axes[0][0].legend(fontsize=8, loc="lower left", frameon=False)
    table = [",".join(heads)] + [
        ",".join(f"{value:.4f}" for value in row) for row in np.column_stack(columns)[::5]
    ]
    return finish_figure(
        "remus-discrepancy",
        canvas,
        table,
        "Discrepancy of LBL and SLAM at each fix with its bound of 3 sigma (dotted), LBL's sigma "
        "in it: a consistent run, and one whose noise is stated three times too small.",
    )
