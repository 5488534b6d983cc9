# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How much two submaps must share to be fused: cost and error [Aulinas2011 Fig. 3.2]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.figure_style import (
    COLOURS,
    INK,
    LIGHT,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits
from hullrecon.studies.submaps.missions import build_submaps, run_strategy
from hullrecon.studies.submaps.selective import SelectiveJoining
from hullrecon.studies.submaps.worlds import Noise, Survey, World, simulate_survey

THRESHOLDS = (0.15, 0.3, 0.4, 0.5, 0.6, 0.75, 0.9)
FIELD = Survey(cells=12, leg_m=54.0, legs=6)
SEEDS = (0, 1, 2)
HEADS = ("threshold", "10^6 multiplications", "s", "fusions", "maps left", "place mean m")


@dataclass(frozen=True, kw_only=True)
class Trial:
    """Missions at one threshold, averaged."""

    threshold: float
    multiplications: float  # of all stages
    seconds: float
    fusions: float  # number of pairs of submaps that were fused
    maps: float  # number of submaps that were left
    error_m: float  # mean of the car's position


def sweep(
    missions: list[tuple[World, list[EkfMap]]], thresholds: tuple[float, ...], size: int
) -> list[Trial]:
    """Run selective joining on the same submaps with every threshold."""
    return [_try(missions, threshold, size) for threshold in thresholds]


def _try(missions: list[tuple[World, list[EkfMap]]], threshold: float, size: int) -> Trial:
    """Join the submaps of all missions at a threshold, and average cost and error."""
    numbers = []
    for world, submaps in missions:
        effort = Effort()
        selective = SelectiveJoining(threshold, size, effort)
        track = run_strategy(submaps, selective)
        numbers.append(
            (
                effort.total_multiplications,
                effort.total_seconds,
                len(selective.fusions),
                len(selective.submaps),
                track.distances(world).mean(),
            )
        )
    work, seconds, fusions, maps, error = np.mean(numbers, axis=0)
    return Trial(
        threshold=threshold,
        multiplications=float(work),
        seconds=float(seconds),
        fusions=float(fusions),
        maps=float(maps),
        error_m=float(error),
    )


def knee(trials: list[Trial]) -> float:
    """Find the threshold where the cost curve bends most.

    It is the point farthest below the line between the ends of the curve, both axes scaled to one.
    """
    x = np.array([trial.threshold for trial in trials])
    y = np.array([trial.multiplications for trial in trials])
    x = (x - x[0]) / (x[-1] - x[0])
    y = (y - y.min()) / (y.max() - y.min())
    return trials[int(np.argmin(y - (y[0] + x * (y[-1] - y[0]))))].threshold


def study_threshold() -> StudyResult:
    """Sweep the threshold on surveys of 169 landmarks."""
    limits, missions = Limits(), []
    for seed in SEEDS:
        world = simulate_survey(FIELD, Noise(), seed)
        missions.append((world, build_submaps(world.log, limits, Effort())))
    trials = sweep(missions, THRESHOLDS, limits.landmarks)
    least = min(trials, key=lambda trial: trial.multiplications)
    rows = tuple(
        (
            f"{t.threshold:.2f}",
            f"{t.multiplications / 1e6:.1f}",
            f"{t.seconds:.2f}",
            f"{t.fusions:.1f}",
            f"{t.maps:.1f}",
            f"{t.error_m:.2f}",
        )
        for t in trials
    )
    return StudyResult(
        figures=(_draw(trials),),
        values={f"{trial.threshold:.2f}": trial.multiplications for trial in trials},
        heads=HEADS,
        rows=rows,
        compared=(
            ComparedValue(
                what="threshold of the least cost",
                printed=0.45,
                ours=least.threshold,
                note="printed: 0.40 to 0.50, in seconds. Above it hardly any two maps are fused, "
                "the cost stays, and the car is known less well",
            ),
            ComparedValue(
                what="threshold where cost stops falling fast",
                printed=0.45,
                ours=knee(trials),
                note="the knee of our curve; beyond it less is fused and the error grows",
            ),
        ),
    )


def _draw(trials: list[Trial]) -> PublishedFigure:
    """Draw multiplications and error by threshold."""
    canvas, rows = new_canvas(7.0, 4.6, 2, 1, sharex="all")
    x = [trial.threshold for trial in trials]
    for axis in (rows[0][0], rows[1][0]):
        axis.axvspan(0.4, 0.5, color=LIGHT, alpha=0.6, label="least, as printed")
    work = [trial.multiplications / 1e6 for trial in trials]
    rows[0][0].plot(x, work, "o-", color=COLOURS["maxmix"], ms=4, label="multiplications")
    rows[0][0].set(ylabel="10^6 multiplications", ylim=(0, None))
    rows[0][0].legend(frameon=False, fontsize=8)
    errors = [trial.error_m for trial in trials]
    rows[1][0].plot(x, errors, "o-", color=INK, ms=4)
    rows[1][0].set(
        xlabel="threshold (share of a submap's landmarks)",
        ylabel="mean error of the car (m)",
        ylim=(0, None),
    )
    table = [
        "threshold,multiplications,error_m",
        *(f"{t.threshold},{t.multiplications:.0f},{t.error_m:.4f}" for t in trials),
    ]
    caption = "Cost of joining, and error of the car, by the share that two submaps must have."
    return finish_figure("submap-threshold", canvas, table, caption)
