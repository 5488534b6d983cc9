# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Consistency of the methods over worlds of 441 landmarks with other noise [Aulinas2011 (3.21)].

The error of one mission is one draw. Only many missions show whether a covariance is right.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.studies.study import ComparedValue
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import Limits
from hullrecon.studies.submaps.end_errors import (
    EndsByForm,
    build_variant,
    ends_of,
    mean_band,
    together,
)
from hullrecon.studies.submaps.missions import Track, final_track, run_filter, run_strategy
from hullrecon.studies.submaps.selective import SelectiveJoining
from hullrecon.studies.submaps.world_study import EKF, SELECTIVE, THRESHOLD, simulate_world
from hullrecon.studies.submaps.worlds import Survey, World
from hullrecon.typing import Array

FIRST = "by first estimates"  # Jacobians at first estimates [Huang2010], not at the newest
EKF_FIRST, SELECTIVE_FIRST = f"{EKF} {FIRST}", f"{SELECTIVE} {FIRST}"


@dataclass(frozen=True, kw_only=True)
class WorldRuns:
    """A world by one filter and by selective joining."""

    world: World
    tracks: dict[str, Track]  # by method, as known at each scan
    final: dict[str, Track]  # by the final map, of selective joining
    ends: EndsByForm  # of the submaps


@dataclass(frozen=True, kw_only=True)
class Repeated:
    """Runs through several worlds."""

    runs: list[WorldRuns]

    def nees(self) -> dict[str, Array]:
        """Compute the NEES (runs, scans) of the car's pose by method."""
        return {
            name: np.array([run.tracks[name].nees(run.world) for run in self.runs])
            for name in self.runs[0].tracks
        }

    def place_m(self) -> dict[str, Array]:
        """Compute the car's mean position error (runs,) m by method, by the final map if any."""

        def of(run: WorldRuns, name: str) -> float:
            """Average over the scans of one run."""
            track = run.final.get(name, run.tracks[name])
            return float(track.distances(run.world).mean())

        names = self.runs[0].tracks
        return {name: np.array([of(run, name) for run in self.runs]) for name in names}

    def first_leg_m(self) -> dict[str, Array]:
        """Compute the errors (runs,) at the end of the first leg, before any loop, by method."""
        survey = Survey()
        steps = survey.leg_m / (survey.speed_m_s * survey.step_s)

        def of(run: WorldRuns, name: str) -> float:
            """Take the error at the last scan of the first leg."""
            track = run.tracks[name]
            return float(track.distances(run.world)[track.steps < steps][-1])

        names = self.runs[0].tracks
        return {name: np.array([of(run, name) for run in self.runs]) for name in names}

    def ends(self) -> EndsByForm:
        """Pool where the submaps of all worlds ended, by the form of the filter."""
        return EndsByForm(
            first_estimates=together([run.ends.first_estimates for run in self.runs]),
            printed=together([run.ends.printed for run in self.runs]),
            true_covariance=together([run.ends.true_covariance for run in self.runs]),
            both=together([run.ends.both for run in self.runs]),
        )


def repeat_world(seeds: Sequence[int]) -> Repeated:
    """Run one filter and selective joining in several worlds, as printed and by first estimates."""
    return Repeated(runs=[_run(simulate_world(seed), number) for number, seed in enumerate(seeds)])


def _run(world: World, number: int) -> WorldRuns:
    """Run the filter and selective joining in a world, with Jacobians as printed and as ours."""
    submaps = {flag: build_variant(world, first_estimates=flag) for flag in (False, True)}
    known = {
        flag: build_variant(world, first_estimates=flag, true_covariance=True)
        for flag in (False, True)
    }
    tracks, final = {}, {}
    for flag, (one, many) in {False: (EKF, SELECTIVE), True: (EKF_FIRST, SELECTIVE_FIRST)}.items():
        tracks[one] = run_filter(world.log, Effort(), first_estimates=flag)[1]
        selective = SelectiveJoining(THRESHOLD, Limits().landmarks, Effort())
        tracks[many] = run_strategy(submaps[flag], selective)
        final[many] = final_track(submaps[flag], selective.world.frames())
    return WorldRuns(
        world=world,
        tracks=tracks,
        final=final,
        ends=EndsByForm(
            first_estimates=ends_of(world, submaps[True], number),
            printed=ends_of(world, submaps[False], number),
            true_covariance=ends_of(world, known[False], number),
            both=ends_of(world, known[True], number),
        ),
    )


def compare_repeated(repeated: Repeated) -> tuple[ComparedValue, ...]:
    """Compare the methods' sigmas with their errors, and the errors with each other."""
    runs = len(repeated.runs)
    high = mean_band(runs)[1]
    values = [
        ComparedValue(
            what=f"scans at which the mean NEES of {name} is below its bound",
            unit="%",
            printed=100.0 if name in (SELECTIVE, SELECTIVE_FIRST) else None,
            ours=100 * float(np.mean(nees.mean(axis=0) < high)),
            note=f"{NEES_WORDS[name]} {runs} worlds, bound {high:.2f}; mean over the mission "
            f"{nees.mean():.1f} for 3 degrees of freedom, by world {_each(nees.mean(axis=1), 1)}",
        )
        for name, nees in repeated.nees().items()
    ]
    first_leg = {
        name: float(np.sqrt(np.mean(off**2))) for name, off in repeated.first_leg_m().items()
    }
    for name, errors in repeated.place_m().items():
        values.append(
            ComparedValue(
                what=f"mean error of the car by {name}, {runs} worlds",
                unit="m",
                ours=float(errors.mean()),
                note=f"median {np.median(errors):.2f}, worst {errors.max():.2f}; by world: "
                f"{_each(errors, 2)}. At the end of "
                f"the first leg, before any loop, {first_leg[name]:.2f} m (rms). "
                + PLACE_WORDS[name],
            )
        )
    return tuple(values)


def _each(values: Array, digits: int) -> str:
    return ", ".join(f"{value:.{digits}f}" for value in values)


NEES_WORDS = {
    EKF: "As printed, outside: it linearises at the newest estimates, (3.8) and (3.9).",
    SELECTIVE: "As printed, with the same fault, of which a submap gathers less.",
    EKF_FIRST: "One filter with our linearisation.",
    SELECTIVE_FIRST: "Submaps with our linearisation, joined as printed.",
}
PLACE_WORDS = {
    EKF: "As known at each scan. It keeps what it has in view, so most worlds end well, yet is too "
    "sure of itself, so a few end metres off: the mean is theirs",
    SELECTIVE: "By its final map, as Table 3.3 is headed. A submap begins without what the one "
    "before had in view, so the chain drifts more before it is closed: the median is worse than "
    "EKF's, the mean and the worst world are not",
    EKF_FIRST: "As known at each scan. Sure as it may be, and in most worlds no nearer for it",
    SELECTIVE_FIRST: "By its final map. Beside a filter that is as sure as it may be, what submaps "
    "forget at their borders costs nearly nothing",
}
