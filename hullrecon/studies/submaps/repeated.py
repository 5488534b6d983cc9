# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Worlds of 441 landmarks with other noise: is a method as sure as it says? [Aulinas2011 (3.21)].

The error of one mission is one draw; whether a covariance is right, many missions tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.studies.association.point_sets import chi_square
from hullrecon.studies.study import ComparedValue
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits
from hullrecon.studies.submaps.missions import (
    build_submaps,
    final_track,
    run_filter,
    run_strategy,
)
from hullrecon.studies.submaps.models import compose, invert, wrap
from hullrecon.studies.submaps.selective import SelectiveJoining
from hullrecon.studies.submaps.world_study import EKF, SELECTIVE, THRESHOLD, simulate_world
from hullrecon.studies.submaps.worlds import Noise, Survey, World, simulate_survey
from hullrecon.typing import Array

FINAL = "SSJS by its final map"
FINER = 10.0
PLACE_WORDS = {
    EKF: "As known at each scan: it uses a landmark whenever it sees it, yet is too sure of "
    "itself, so one world ends well and another metres off",
    SELECTIVE: "As known at each scan. A submap starts without what the one before saw, so the "
    "chain drifts more than one filter until a loop is closed",
    FINAL: "As Table 3.3 is headed, and to be compared with EKF's",
}


@dataclass(frozen=True, kw_only=True)
class Repeated:
    """Missions through several worlds."""

    nees: dict[str, Array]  # (runs, scans) of the car's pose, by method
    place_m: dict[str, Array]  # (runs,) mean error of the car, by method and by what was known


def repeat_world(seeds: Sequence[int]) -> Repeated:
    """Run one filter and selective joining in several worlds."""
    nees: dict[str, list[Array]] = {EKF: [], SELECTIVE: []}
    place_m: dict[str, list[float]] = {EKF: [], SELECTIVE: [], FINAL: []}
    for seed in seeds:
        world, limits = simulate_world(seed), Limits()
        submaps = build_submaps(world.log, limits, Effort())
        selective = SelectiveJoining(THRESHOLD, limits.landmarks, Effort())
        tracks = {
            EKF: run_filter(world.log, Effort())[1],
            SELECTIVE: run_strategy(submaps, selective),
        }
        for name, track in tracks.items():
            nees[name].append(track.nees(world))
            place_m[name].append(float(track.distances(world).mean()))
        final = final_track(submaps, selective.world.frames())
        place_m[FINAL].append(float(final.distances(world).mean()))
    return Repeated(
        nees={name: np.array(runs) for name, runs in nees.items()},
        place_m={name: np.array(runs) for name, runs in place_m.items()},
    )


@dataclass(frozen=True, kw_only=True)
class SubmapEnds:
    """How far off submaps end, in their own frames, in sigmas squared."""

    worlds: int
    as_printed: Array  # (n,) NEES with the odometer of the thesis
    finer: Array  # (m,) the same with an odometer FINER times as good


def submap_ends(seeds: Sequence[int]) -> SubmapEnds:
    """Build the submaps of several worlds with a coarse and with a fine odometer."""
    fine = Noise(
        speed_m_s=Noise.speed_m_s / FINER,
        steering_rad=Noise.steering_rad / FINER,
    )
    by_noise = []
    for noise in (Noise(), fine):
        worlds = [simulate_survey(Survey(), noise, seed) for seed in seeds]
        by_noise.append(
            np.concatenate(
                [ends_nees(w, build_submaps(w.log, Limits(), Effort())) for w in worlds],
            )
        )
    return SubmapEnds(worlds=len(seeds), as_printed=by_noise[0], finer=by_noise[1])


def ends_nees(world: World, submaps: Sequence[EkfMap]) -> Array:
    """Compute the NEES (n,) of where each submap ended, in its own frame."""
    indices, base = [], world.track[0]
    for built in submaps:
        end = world.track[built.path[-1].step + 1]
        off = built.mean[:3] - compose(invert(base), end)
        off[2] = wrap(off[2])
        indices.append(float(off @ np.linalg.solve(built.covariance[:3, :3], off)))
        base = end
    return np.array(indices)


def mean_band(count: int) -> tuple[float, float]:
    """Compute what the mean NEES of a pose over consistent runs lies between in 95 of 100."""
    return chi_square(0.025, 3 * count) / count, chi_square(0.975, 3 * count) / count


def compare_ends(ends: SubmapEnds) -> tuple[ComparedValue, ...]:
    """Say how sure submaps are of where they end."""
    bands = [mean_band(len(nees)) for nees in (ends.as_printed, ends.finer)]
    words = [f"band of {ends.worlds} worlds: {low:.2f} to {high:.2f}" for low, high in bands]
    return (
        ComparedValue(
            what="mean NEES of where submaps end",
            unit="",
            printed=None,
            ours=float(ends.as_printed.mean()),
            note=f"printed: inside its bound; {words[0]}. Steering errs by 7 degrees and speed by "
            "half of itself: the product of both is no part of (3.7), which is of first order, and "
            "the gate of 99 % drops one honest reading in a hundred",
        ),
        ComparedValue(
            what=f"the same with an odometer {FINER:g} times as good",
            unit="",
            printed=None,
            ours=float(ends.finer.mean()),
            note=f"{words[1]}. The same filter where first order suffices",
        ),
    )


def compare_repeated(repeated: Repeated) -> tuple[ComparedValue, ...]:
    """Say how sure the methods are, beside how sure they may be."""
    runs = len(repeated.nees[EKF])
    values = []
    high = mean_band(runs)[1]
    for name, nees in repeated.nees.items():
        mean = nees.mean(axis=0)
        each = ", ".join(f"{run.mean():.1f}" for run in nees)
        values.append(
            ComparedValue(
                what=f"scans at which the mean NEES of {name} is below its bound",
                unit="%",
                printed=100.0 if name == SELECTIVE else None,
                ours=100 * float(np.mean(mean < high)),
                note=f"{runs} worlds, bound {high:.2f}; mean over the mission {mean.mean():.1f} "
                f"for 3 degrees of freedom, by world {each}",
            )
        )
    for name, errors in repeated.place_m.items():
        each = ", ".join(f"{error:.2f}" for error in errors)
        values.append(
            ComparedValue(
                what=f"mean error of the car by {name}, {runs} worlds",
                unit="m",
                printed=None,
                ours=float(errors.mean()),
                note=f"median {np.median(errors):.2f}; by world: {each}. {PLACE_WORDS[name]}",
            )
        )
    return tuple(values)
