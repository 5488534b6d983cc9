# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""REMUS' mission: targets seen by side-scan as landmarks of submaps [Aulinas2011 5.2].

300 x 400 m and nearly four hours, at 12 m and later at 14 m over a floor at 16 m, surfacing once
in between. LBL serves as reference alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from hullrecon.studies.vehicles.joined_map import JoinedMap, Submap
from hullrecon.studies.vehicles.local_map import LocalMap
from hullrecon.studies.vehicles.mission import Manner, Mission, drive, lawnmower
from hullrecon.studies.vehicles.sensors import (
    FLOOR,
    VEHICLE,
    Sigmas,
    navigation_rows,
    place_target,
    see_target,
)
from hullrecon.studies.vehicles.transforms import wrapped
from hullrecon.typing import Array, Ints

SIZE_M = (400.0, 300.0)
FLOOR_M = 16.0
MANNER = Manner(speed_mps=1.5, turn_rad_s=0.1, reach_m=8.0, wobble_rad=0.02)
STEP_S = 1.0
TARGETS = 90
SWATH_M = (5.0, 45.0)  # to either side
SONAR_REACH_M = 6.0  # altitude above which the floor is not seen
FAR_M = 20.0  # landmarks farther from a sighting along an axis are not tried: saves time
FALSE_SHARE = 0.01  # of detections [Aulinas2011 Table 4.2]
LANDMARKS = 15  # of a submap [Aulinas2011 3.4.1]
LBL_M, LBL_EVERY = 0.7, 4  # sigma of a fix in x and in y; steps from fix to fix
NEW, KNOWN = float(chi2.ppf(0.9999, 3)), float(chi2.ppf(0.99, 3))
# What a step adds to the state's variances: constant velocity is only nearly true.
MOTION = np.r_[[1e-6] * 3, [2e-4, 2e-4, 0.01], [0.02] * 3, [2e-4]]
NAVIGATION = navigation_rows()


@dataclass(frozen=True, kw_only=True)
class Sighting:
    """A detection in the side-scan image."""

    step: int
    seen: Array  # (3,) forward, starboard, down
    label: int  # true number of the target, -1 for none


@dataclass(frozen=True, kw_only=True)
class Survey:
    """A mission with its targets, detections and reference."""

    mission: Mission
    targets: Array  # (t, 3)
    sightings: tuple[Sighting, ...]
    lbl_step: Ints  # (f,)
    lbl: Array  # (f, 2) x, y
    sigmas: Sigmas


@dataclass(frozen=True, kw_only=True)
class Run:
    """What SLAM made of a survey."""

    online: Array  # (n, 2) x, y as known at each step
    online_covariance: Array  # (n, 2, 2)
    path: Array  # (n, 3) with the starts of submaps as known at the end
    submap: Ints  # (n,)
    map: JoinedMap
    wrong_pairs: int  # detections taken for another landmark inside submaps


