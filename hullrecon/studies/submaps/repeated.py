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
from hullrecon.studies.submaps.missions import build_submaps, run_filter, run_strategy
from hullrecon.studies.submaps.models import compose, invert, wrap
from hullrecon.studies.submaps.selective import SelectiveJoining
from hullrecon.studies.submaps.world_study import EKF, SELECTIVE, THRESHOLD, simulate_world
from hullrecon.studies.submaps.worlds import World
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class Repeated:
    """Missions through several worlds."""

    nees: dict[str, Array]  # (runs, scans) of the car's pose, by method
    place_m: dict[str, Array]  # (runs,) mean error of the car as known then, by method
    ends: Array  # (n,) NEES of where each submap ended, in its own frame


def repeat_world(seeds: Sequence[int]) -> Repeated:
    """Run one filter and selective joining in several worlds."""
    nees: dict[str, list[Array]] = {EKF: [], SELECTIVE: []}
    place_m: dict[str, list[float]] = {EKF: [], SELECTIVE: []}
    ends = []
    for seed in seeds:
        world, limits = simulate_world(seed), Limits()
        submaps = build_submaps(world.log, limits, Effort())
        ends.append(ends_nees(world, submaps))
        selective = SelectiveJoining(THRESHOLD, limits.landmarks, Effort())
        tracks = {
            EKF: run_filter(world.log, Effort())[1],
            SELECTIVE: run_strategy(submaps, selective),
        }
        for name, track in tracks.items():
            nees[name].append(track.nees(world))
            place_m[name].append(float(track.distances(world).mean()))
    return Repeated(
        nees={name: np.array(runs) for name, runs in nees.items()},
        place_m={name: np.array(runs) for name, runs in place_m.items()},
        ends=np.concatenate(ends),
    )


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


def compare_repeated(repeated: Repeated) -> tuple[ComparedValue, ...]:
    """Say how sure the methods are, beside how sure they may be."""
    runs = len(repeated.nees[EKF])
    low, high = mean_band(len(repeated.ends))
    values = [
        ComparedValue(
            what="mean NEES of where submaps end",
            unit="",
            printed=None,
            ours=float(repeated.ends.mean()),
            note=f"printed: inside its bound. Band of {len(repeated.ends)} ends: {low:.2f} to "
            f"{high:.2f}",
        )
    ]
    low, high = mean_band(runs)
    for name, nees in repeated.nees.items():
        mean = nees.mean(axis=0)
        values.append(
            ComparedValue(
                what=f"scans at which the mean NEES of {name} is below its bound",
                unit="%",
                printed=100.0 if name == SELECTIVE else None,
                ours=100 * float(np.mean(mean < high)),
                note=f"{runs} worlds, bound {high:.2f}; "
                f"mean over the mission {mean.mean():.1f} for 3 degrees of freedom",
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
                note=f"at each scan, as known then; by world: {each}",
            )
        )
    return tuple(values)
