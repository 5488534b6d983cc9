# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Consistency of one filter and of submaps [Aulinas2011 Fig. 2.2, eq (3.21)].

A car maps trees by a laser. A reading is the range and the bearing of one of them, a landmark.
NEES is the normalised estimation error squared, and the consistency index is its mean over runs by
the 95 % bound of that mean.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

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
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits
from hullrecon.studies.submaps.end_errors import (
    Ends,
    build_variant,
    ends_of,
    mean_band,
    together,
)
from hullrecon.studies.submaps.missions import (
    Track,
    build_submaps,
    run_filter,
    run_strategy,
)
from hullrecon.studies.submaps.models import observe
from hullrecon.studies.submaps.selective import SelectiveJoining
from hullrecon.studies.submaps.world_study import EKF, SELECTIVE, THRESHOLD
from hullrecon.studies.submaps.worlds import Noise, Survey, World, simulate_loop
from hullrecon.typing import Array

SQUARE = Survey(leg_m=40.0, leg_spacing_m=10.0, steps_a_scan=10)
LAPS, RUNS = 1.5, 10
FINE_LASER = Noise(range_m=0.01, bearing_rad=np.radians(0.1))
FINE_ODOMETRY = Noise(speed_m_s=0.1, steering_rad=np.radians(0.7))
CAUSES = {
    "where the laser reads what it runs over": (replace(SQUARE, blind_m=0.0), Noise()),
    "with a tenth of the odometry's noise": (SQUARE, FINE_ODOMETRY),
    "with a tenth of the laser's noise": (SQUARE, FINE_LASER),
}
READ_FROM_M = (0.5, 1.0, 2.0, 4.0)  # distances of a landmark at which it is read
READINGS = 300  # over which a NEES is averaged
SUBMAPS = "our submaps, each in its own frame"  # Jacobians at first estimates
PRINTED = "submaps as printed"  # Jacobians at the newest estimates
LINES = {EKF: INK, SELECTIVE: COLOURS["maxmix"], SUBMAPS: GREEN, PRINTED: GREEN}


@dataclass(frozen=True, kw_only=True)
class Lap:
    """One run around the square."""

    world: World
    tracks: dict[str, Track]
    ends: Ends  # of our submaps, each in its own frame
    printed: Ends  # of the printed ones


def run_lap(seed: int) -> Lap:
    """Run the printed filter and selective joining around the square, and our submaps."""
    world = simulate_loop(SQUARE, LAPS, Noise(), seed)
    limits = Limits()
    submaps = build_submaps(world.log, limits, Effort())
    selective = SelectiveJoining(THRESHOLD, limits.landmarks, Effort())
    return Lap(
        world=world,
        tracks={
            EKF: run_filter(world.log, Effort())[1],
            SELECTIVE: run_strategy(submaps, selective),
        },
        ends=ends_of(world, build_variant(world, first_estimates=True), seed),
        printed=ends_of(world, submaps, seed),
    )


