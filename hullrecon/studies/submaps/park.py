# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A park with trees that a car drives through: simulated, or Victoria Park by its public files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hullrecon.errors import InputError
from hullrecon.studies.association.trunks import (
    RADII_M,
    REACH_M,
    find_trunks,
    scan_trees,
    trunk_readings,
)
from hullrecon.studies.submaps.models import Car, invert, place, sighted_points, wrap
from hullrecon.studies.submaps.worlds import Log, Noise, Scan, World
from hullrecon.typing import Array, Ints

SIZE_M = (197.0, 93.0)  # of Victoria Park, p. 54
TREES, APART_M = 60, 5.0
SPEED_M_S = 2.6  # 4 km in 26 minutes
STEP_S, STEPS_A_SCAN = 0.1, 10  # a scan a second, as printed
LAPS = 2
AHEAD_M = 8.0  # the car steers for a point of its way so far ahead
SHARPEST_RAD = 0.5
RANGE_SIGMA_M = 0.01  # of a laser's beam
# not printed: of the car's counters, and of a trunk's middle as a scan shows it
NOISE = Noise(
    speed_m_s=0.3, steering_rad=np.radians(3.0), range_m=0.10, bearing_rad=np.radians(0.3)
)
FILES = ("aa3_dr.mat", "aa3_lsr2.mat", "aa3_gpsx.mat")


@dataclass(frozen=True, kw_only=True)
class Park:
    """A simulated park."""

    world: World
    trees: Array  # (k, 3) x, y, radius, in the mission's frame


def simulate_park(seed: int, laps: float = LAPS) -> Park:
    """Simulate a drive around a park; trunks are found in scans of a half circle."""
    rng = np.random.default_rng(seed)
    way = _way(laps)
    start = np.array([*way[0], np.arctan2(*(way[1] - way[0])[::-1])])
    trees = _trees(way, rng)
    points = place(invert(start), trees[:, :2])
    trees = np.column_stack([points, trees[:, 2]])
    controls = follow(place(invert(start), way))
    car, scans = Car(), {}
    track = np.zeros((len(controls) + 1, 3))
    for step, (speed, steering) in enumerate(controls):
        track[step + 1] = car.move(track[step], speed, steering, STEP_S)
        if (step + 1) % STEPS_A_SCAN == 0:
            ranges = scan_trees(track[step + 1], trees, RANGE_SIGMA_M, rng)
            readings = trunk_readings(find_trunks(ranges))
            scans[step] = Scan(readings=readings, truth=_nearest(readings, track[step + 1], trees))
    sigmas = [NOISE.speed_m_s, NOISE.steering_rad]
    odometry = controls + rng.standard_normal(controls.shape) * sigmas
    step_s = np.full(len(controls), STEP_S)
    log = Log(car=car, noise=NOISE, step_s=step_s, odometry=odometry, scans=scans)
    return Park(
        world=World(landmarks=trees[:, :2], track=track, controls=controls, log=log), trees=trees
    )


def _way(laps: float) -> Array:
    """Lay a way (k, 2) m of laps through the park, about a point every metre.

    An ellipse with a waist, so that curves go to either side.
    """
    angle = np.linspace(0, 2 * np.pi * laps, round(laps * 400))
    x = SIZE_M[0] / 2 + 0.40 * SIZE_M[0] * np.cos(angle)
    y = SIZE_M[1] / 2 + 0.36 * SIZE_M[1] * np.sin(angle) * (1 + 0.25 * np.cos(2 * angle))
    return np.column_stack([x, y])


def _trees(way: Array, rng: np.random.Generator) -> Array:
    """Plant trees (k, 3), x, y and radius m, apart from each other and from the way."""
    planted: list[Array] = []
    while len(planted) < TREES:
        tree = rng.uniform([0.0, 0.0], SIZE_M)
        off = np.linalg.norm(np.array([*way, *planted]) - tree, axis=1)
        if off[: len(way)].min() > 3.0 and off[len(way) :].min(initial=np.inf) > APART_M:
            planted.append(tree)
    return np.column_stack([np.array(planted), rng.uniform(*RADII_M, TREES)])


def follow(way: Array) -> Array:
    """Steer a car along a way (k, 2) m by pure pursuit: speed and steering (n, 2).

    The way starts where the car stands. It steers for the first point farther away than AHEAD_M.
    """
    car, pose, nearest, controls = Car(), np.zeros(3), 0, []
    while nearest < len(way) - 1 - AHEAD_M:
        window = way[nearest : nearest + 20]
        nearest += int(np.argmin(np.linalg.norm(window - pose[:2], axis=1)))
        ahead = np.linalg.norm(way[nearest:] - pose[:2], axis=1) > AHEAD_M
        target = way[nearest + int(np.argmax(ahead))] - pose[:2]
        turn = float(wrap(np.arctan2(target[1], target[0]) - pose[2]))
        steering = np.arctan(2 * car.wheelbase_m * np.sin(turn) / AHEAD_M)
        controls.append((SPEED_M_S, float(np.clip(steering, -SHARPEST_RAD, SHARPEST_RAD))))
        pose = car.move(pose, *controls[-1], STEP_S)
    return np.array(controls)


def _nearest(readings: Array, pose: Array, trees: Array) -> tuple[int, ...]:
    """Find the tree that is nearest to each reading (n, 2), seen from a pose (3,)."""
    points = place(pose, sighted_points(readings))
    off = np.linalg.norm(points[:, None] - trees[None, :, :2], axis=2)
    return tuple(int(number) for number in off.argmin(axis=1))


@dataclass(frozen=True, kw_only=True)
class RecordedPark:
    """Victoria Park as it was recorded."""

    log: Log
    gps_step: Ints  # (k,) step of the log
    gps: Array  # (k, 2) m


def read_victoria_park(folder: Path) -> RecordedPark:
    """Read the public files of Victoria Park [Guivant2000].

    They are Matlab files: `time` in ms with `speed` (m/s, of the left rear wheel) and `steering`
    (rad); `TLsr` with `LASER` (cm, 361 beams); `timeGps` with `Lo_m` and `La_m` (m). Raises
    InputError when one is missing.
    """
    from scipy.io import loadmat

    for name in FILES:
        if not (folder / name).is_file():
            raise InputError(f"{folder} holds no {name}", remedy="put the three files there")
    drive, laser, gps = (loadmat(folder / name) for name in FILES)
    car, time_s = Car(), drive["time"].ravel() / 1e3
    steering = drive["steering"].ravel()
    speed = car.axle_speed(drive["speed"].ravel(), steering)
    steps = np.diff(time_s)
    scans = {}
    for time, beams in zip(laser["TLsr"].ravel() / 1e3, laser["LASER"], strict=True):
        step = int(np.searchsorted(time_s, time)) - 1
        if 0 <= step < len(steps):
            ranges = np.minimum(beams.astype(float) / 100.0, REACH_M)
            scans[step] = Scan(readings=trunk_readings(find_trunks(ranges)))
    log = Log(
        car=car,
        noise=NOISE,
        step_s=steps,
        odometry=np.column_stack([speed, steering])[:-1],
        scans=scans,
    )
    at = np.searchsorted(time_s, gps["timeGps"].ravel() / 1e3) - 1
    return RecordedPark(
        log=log,
        gps_step=np.asarray(np.clip(at, 0, len(steps) - 1), dtype=np.int64),
        gps=np.column_stack([gps["Lo_m"].ravel(), gps["La_m"].ravel()]),
    )
