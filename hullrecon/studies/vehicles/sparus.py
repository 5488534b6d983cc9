# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""SPARUS' mission: points of the floor seen by one camera, by inverse depth [Aulinas2011 5.3].

20 x 20 m in a grid of 5 m, some 17 minutes at 17 m, three frames a second. DVL, IMU and camera
alone: no pressure, so that depth drifts too. As in the thesis, points are random ones of the
floor, and which point a pixel shows is known, as points were picked in a mosaic and traced back.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hullrecon.studies.vehicles.inverse_depth import (
    DOWN,
    PUBLISHED_RHO,
    SIZE,
    Pinhole,
    new_landmark,
    see_landmark,
    to_point,
)
from hullrecon.studies.vehicles.joined_map import JoinedMap, Submap
from hullrecon.studies.vehicles.local_map import LocalMap
from hullrecon.studies.vehicles.mission import Manner, Mission, drive, lawnmower
from hullrecon.studies.vehicles.sensors import Sigmas
from hullrecon.studies.vehicles.transforms import rotation, wrapped
from hullrecon.typing import Array, Ints

SIZE_M = (20.0, 20.0)
GRID_M = 5.0
DEPTH_M, FLOOR_M = 17.0, 19.5
STEP_S = 1.0 / 3
MANNER = Manner(speed_mps=0.26, turn_rad_s=0.15, reach_m=0.5, wobble_rad=0.02)
CAMERA = Pinhole(focal_px=277.0, centre_px=(160.0, 120.0), size_px=(320, 240))
PIXEL_SIGMA = 1.0
SIGMAS = Sigmas(attitude_rad=(0.01, 0.01, 0.015), velocity_mps=0.06)
POINTS_PER_M2 = 0.35
RELIEF_M = 0.15  # sigma of the points' heights
LANDMARKS = 15  # of a submap [Aulinas2011 3.4.1]
RHO_SIGMA = 0.5  # 1/m, of a new landmark [Civera2008]
# What a step adds to the vehicle's variances.
MOTION = np.r_[[1e-8] * 3, [1e-5, 1e-5, 1e-3], [4e-4] * 3]


@dataclass(frozen=True, kw_only=True)
class Survey:
    """A mission and what its camera saw."""

    mission: Mission
    points: Array  # (p, 3) true places
    seen: tuple[dict[int, Array], ...]  # of each frame: pixel (2,) of each point in it


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """A landmark's pixel before it was seen again."""

    step: int
    label: int
    again: int  # how often it has been seen before
    expected: Array  # (2,) px
    spread: Array  # (2, 2) px^2, of its projection alone
    seen: Array  # (2,)


@dataclass(kw_only=True)
class Run:
    """What SLAM made of a survey."""

    online: Array  # (n, 3) position as known at each step
    online_covariance: Array  # (n, 3, 3)
    path: Array  # (n, 3) with the starts of submaps as known at the end
    submap: Ints  # (n,)
    map: JoinedMap
    predictions: list[Prediction] = field(default_factory=list)


def simulate_survey(seed: int, size_m: tuple[float, float] = SIZE_M) -> Survey:
    """Simulate the grid: legs along x, then along y, and back to the start."""
    rng = np.random.default_rng(seed)
    along = lawnmower(size_m, GRID_M)
    across = lawnmower(size_m[::-1], GRID_M)[:, ::-1]
    if np.linalg.norm(across[-1] - along[-1]) < np.linalg.norm(across[0] - along[-1]):
        across = across[::-1]
    waypoints = np.vstack([along, across, along[:1]])
    depths = np.full(len(waypoints), DEPTH_M)
    mission = drive(rng, waypoints, depths, FLOOR_M, MANNER, STEP_S, SIGMAS)
    count = round(POINTS_PER_M2 * (size_m[0] + 4) * (size_m[1] + 4))
    places = rng.uniform(-2, np.array(size_m) + 2, (count, 2))
    points = np.column_stack([places, FLOOR_M + RELIEF_M * rng.standard_normal(count)])
    return Survey(
        mission=mission,
        points=points,
        seen=tuple(_look(rng, state, points) for state in mission.truth),
    )


def _look(rng: np.random.Generator, state: Array, points: Array) -> dict[int, Array]:
    """Simulate an image: the pixel (2,), with noise, of each point (p, 3) m that falls into it.

    state: (9,) of the vehicle. Points are by their numbers.
    """
    rays = (points - state[:3]) @ rotation(state[3:6]) @ DOWN
    seen = {}
    # Only those within 45 degrees of the camera's axis are projected: saves time
    for label in np.flatnonzero(np.hypot(*rays[:, :2].T) < rays[:, 2]):
        if CAMERA.sees(rays[label]):
            pixel, _ = CAMERA.project(rays[label])
            seen[int(label)] = pixel + PIXEL_SIGMA * rng.standard_normal(2)
    return seen


