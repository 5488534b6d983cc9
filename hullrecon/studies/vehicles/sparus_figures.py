# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of SPARUS' run [Aulinas2011 Figs 5.13, 5.16 to 5.18].

Paths and points are x, y and depth in the world, m.
"""

from __future__ import annotations

import numpy as np

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
from hullrecon.studies.vehicles.sparus import CAMERA, PIXEL_SIGMA, Prediction, Run, Survey
from hullrecon.typing import Array

FRAMES = 5
MARGIN_PX = 45.0  # around the landmarks in a frame


def draw_tracks(survey: Survey, run: Run, reckoned: Array) -> PublishedFigure:
    """Draw the track dead-reckoned, by SLAM and true, in space [Aulinas2011 Figs 5.13, 5.18]."""
    from matplotlib.figure import Figure

    canvas = Figure(figsize=(10.0, 4.4), dpi=150, layout="constrained")
    truth = survey.mission.truth[:, :3]
    points = run.map.points + truth[0]
    for k, (name, path) in enumerate((("dead reckoning", reckoned), ("submaps", run.path))):
        axis = canvas.add_subplot(1, 2, k + 1, projection="3d")
        axis.plot(*truth.T, color=COLOURS["naive"], lw=0.8, label="true")
        axis.plot(*path.T, color=COLOURS["geva"] if k == 0 else COLOURS["maxmix"], lw=1, label=name)
        axis.plot(*truth[-1:].T, "o", color=INK, ms=5, label="true end")
        axis.plot(*path[-1:].T, "o", color=RED, ms=5, label="end as estimated")
        if k:
            axis.plot(*points.T, "+", color=GREEN, ms=3, label="landmarks")
        axis.set_zlim(20.2, 14.5)
        axis.set_box_aspect(None, zoom=0.85)
        axis.set_xlabel("x, m", fontsize=8)
        axis.set_ylabel("y, m", fontsize=8)
        axis.set_zlabel("depth, m", fontsize=8)
        axis.tick_params(labelsize=7)
        axis.legend(fontsize=7, frameon=False, loc="upper left")
    table = ["true_x,true_y,true_z,reckoned_x,reckoned_y,reckoned_z,slam_x,slam_y,slam_z"] + [
        ",".join(f"{value:.3f}" for value in row)
        for row in np.hstack([truth, reckoned, run.path])[::10]
    ]
    return finish_figure(
        "sparus-tracks",
        canvas,
        table,
        "SPARUS' simulated mission: dead reckoning drifts in depth too, as no pressure is used; "
        "submaps bring its end back.",
    )


def draw_frames(run: Run) -> PublishedFigure:
    """Draw landmarks predicted and observed in successive frames [Aulinas2011 Fig. 5.16]."""
    first, frames = _five_frames(run.predictions)
    canvas, axes = new_canvas(10.0, 2.4, 1, FRAMES, sharey="all")
    places = np.array([p.expected for _, seen in frames for p in seen])
    low, high = places.min(axis=0) - MARGIN_PX, places.max(axis=0) + MARGIN_PX
    low, high = np.maximum(low, 0), np.minimum(high, CAMERA.size_px)
    table = ["frame,label,again,expected_u,expected_v,seen_u,seen_v,area_px2"]
    for axis, (step, seen) in zip(axes[0], frames, strict=True):
        for prediction in seen:
            draw_ellipse(axis, prediction.expected, prediction.spread, 3, RED)
            draw_ellipse(axis, prediction.seen, PIXEL_SIGMA**2 * np.eye(2), 3, "#d8a200")
            axis.plot(*prediction.expected, "+", color=RED, ms=7)
            axis.plot(*prediction.seen, "x", color="#d8a200", ms=6)
            area = 9 * np.pi * np.sqrt(np.linalg.det(prediction.spread))
            numbers = [*prediction.expected, *prediction.seen, area]
            table.append(
                f"{step},{prediction.label},{prediction.again},"
                + ",".join(f"{value:.2f}" for value in numbers)
            )
        axis.set(xlim=(low[0], high[0]), ylim=(high[1], low[1]), aspect="equal")
        axis.set_title(f"frame {step - first + 1}", fontsize=9, loc="left")
        axis.set_xlabel("u, px")
    axes[0][0].set_ylabel("v, px")
    return finish_figure(
        "sparus-frames",
        canvas,
        table,
        "A part of five successive frames: landmarks as predicted (red +) and observed (yellow x), "
        "each with 3 sigma. What is seen again is predicted ever better.",
    )


def _five_frames(
    predictions: list[Prediction],
) -> tuple[int, list[tuple[int, list[Prediction]]]]:
    """Find five successive frames that begin with the first prediction of a lone landmark.

    A second landmark has joined it by the last of them. Returns the first frame's step, and the
    predictions of each frame with its step.
    """
    by_step: dict[int, list[Prediction]] = {}
    for prediction in predictions:
        by_step.setdefault(prediction.step, []).append(prediction)
    for first, seen in sorted(by_step.items()):
        steps = range(first, first + FRAMES)
        starts = len(seen) == 1 and seen[0].again == 1
        counts = [len(by_step.get(step, [])) for step in steps]
        if starts and counts[-1] == 2 and min(counts) >= 1:
            return first, [(step, by_step[step]) for step in steps]
    raise AssertionError("no five frames show a landmark and then two")


def draw_map(survey: Survey, run: Run) -> PublishedFigure:
    """Draw map and track from above and from the front [Aulinas2011 Fig. 5.17]."""
    canvas, axes = new_canvas(10.0, 7.0, 2, 2, height_ratios=(3.0, 1.0))
    points = run.map.points + survey.mission.truth[0, :3]  # the map's origin is the start
    for column in range(2):
        for row, (i, j) in enumerate(((0, 1), (0, 2))):
            axis = axes[row][column]
            axis.scatter(run.path[:, i], run.path[:, j], c=run.submap % 10, cmap="tab10", s=0.6)
            axis.plot(points[:, i], points[:, j], "+", color=RED, ms=4)
            if column == 0:
                for k, point in enumerate(points):
                    covariance = run.map.point_covariance(k)[np.ix_([i, j], [i, j])]
                    draw_ellipse(axis, point[[i, j]], covariance, 3, RED)
            axis.set_xlabel("x, m")
        axes[0][column].plot(*survey.points[:, :2].T, ".", color=INK, ms=2)
        axes[0][column].set_aspect("equal")
        axes[1][column].invert_yaxis()
        axes[0][column].set_ylabel("y, m")
        axes[1][column].set_ylabel("depth, m")
    table = ["label,x_m,y_m,depth_m,true_x_m,true_y_m,true_depth_m"] + [
        f"{label}," + ",".join(f"{value:.3f}" for value in np.r_[point, survey.points[label]])
        for label, point in zip(run.map.labels, points, strict=True)
    ]
    return finish_figure(
        "sparus-map",
        canvas,
        table,
        "Track in submaps' colours and landmarks (red), from above with the true points (black) "
        "and from the front, left with ellipses of 3 sigma.",
    )
