# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of the 441 landmarks [Aulinas2011 Figs 3.4, 3.5, 3.6]."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    LIGHT,
    RED,
    PublishedFigure,
    finish_figure,
    label_log_axis,
    new_canvas,
)
from hullrecon.studies.study import StudyResult
from hullrecon.studies.submaps.ekf_slam import Limits
from hullrecon.studies.submaps.end_errors import compare_ends, mean_band
from hullrecon.studies.submaps.repeated import (
    FIRST,
    Repeated,
    compare_repeated,
    repeat_world,
)
from hullrecon.studies.submaps.selective import Fusion, SelectiveJoining
from hullrecon.studies.submaps.world_study import (
    EKF,
    HEADS,
    SEEDS,
    SELECTIVE,
    Mission,
    compare,
    run_missions,
    simulate_world,
    table,
)
from hullrecon.studies.submaps.worlds import World, dead_reckon
from hullrecon.typing import Array

SMALL = 40  # landmarks of a fused map that a figure shows
METHOD_COLOURS = {
    EKF: INK,
    "LMJ": COLOURS["naive"],
    "DCS": COLOURS["geva"],
    "HS": GREEN,
    "CIS": RED,
    SELECTIVE: COLOURS["maxmix"],
}


def draw_world(world: World, mission: Mission) -> PublishedFigure:
    """Draw the true track, dead reckoning, and the selective map [Aulinas2011 Fig. 3.4]."""
    canvas, rows = new_canvas(11.0, 3.9, 1, 3, sharey="all")
    truth, reckoned = world.track[:, :2], dead_reckon(world.log)[:, :2]
    _world(rows[0][0], world, truth, "a) truth")
    _world(rows[0][1], world, reckoned, "b) dead reckoning")
    axis = rows[0][2]
    _world(axis, world, mission.track.poses[:, :2], "c) selective submap joining")
    places = np.array([place for _, place in mission.places])
    axis.plot(*places.T, ".", color=COLOURS["maxmix"], ms=3, label="landmark as mapped")
    axis.legend(frameon=False, fontsize=7, loc="lower left", bbox_to_anchor=(0, -0.02))
    steps = mission.track.steps.astype(int)
    lines = ["step,true_x_m,true_y_m,reckoned_x_m,reckoned_y_m,selective_x_m,selective_y_m"]
    for step, pose in zip(steps, mission.track.poses, strict=True):
        row = [*truth[step + 1], *reckoned[step + 1], *pose[:2]]
        lines.append(",".join([str(step), *(f"{value:.3f}" for value in row)]))
    return finish_figure(
        "submap-world",
        canvas,
        lines,
        "A survey of 441 landmarks: true track, dead reckoning, selective submap joining.",
    )


def _world(axis: Axes, world: World, path: Array, title: str) -> None:
    """Draw true landmarks and a path (n, 2) m."""
    axis.plot(*world.landmarks.T, ".", color=LIGHT, ms=3)
    axis.plot(*path.T, color=INK, lw=0.8)
    axis.set_aspect("equal")
    axis.set_title(title, fontsize=9, color=INK, loc="left")
    axis.set(xlabel="x (m)", ylabel="y (m)")


def draw_fusion(mission: Mission) -> PublishedFigure:
    """Draw two submaps before and after their fusion [Aulinas2011 Fig. 3.5]."""
    if not isinstance(mission.strategy, SelectiveJoining):
        raise TypeError("only selective joining tells its fusions")
    small = [f for f in mission.strategy.fusions if len(f.fused_points) <= SMALL]
    fusion = max(small, key=lambda fusion: fusion.moved_m)
    canvas, rows = new_canvas(8.0, 4.0, 1, 2, sharex="all", sharey="all")
    lines = ["panel,map,x_m,y_m"]
    old, new, fused = fusion.old_points, fusion.new_points, fusion.fused_points
    for axis, title, sets in (
        (rows[0][0], "before", (("old", old), ("new", new))),
        (rows[0][1], "after", (("fused", fused),)),
    ):
        for name, points in sets:
            marker, colour = _MARKS[name]
            axis.plot(*points.T, marker, color=colour, ms=6, mfc="none", label=f"{name} map")
            lines += [f"{title},{name},{x:.3f},{y:.3f}" for x, y in points]
        axis.set_aspect("equal")
        axis.set_title(title, fontsize=9, color=INK, loc="left")
        axis.set_xlabel("x (m)")
        axis.legend(frameon=False, fontsize=8)
    rows[0][0].set_ylabel("y (m)")
    return finish_figure("submap-fusion", canvas, lines, _fusion_caption(fusion))


_MARKS = {"old": ("o", COLOURS["maxmix"]), "new": ("s", COLOURS["geva"]), "fused": ("D", INK)}


def _fusion_caption(fusion: Fusion) -> str:
    """Write the caption of the figure of a fusion."""
    return (
        f"Two submaps with {fusion.shared} landmarks in common, before and after their fusion; "
        f"the new one moves by {fusion.moved_m:.2f} m."
    )


def draw_consistency(repeated: Repeated) -> PublishedFigure:
    """Draw the mean normalised error squared of several missions, with its band [Fig. 3.6]."""
    canvas, rows = new_canvas(8.0, 3.6)
    axis = rows[0][0]
    nees = repeated.nees()
    means = {name: of.mean(axis=0) for name, of in nees.items()}
    runs, scans = nees[EKF].shape
    low, high = mean_band(runs)
    for name, mean in means.items():
        axis.plot(
            range(scans),
            np.maximum(mean, 1e-2),
            color=METHOD_COLOURS[name.removesuffix(f" {FIRST}")],
            lw=0.8 if name.endswith(FIRST) else 1.2,
            ls="--" if name.endswith(FIRST) else "-",
            label=f"{name}: {100 * np.mean(mean < high):.0f} % below",
        )
    axis.axhspan(low, high, color=LIGHT, alpha=0.6, label="95 % of chi-square, 3 degrees")
    axis.set_yscale("log")
    label_log_axis(axis.yaxis)
    axis.set(xlabel="scan", ylabel=f"NEES of the pose, mean of {runs}")
    axis.legend(frameon=False, fontsize=7, ncols=2)
    lines = ["scan," + ",".join(means)]
    for number in range(scans):
        lines.append(",".join([str(number), *(f"{m[number]:.3f}" for m in means.values())]))
    return finish_figure(
        "submap-nees",
        canvas,
        lines,
        f"Normalised estimation error squared of the car's pose, mean of {runs} missions.",
    )


def study_world() -> StudyResult:
    """Run the 441 landmarks by every method, and draw them."""
    world = simulate_world()
    missions = run_missions(world, Limits())
    repeated = repeat_world(SEEDS)
    selective = missions[-1]
    return StudyResult(
        figures=(
            draw_world(world, selective),
            draw_fusion(selective),
            draw_consistency(repeated),
        ),
        values={m.name: m.effort.total_multiplications for m in missions},
        heads=HEADS,
        rows=table(missions, world),
        compared=(
            *compare(missions, world),
            *compare_ends(repeated.ends()),
            *compare_repeated(repeated),
        ),
    )
