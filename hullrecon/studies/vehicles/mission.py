# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Missions of a simulated vehicle: where it truly was, and what its navigation measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.vehicles.motion import move
from hullrecon.studies.vehicles.sensors import Sigmas
from hullrecon.studies.vehicles.transforms import rotation, wrapped
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class Mission:
    """A vehicle's true states and measurements, one a step."""

    step_s: float
    truth: Array  # (n, 9) position, attitude, velocity
    floor_m: Array  # (n,) depth of the floor below it
    measured: Array  # (n, 8) attitude, velocity, depth, altitude

    @property
    def time_s(self) -> Array:
        """Time (n,) of each step."""
        return np.asarray(np.arange(len(self.truth)) * self.step_s, float)

    def dead_reckoned(self, by_pressure: bool = True) -> Array:
        """Integrate measured velocities along measured attitudes: positions (n, 3) m in the world.

        Depth is as pressure measures it, or integrated too.
        """
        steps = [
            rotation(measured[:3]) @ measured[3:6] * self.step_s  # attitude, velocity
            for measured in self.measured[:-1]
        ]
        position = self.truth[0, :3] + np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
        if by_pressure:
            position[:, 2] = self.measured[:, 6]
        return np.asarray(position)


@dataclass(frozen=True, kw_only=True)
class Manner:
    """How a vehicle goes."""

    speed_mps: float
    turn_rad_s: float  # at most
    reach_m: float  # of a waypoint
    wobble_rad: float  # of roll and pitch


def lawnmower(size_m: tuple[float, float], spacing_m: float, offset_m: float = 0.0) -> Array:
    """List the corners (n, 2) of legs along x, one each `spacing_m` of y."""
    legs = np.arange(offset_m, size_m[1] + 1e-9, spacing_m)
    ends = [[0.0, size_m[0]] if k % 2 == 0 else [size_m[0], 0.0] for k in range(len(legs))]
    return np.array([[x, y] for pair, y in zip(ends, legs, strict=True) for x in pair])


def drive(
    rng: np.random.Generator,
    waypoints: Array,
    depth_m: Array,
    floor_m: float,
    manner: Manner,
    step_s: float,
    sigmas: Sigmas,
) -> Mission:
    """Drive through waypoints and measure on the way.

    Parameters
    ----------
    rng
        Draws the noise of the measurements.
    waypoints
        (w, 2) m in the world.
    depth_m
        Depth (w,) wanted on the way to each.
    floor_m
        Mean depth of the floor, which oscillates by decimetres.
    manner
        How the vehicle goes.
    step_s
        Time between measurements.
    sigmas
        Noise of the sensors.
    """
    truth = _track(waypoints, depth_m, manner, step_s)
    n = len(truth)
    floor = floor_m + 0.2 * np.sin(truth[:, 0] / 40) * np.cos(truth[:, 1] / 55)
    # attitude, velocity, depth and altitude, as of `Sigmas.navigation`, which are variances
    exact = np.column_stack([truth[:, 3:9], truth[:, 2], floor - truth[:, 2]])
    measured = exact + np.sqrt(sigmas.navigation()) * rng.standard_normal((n, 8))
    return Mission(step_s=step_s, truth=truth, floor_m=floor, measured=measured)


def _track(waypoints: Array, depth_m: Array, manner: Manner, step_s: float) -> Array:
    """Steer from waypoint to waypoint: true states (n, 9) of the vehicle, one a step.

    Each follows from the one before by `move` but for the attitude and velocity that steering sets,
    so that constant velocity links positions exactly. Parameters are as of `drive`.
    """
    ahead = waypoints[1] - waypoints[0]
    state = np.r_[waypoints[0], depth_m[0], 0, 0, np.arctan2(ahead[1], ahead[0])]
    state = np.r_[state, manner.speed_mps, 0, 0]
    track, target = [state], 1
    most = manner.turn_rad_s * step_s
    while target < len(waypoints):
        state, _ = move(track[-1], step_s)
        to_go = waypoints[target] - state[:2]
        if np.hypot(*to_go) < manner.reach_m:
            target += 1
            continue
        wanted = np.arctan2(to_go[1], to_go[0])
        turn = np.clip(wrapped(wanted - state[5]), -most, most)
        k = len(track)
        state[3:5] = manner.wobble_rad * np.sin([0.05 * k, 0.083 * k])
        state[5] = wrapped(state[5] + turn)
        # In the world: at full speed ahead, and toward the wanted depth in about ten seconds
        rise = np.clip(0.1 * (depth_m[target] - state[2]), -0.3, 0.3)
        level = np.array([manner.speed_mps * np.cos(state[5]), manner.speed_mps * np.sin(state[5])])
        state[6:9] = rotation(state[3:6]).T @ np.r_[level, rise]
        track.append(state)
    return np.array(track)
