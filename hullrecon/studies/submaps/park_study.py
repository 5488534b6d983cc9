# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The park by submaps: track, innovations, cost over the mission [Aulinas2011 3.4.2]."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.studies.association.point_sets import chi_square
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits, PathPoint
from hullrecon.studies.submaps.missions import (
    Strategy,
    Track,
    build_submaps,
    map_errors,
    run_filter,
    run_strategy,
)
from hullrecon.studies.submaps.models import place
from hullrecon.studies.submaps.park import (
    FILES,
    RecordedPark,
    read_victoria_park,
    simulate_park,
)
from hullrecon.studies.submaps.selective import SelectiveJoining
from hullrecon.studies.submaps.shared import SharedSeparators
from hullrecon.studies.submaps.world_figures import METHOD_COLOURS
from hullrecon.studies.submaps.world_study import EKF, SELECTIVE, SHARED, THRESHOLD, methods
from hullrecon.studies.submaps.worlds import Log, World, dead_reckon
from hullrecon.typing import Array

FOLDER = Path("victoria-park")  # of the public files, where the command is run
SEED = 0
HEADS = ("park", "method", "mean error m", "largest m", "NIS within %", "10^6 multiplications")
PALETTE = (COLOURS["maxmix"], COLOURS["geva"], GREEN, "#8e44ad", "#b8860b", RED)


@dataclass(frozen=True, kw_only=True)
class Drive:
    """A park by one filter and by submaps."""

    log: Log
    submaps: Sequence[EkfMap]
    filtered: EkfMap
    filter_track: Track
    selective: SelectiveJoining
    track: Track  # of selective joining
    costs: dict[str, list[float]]  # multiplications after each submap, by method
    shared_costs: list[tuple[int, float]]  # the same of CIS, by the step
    filter_cost: float


def drive(log: Log) -> Drive:
    """Drive through a park: run one filter, and every strategy on the same submaps."""
    limits, effort = Limits(), Effort()
    submaps = build_submaps(log, limits, Effort())
    selective = SelectiveJoining(THRESHOLD, limits.landmarks, Effort())
    filtered, filter_track = run_filter(log, effort)
    shared = SharedSeparators(limits, Effort())
    shared.run(log)
    return Drive(
        log=log,
        submaps=submaps,
        filtered=filtered,
        filter_track=filter_track,
        selective=selective,
        track=run_strategy(submaps, selective),
        costs={n: _cost(make, submaps) for n, make in methods(limits).items()},
        shared_costs=shared.costs,
        filter_cost=effort.total_multiplications,
    )


def _cost(make: Callable[[Effort], Strategy], submaps: Sequence[EkfMap]) -> list[float]:
    """Hand submaps to a strategy, and count its multiplications after each."""
    effort, costs = Effort(), []
    strategy = make(effort)
    for built in submaps:
        strategy.add(built)
        costs.append(effort.total_multiplications)
    return costs


def study_park() -> StudyResult:
    """Drive through the simulated park, and through Victoria Park where its files are."""
    park = simulate_park(SEED)
    driven = drive(park.world.log)
    rows, compared = _simulated(driven, park.world)
    figures = [
        draw_track(driven, park.world.track[:, :2], "park-track", "a simulated park"),
        draw_innovations(driven),
        draw_costs(driven),
    ]
    if all((FOLDER / name).is_file() for name in FILES):
        recorded = read_victoria_park(FOLDER)
        more, figure = _recorded(recorded)
        rows += more
        figures.append(figure)
    else:
        missing = f"skipped: {', '.join(FILES)} are not in {FOLDER}/"
        rows.append(("Victoria Park", missing, "", "", "", ""))
    return StudyResult(figures=tuple(figures), heads=HEADS, rows=tuple(rows), compared=compared)


def _simulated(
    driven: Drive, world: World
) -> tuple[list[tuple[str, ...]], tuple[ComparedValue, ...]]:
    """Tabulate errors and costs in the simulated park, and compare them with those printed."""
    reckoned = np.linalg.norm((dead_reckon(world.log) - world.track)[:, :2], axis=1)
    paths = {EKF: driven.filtered.path, SELECTIVE: [p for m in driven.submaps for p in m.path]}
    tracks = {EKF: driven.filter_track, SELECTIVE: driven.track}
    work = {EKF: driven.filter_cost, SELECTIVE: driven.costs[SELECTIVE][-1]}
    rows: list[tuple[str, ...]] = [
        ("simulated", "odometry", f"{reckoned.mean():.2f}", f"{reckoned.max():.2f}", "", "")
    ]
    for name, track in tracks.items():
        off = track.distances(world)
        rows.append(
            (
                "simulated",
                name,
                f"{off.mean():.2f}",
                f"{off.max():.2f}",
                f"{100 * within(paths[name]):.0f}",
                f"{work[name] / 1e6:.1f}",
            )
        )
    trees = map_errors(driven.selective.landmarks(), world)
    compared = (
        ComparedValue(
            what="scans of submaps whose NIS is below 95 % of chi-square",
            unit="%",
            printed=100.0,
            ours=100 * within(paths[SELECTIVE]),
            note="printed: constantly within, as a curve. Of true innovations 95 in 100 are",
        ),
        ComparedValue(
            what="the same of one filter",
            unit="%",
            ours=100 * within(paths[EKF]),
            note="printed: outside, as a curve of Victoria Park, ten times as long. Here the "
            "readings are as noisy as the filter believes",
        ),
        ComparedValue(
            what="mean error of a tree's middle in the map",
            unit="m",
            ours=float(np.mean(trees)),
            note="simulated park; the thesis has no truth of its trees",
        ),
    )
    return rows, compared