def simulate_survey(seed: int, passes: int = 3, sigmas: Sigmas | None = None) -> Survey:
    """Simulate the mission: lawnmowers along x and along y in turn, 12 m deep, then 14 m.

    Parameters
    ----------
    seed
        Of targets and noise.
    passes
        Pairs of lawnmowers, one along each axis. Half way through them, the vehicle surfaces.
    sigmas
        Noise of the sensors, `Sigmas` if absent.
    """
    rng = np.random.default_rng(seed)
    sigmas = sigmas or Sigmas()
    legs, depths = [], []
    for k in range(2 * passes):
        across = k % 2 == 1
        size = SIZE_M[::-1] if across else SIZE_M
        corners = lawnmower(size, 40.0, offset_m=7.0 * (k // 2))
        legs.append(corners[:, ::-1] if across else corners)
        depths.append(np.full(len(corners), 12.0 if k < passes else 14.0))
        # half way it surfaces at the end of a lawnmower
        depths[-1][-2:] = 0.3 if k == passes - 1 else depths[-1][0]
    waypoints = np.vstack(legs)
    mission = drive(rng, waypoints, np.concatenate(depths), FLOOR_M, MANNER, STEP_S, sigmas)
    targets = np.column_stack(
        [rng.uniform(-20, np.array(SIZE_M) + 20, (TARGETS, 2)), np.full(TARGETS, FLOOR_M)]
    )
    targets[:, 2] += 0.2 * np.sin(targets[:, 0] / 40) * np.cos(targets[:, 1] / 55)
    lbl_step = np.arange(0, len(mission.truth), LBL_EVERY)
    fixes = mission.truth[lbl_step, :2] + LBL_M * rng.standard_normal((len(lbl_step), 2))
    return Survey(
        mission=mission,
        targets=targets,
        sightings=tuple(_sightings(rng, mission, targets, sigmas)),
        lbl_step=lbl_step,
        lbl=fixes,
        sigmas=sigmas,
    )


def _sightings(
    rng: np.random.Generator, mission: Mission, targets: Array, sigmas: Sigmas
) -> list[Sighting]:
    """Simulate side-scan's sightings of targets (t, 3) m within the swath, and some false ones.

    A target is seen in the step in which it comes abeam. It is up to a step's way forward then, as
    the time of the ping that saw it is known.
    """
    found = []
    for step, state in enumerate(mission.truth):
        if mission.floor_m[step] - state[2] > SONAR_REACH_M:
            continue  # near the surface
        vehicle = np.r_[state, mission.floor_m[step]]
        for label in np.flatnonzero(np.hypot(*(targets - state[:3])[:, :2].T) < SWATH_M[1] + 2):
            seen, _, _ = see_target(vehicle, targets[label])
            ahead = 0 <= seen[0] < MANNER.speed_mps * mission.step_s
            if ahead and SWATH_M[0] < abs(seen[1]) < SWATH_M[1]:
                noisy = seen + sigmas.target_m * rng.standard_normal(3)
                found.append(Sighting(step=step, seen=noisy, label=int(label)))
                if rng.uniform() < FALSE_SHARE:
                    wrong = np.r_[0.0, rng.choice([-1, 1]) * rng.uniform(*SWATH_M), seen[2]]
                    found.append(Sighting(step=step, seen=wrong, label=-1))
    return found


def run_slam(survey: Survey, landmarks: int = LANDMARKS, state_sigmas: float = 1.0) -> Run:
    """Run SLAM with submaps of `landmarks` each, joined selectively.

    The filter assumes `state_sigmas` times the sensors' true sigmas.
    """
    survey = replace(survey, sigmas=survey.sigmas.scaled(state_sigmas))
    mission, whole = survey.mission, JoinedMap(axes=2)
    local = _start(survey, 0)
    n = len(mission.truth)
    # By step: position as then known, with covariance, and position in a submap, with its number
    online, covariance = np.zeros((n, 2)), np.zeros((n, 2, 2))
    in_submap, submap = np.zeros((n, 3)), np.zeros(n, int)
    by_step: dict[int, list[Sighting]] = {}
    for sighting in survey.sightings:
        by_step.setdefault(sighting.step, []).append(sighting)
    wrong = 0  # pairs of a sighting and a landmark that it is not of
    for step in range(n):
        if step:
            local.predict(mission.step_s, MOTION)
            if local.count >= landmarks:
                # It ends before this step's measurements, which start the next one: independent.
                whole.join(_finish(local))
                local = _start(survey, step)
            else:
                _navigate(local, survey, step)
        wrong += sum(_observe(local, it, survey.sigmas) for it in by_step.get(step, []))
        submap[step], in_submap[step] = len(whole.starts) - 1, local.vehicle[:3]
        online[step] = whole.starts[-1] + local.vehicle[:2]
        covariance[step] = whole.start_covariance(-1) + local.covariance[:2, :2]
    whole.join(_finish(local))
    path = in_submap.copy()
    path[:, :2] += whole.starts[submap]
    shift = mission.truth[0, :2]  # the map starts at zero, the mission here
    return Run(
        online=online + shift,
        online_covariance=covariance,
        path=path + np.r_[shift, 0.0],
        submap=submap,
        map=whole,
        wrong_pairs=wrong,
    )


def _start(survey: Survey, step: int) -> LocalMap:
    """Start a submap at the origin of its own frame, from one step's measurements.

    Depth, attitude and velocity are as measured, the floor is altitude below depth.
    """
    attitude, velocity, (depth, altitude) = np.split(survey.mission.measured[step], [3, 6])
    noise = survey.sigmas.navigation()
    vehicle = np.r_[0.0, 0.0, depth, attitude, velocity, depth + altitude]
    covariance = np.diag(np.r_[1e-9, 1e-9, noise[6], noise[:6], noise[6] + noise[7]])
    covariance[2, FLOOR] = covariance[FLOOR, 2] = noise[6]
    return LocalMap(vehicle, covariance, size=3)


def _navigate(local: LocalMap, survey: Survey, step: int) -> None:
    """Update a submap by attitude, velocity, depth and altitude measured at a step."""
    residual = survey.mission.measured[step] - NAVIGATION @ local.vehicle
    residual[:3] = wrapped(residual[:3])
    noise = np.diag(survey.sigmas.navigation())
    local.update(np.arange(VEHICLE), NAVIGATION, residual, noise)


def _observe(local: LocalMap, sighting: Sighting, sigmas: Sigmas) -> bool:
    """Update a submap by a detection of a landmark that it has, or add it as a new one.

    One that fits a landmark badly, but too well for a new one, is left out. Returns whether it was
    taken for another landmark than its own.
    """
    noise = sigmas.target()
    best, nearest = np.inf, -1
    for k in range(local.count):
        rows = np.r_[np.arange(VEHICLE), local.rows_of(k)]
        expected, by_vehicle, by_landmark = see_target(local.vehicle, local.landmark(k))
        if np.abs(sighting.seen - expected).max() > FAR_M:
            continue
        jacobian = np.hstack([by_vehicle, by_landmark])
        _, spread = local.innovation(rows, jacobian, noise)
        off = sighting.seen - expected
        distance = float(off @ np.linalg.solve(spread, off))
        if distance < best:
            best, nearest, held = distance, k, (rows, jacobian, off)
    if best < KNOWN:
        local.update(*held, noise)
        return local.labels[nearest] != sighting.label
    if best > NEW:
        place, by_vehicle, by_seen = place_target(local.vehicle, sighting.seen)
        local.add(place, by_vehicle, by_seen @ noise @ by_seen.T, sighting.label)
    return False


def _finish(local: LocalMap) -> Submap:
    """Finish a submap: its landmarks and the vehicle's last position, with covariance."""
    rows = np.r_[np.arange(VEHICLE, len(local.mean)), 0, 1]
    return Submap(
        points=local.mean[VEHICLE:].reshape(-1, 3),
        end=local.mean[:2],
        covariance=local.covariance[np.ix_(rows, rows)],
        labels=tuple(local.labels),
    )


def discrepancy(survey: Survey, run: Run) -> tuple[Array, Array]:
    """Compute LBL less SLAM in x and y (f, 2) m at each fix, and its bound (f, 2) m.

    The bound is 3 sigma of both together.
    """
    variance = np.diagonal(run.online_covariance, axis1=1, axis2=2)[survey.lbl_step]
    return survey.lbl - run.online[survey.lbl_step], 3 * np.sqrt(variance + LBL_M**2)