def run_slam(survey: Survey, landmarks: int = LANDMARKS) -> Run:
    """Run SLAM with submaps of `landmarks` each, which start at the published inverse depth."""
    mission, whole = survey.mission, JoinedMap(axes=3, labelled=True)
    local = _start(mission, 0)
    n = len(mission.truth)
    # By step: position as then known, with covariance, and position in a submap, with its number
    online, covariance = np.zeros((n, 3)), np.zeros((n, 3, 3))
    in_submap, submap = np.zeros((n, 3)), np.zeros(n, int)
    predictions: list[Prediction] = []
    again: dict[int, int] = {}  # by landmark of the submap, how often it was seen again
    for step in range(n):
        if step:
            local.predict(mission.step_s, MOTION)
            if local.count >= landmarks:
                whole.join(_finish(local))
                local, again = _start(mission, step), {}
            else:
                _navigate(local, mission, step)
        for label, pixel in survey.seen[step].items():
            predictions += _observe(local, step, label, pixel, again)
        submap[step], in_submap[step] = len(whole.starts) - 1, local.vehicle[:3]
        online[step] = whole.starts[-1] + local.vehicle[:3]
        covariance[step] = whole.start_covariance(-1) + local.covariance[:3, :3]
    whole.join(_finish(local))
    shift = mission.truth[0, :3]  # the map starts at zero, the mission here
    return Run(
        online=online + shift,
        online_covariance=covariance,
        path=in_submap + whole.starts[submap] + shift,
        submap=submap,
        map=whole,
        predictions=predictions,
    )


def _start(mission: Mission, step: int) -> LocalMap:
    """Start a submap at the origin of its own frame, with one step's attitude and velocity."""
    measured, noise = mission.measured[step, :6], SIGMAS.navigation()[:6]
    covariance = np.diag(np.r_[[1e-9] * 3, noise])
    return LocalMap(np.r_[np.zeros(3), measured], covariance, size=SIZE)


def _navigate(local: LocalMap, mission: Mission, step: int) -> None:
    """Update a submap by the attitude and velocity measured at a step."""
    residual = mission.measured[step, :6] - local.vehicle[3:9]
    residual[:3] = wrapped(residual[:3])
    local.update(np.arange(3, 9), np.eye(6), residual, np.diag(SIGMAS.navigation()[:6]))


def _observe(
    local: LocalMap, step: int, label: int, pixel: Array, again: dict[int, int]
) -> list[Prediction]:
    """Update a submap by the pixel (2,) of a landmark that it has, or add a new landmark.

    again: how often each landmark was seen again, which is counted here. Returns the prediction
    of the pixel, none of a new landmark.
    """
    noise = PIXEL_SIGMA**2 * np.eye(2)
    if label not in local.labels:
        landmark, by_pose, by_seen = new_landmark(CAMERA, local.vehicle[:6], pixel, PUBLISHED_RHO)
        by_vehicle = np.hstack([by_pose, np.zeros((SIZE, 3))])
        unsure = by_seen @ np.diag([PIXEL_SIGMA**2, PIXEL_SIGMA**2, RHO_SIGMA**2]) @ by_seen.T
        local.add(landmark, by_vehicle, unsure, label)
        again[label] = 0
        return []
    k = local.labels.index(label)
    rows = np.r_[np.arange(6), local.rows_of(k)]
    expected, by_pose, by_landmark = see_landmark(CAMERA, local.vehicle[:6], local.landmark(k))
    jacobian = np.hstack([by_pose, by_landmark])
    _, spread = local.innovation(rows, jacobian, np.zeros((2, 2)))
    local.update(rows, jacobian, pixel - expected, noise)
    again[label] += 1
    return [
        Prediction(
            step=step, label=label, again=again[label], expected=expected, spread=spread, seen=pixel
        )
    ]


def _finish(local: LocalMap) -> Submap:
    """Finish a submap: its landmarks as points, and the vehicle's last position.

    A landmark whose inverse depth is not yet sure to a tenth is left out.
    """
    kept = []
    for k in range(local.count):
        row = int(local.rows_of(k)[5])
        if np.sqrt(local.covariance[row, row]) < 0.1 * local.mean[row]:
            kept.append(k)
    by_state = np.zeros((3 * len(kept) + 3, len(local.mean)))
    points = np.zeros((len(kept), 3))
    for place, k in enumerate(kept):
        points[place], jacobian = to_point(local.landmark(k))
        by_state[3 * place : 3 * place + 3, local.rows_of(k)] = jacobian
    by_state[-3:, :3] = np.eye(3)
    return Submap(
        points=points,
        end=local.mean[:3],
        covariance=by_state @ local.covariance @ by_state.T,
        labels=tuple(local.labels[k] for k in kept),
    )