def within(path: Sequence[PathPoint], confidence: float = 0.95) -> float:
    """Compute the share of scans whose innovation squared is below its bound (3.22)."""
    paired = [point for point in path if point.degrees]
    return float(np.mean([p.nis < chi_square(confidence, p.degrees) for p in paired]))


def _recorded(recorded: RecordedPark) -> tuple[list[tuple[str, ...]], PublishedFigure]:
    """Run Victoria Park, with GPS for the truth after a rigid fit of the tracks."""
    driven = drive(recorded.log)
    steps = driven.track.steps
    path = np.column_stack(
        [np.interp(recorded.gps_step, steps, driven.track.poses[:, axis]) for axis in (0, 1)]
    )
    flat = [np.column_stack([points, np.zeros(len(points))]) for points in (path, recorded.gps)]
    fixes = fit_rigid(flat[1], flat[0]).apply(flat[1])[:, :2]
    off = np.linalg.norm(path - fixes, axis=1)
    inside = within([p for m in driven.submaps for p in m.path])
    row = (
        "Victoria Park",
        SELECTIVE,
        f"{off.mean():.2f}",
        f"{off.max():.2f}",
        f"{100 * inside:.0f}",
        f"{driven.costs[SELECTIVE][-1] / 1e6:.1f}",
    )
    return [row], draw_track(driven, fixes, "victoria-park", "Victoria Park, with GPS in grey")


def draw_track(driven: Drive, truth: Array, name: str, title: str) -> PublishedFigure:
    """Draw track and submaps over the truth (n, 2) m [Aulinas2011 Fig. 3.7]."""
    canvas, rows = new_canvas(6.5, 7.5)
    axis = rows[0][0]
    axis.plot(*truth.T, color="#aab4bf", lw=3, label="truth")
    reckoned = dead_reckon(driven.log)[:, :2]
    axis.plot(*reckoned.T, ":", color=RED, lw=1, label="odometry")
    axis.plot(*driven.track.poses[:, :2].T, color=INK, lw=1, label="as mapped, at the time")
    frames = driven.selective.world.frames()
    table = ["submap,x_m,y_m"]
    for number, submap in enumerate(driven.selective.submaps):
        points = submap.now(driven.selective.world).reshape(-1, 2)
        points = place(frames[submap.base], points)
        axis.plot(*points.T, "o", ms=4, mfc="none", color=PALETTE[number % len(PALETTE)])
        table += [f"{number},{x:.3f},{y:.3f}" for x, y in points]
    axis.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    axis.legend(fontsize=8, loc="upper left", edgecolor="white", framealpha=1.0)
    count = len(driven.selective.submaps)
    caption = f"Track of {title}, and the trees of {count} submaps, each in a colour of its own."
    return finish_figure(name, canvas, table, caption)


def draw_innovations(driven: Drive) -> PublishedFigure:
    """Draw innovations squared by their bound, of submaps and of one filter [Fig. 3.9]."""
    canvas, rows = new_canvas(8.0, 5.0, 2, 1, sharex="all", sharey="all")
    table = ["method,step,nis,bound"]
    paths = {
        "submaps": [point for m in driven.submaps for point in m.path],
        "one filter": driven.filtered.path,
    }
    clock = np.cumsum(driven.log.step_s)
    for axis, (name, path) in zip((rows[0][0], rows[1][0]), paths.items(), strict=True):
        paired = [point for point in path if point.degrees]
        times = [clock[point.step] for point in paired]
        bounds = [chi_square(0.95, point.degrees) for point in paired]
        axis.plot(times, [p.nis for p in paired], color=COLOURS["maxmix"], lw=0.9, label="NIS")
        axis.plot(times, bounds, "--", color=RED, lw=0.9, label="95 % of chi-square")
        axis.set_title(f"{name}: {100 * within(path):.0f} % within", fontsize=9, loc="left")
        axis.set_ylabel("NIS")
        table += [
            f"{name},{p.step},{p.nis:.3f},{bound:.3f}"
            for p, bound in zip(paired, bounds, strict=True)
        ]
    rows[0][0].legend(frameon=False, fontsize=8, ncols=2, loc="upper right")
    rows[1][0].set_xlabel("time (s)")
    caption = "Normalised innovation squared of each scan, with its bound, in the simulated park."
    return finish_figure("park-innovations", canvas, table, caption)


def draw_costs(driven: Drive) -> PublishedFigure:
    """Draw how the cost of joining grows over the mission [Aulinas2011 Fig. 3.10]."""
    canvas, rows = new_canvas(7.0, 3.8)
    axis = rows[0][0]
    clock = np.cumsum(driven.log.step_s)
    times = [clock[m.path[-1].step] for m in driven.submaps]
    for name, cost in driven.costs.items():
        so_far = np.where(np.array(cost) > 0, cost, np.nan) / 1e6
        axis.plot(times, so_far, color=METHOD_COLOURS[name], lw=1.4, label=name)
    steps, shared = np.array(driven.shared_costs).T
    axis.plot(
        clock[steps.astype(int)],
        np.where(shared > 0, shared, np.nan) / 1e6,
        color=METHOD_COLOURS[SHARED],
        lw=1.4,
        label=SHARED,
    )
    axis.set(xlabel="time (s)", ylabel="10^6 multiplications, so far", yscale="log")
    axis.legend(frameon=False, fontsize=8)
    table = [f"time_s,{','.join(driven.costs)}"]
    for number, time in enumerate(times):
        values = ",".join(f"{cost[number]:.0f}" for cost in driven.costs.values())
        table.append(f"{time:.1f},{values}")
    table += ["", f"step,{SHARED}", *(f"{s:.0f},{c:.0f}" for s, c in driven.shared_costs)]
    caption = "Cost of joining the park's submaps over the mission, by method."
    return finish_figure("park-costs", canvas, table, caption)