def study_consistency() -> StudyResult:
    """Average the normalised errors of many runs."""
    laps = [run_lap(seed) for seed in range(RUNS)]
    index = {
        name: np.mean([lap.tracks[name].nees(lap.world) for lap in laps], axis=0) / bound(RUNS)
        for name in (EKF, SELECTIVE)
    }
    nees = {
        SUBMAPS: together([lap.ends for lap in laps]).nees,
        PRINTED: together([lap.printed for lap in laps]).nees,
    }
    for name, (survey, noise) in CAUSES.items():
        worlds = [simulate_loop(survey, LAPS, noise, seed) for seed in range(RUNS)]
        ends = [ends_of(world, build_variant(world)) for world in worlds]
        nees[f"{PRINTED}, {name}"] = together(ends).nees
    submap_index = {name: float(of.mean()) / bound(len(of)) for name, of in nees.items()}
    # over the last third, after the loop
    at_end = {name: float(values[2 * len(values) // 3 :].mean()) for name, values in index.items()}
    rows = [
        (name, f"{values.mean():.2f}", f"{at_end[name]:.2f}", f"{100 * np.mean(values > 1):.0f}")
        for name, values in index.items()
    ]
    rows += [(name, f"{value:.2f}", "–", "–") for name, value in submap_index.items()]
    drawn = {name: submap_index[name] for name in (SUBMAPS, PRINTED)}
    return StudyResult(
        figures=(_draw(laps, index, drawn),),
        values={**at_end, SUBMAPS: submap_index[SUBMAPS]},
        heads=("method", "index, all", "index, after the loop", "scans above 1, %"),
        rows=tuple(rows),
        compared=_compare(at_end, nees),
    )


def nees_after_reading(range_m: float) -> float:
    """Average the NEES of car and landmark, 5 degrees of freedom, after one reading of the latter.

    They are as unsure before it as within a submap; readings are those of the thesis.
    """
    rng, noise = np.random.default_rng(0), Noise()
    sigmas = np.array([0.12, 0.05, 0.01, 0.08, 0.08])  # of the car: m, m, rad; of the landmark: m
    indices = []
    for angle in rng.uniform(-np.pi, np.pi, READINGS):
        mark = range_m * np.array([np.cos(angle), np.sin(angle)])
        truth = np.array([0.0, 0.0, 0.0, *mark])
        built = EkfMap(Effort())
        built.mean, built.truth = truth + sigmas * rng.standard_normal(5), [0]
        built.covariance = np.diag(sigmas**2)
        reading = observe(truth[:3], mark[None])
        reading += rng.standard_normal((1, 2)) * [noise.range_m, noise.bearing_rad]
        built.update([0], reading, noise.laser)
        off = built.mean - truth
        indices.append(off @ np.linalg.solve(built.covariance, off))
    return float(np.mean(indices))


def _compare(at_end: dict[str, float], nees: dict[str, Array]) -> tuple[ComparedValue, ...]:
    """Compare consistency after the loop, and that of submaps' ends, with those printed.

    A note says the mean NEES after a single reading.

    Parameters
    ----------
    at_end
        Consistency index after the loop, by method.
    nees
        NEES (n,) of where submaps ended: of ours (SUBMAPS), as printed (PRINTED), and of the latter
        under each of CAUSES, whose words follow PRINTED and a comma.
    """
    ours = nees[SUBMAPS]
    low, high = mean_band(len(ours))  # 95 % of such a mean
    # As "2.34" or "2.34 with a tenth of the laser's noise"
    printed = [
        f"{of.mean():.2f}{name.removeprefix(PRINTED).replace(',', '')}"
        for name, of in nees.items()
        if name != SUBMAPS
    ]
    return (
        ComparedValue(
            what="consistency index of one filter, after the loop",
            ours=at_end[EKF],
            note="printed as a curve that rises above 1; 1 is the 95 % bound of the mean "
            f"of {RUNS} runs",
        ),
        ComparedValue(
            what="consistency index of selective joining, after the loop",
            ours=at_end[SELECTIVE],
            note="printed as a curve that stays below 1",
        ),
        ComparedValue(
            what="consistency index of our submaps, in their own frames",
            printed=1.0,
            ours=float(ours.mean()) / bound(len(ours)),
            note=f"printed: below. Mean NEES of where each ended {ours.mean():.2f}, band of "
            f"{len(ours)}: {low:.2f} to {high:.2f}. Ours are linearised at first estimates "
            "[Huang2010]. As printed, at the newest, (3.8) and (3.9), they have "
            f"{', '.join(printed)}. One reading of a landmark leaves car and landmark, of 5 "
            "degrees of freedom, with a mean NEES of "
            + ", ".join(f"{nees_after_reading(r):.1f} at {r} m" for r in READ_FROM_M)
            + ": nearer than 2 m, where the car would run over it, nothing is read",
        ),
    )


def bound(runs: int) -> float:
    """Compute the 95 % bound on the mean NEES of a pose (3 degrees of freedom) over runs."""
    return chi_square(0.95, 3 * runs) / runs


def _draw(
    laps: list[Lap], index: dict[str, Array], submap_index: dict[str, float]
) -> PublishedFigure:
    """Draw the tracks of the first lap, and the consistency index over time by method.

    The index is the mean NEES of the pose over its 95 % bound: below 1 a method is consistent.

    Parameters
    ----------
    laps
        Runs with different noise, of which the index is the mean.
    index
        Index (n,) at each scan, by method.
    submap_index
        Index of where submaps ended in their own frames, by variant.
    """
    canvas, rows = new_canvas(10.0, 4.2, 1, 2)
    world, tracks = laps[0].world, laps[0].tracks
    axis = rows[0][0]
    axis.plot(*world.landmarks.T, ".", color="#cdd5dd", ms=3)
    axis.plot(*world.track[:, :2].T, color=RED, lw=1, label="truth")
    axis.plot(*tracks[EKF].poses[:, :2].T, color=INK, lw=1, label="one filter")
    axis.plot(*tracks[SELECTIVE].poses[:, :2].T, color=LINES[SELECTIVE], lw=1, label=SELECTIVE)
    axis.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    axis.legend(frameon=False, fontsize=8, loc="center")
    axis = rows[0][1]
    times = (tracks[EKF].steps + 1) * world.log.step_s[0]
    for name, values in index.items():
        axis.plot(times, values, color=LINES[name], lw=1.2, label=name)
    for name, value in submap_index.items():
        axis.axhline(
            value, color=LINES[name], lw=1.2, ls="-" if name == SUBMAPS else ":", label=name
        )
    axis.axhline(1.0, color=RED, ls="--", lw=1, label="bound, 95 %")
    axis.set(xlabel="time (s)", ylabel="consistency index")
    axis.legend(frameon=False, fontsize=8)
    table = [f"time_s,{','.join(index)}"]
    for number, time in enumerate(times):
        table.append(",".join(f"{v:.3f}" for v in (time, *(i[number] for i in index.values()))))
    caption = (
        f"A lap and a half, and the mean of {len(laps)} runs' normalised errors by its 95 % bound."
    )
    return finish_figure("submap-consistency", canvas, table, caption)
