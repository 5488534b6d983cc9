# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The simulator of [Aulinas2011 3.4.1]: landmarks in the plane, a car's track, its readings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.submaps.models import Car, observe
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class Noise:
    """Standard deviations of a reading, zero-mean and independent."""

    speed_m_s: float = 1.0  # as printed, p. 50
    steering_rad: float = np.radians(7.0)
    range_m: float = 0.10
    bearing_rad: float = np.radians(1.0)

    @property
    def odometry(self) -> Array:
        """Covariance (2, 2) of speed and steering."""
        return np.diag([self.speed_m_s**2, self.steering_rad**2])

    @property
    def laser(self) -> Array:
        """Covariance (2, 2) of range and bearing."""
        return np.diag([self.range_m**2, self.bearing_rad**2])


@dataclass(frozen=True, kw_only=True)
class Scan:
    """What the laser saw after a step of odometry."""

    readings: Array  # (m, 2) range m and bearing rad
    truth: tuple[int, ...] = ()  # number of the landmark; only for judging, empty where unknown


@dataclass(frozen=True, kw_only=True)
class Log:
    """A mission's readings."""

    car: Car
    noise: Noise  # as the filters believe it
    step_s: Array  # (n,) duration of each step
    odometry: Array  # (n, 2) speed m/s of the axle and steering rad during the step
    scans: dict[int, Scan]  # by the step that they follow
    # speed and steering (n, 2) where the odometry's covariance is taken, to second order; of none
    # at the readings, to first order, as printed
    covariance_at: Array | None = None


@dataclass(frozen=True, kw_only=True)
class World:
    """A scene with its true track."""

    landmarks: Array  # (k, 2) m
    track: Array  # (n + 1, 3) the laser's poses, the first one the origin of all maps
    controls: Array  # (n, 2) true speed and steering
    log: Log

    @property
    def length_m(self) -> float:
        """Length of the track."""
        return float(np.sum(np.linalg.norm(np.diff(self.track[:, :2], axis=0), axis=1)))


@dataclass(frozen=True, kw_only=True)
class Survey:
    """A lawnmower's track over a square of landmarks."""

    cells: int = 20  # of a side: 21 x 21 landmarks are the 441 of the thesis
    spacing_m: float = 5.0
    jitter_m: float = 1.25  # each landmark is off its grid by up to this, in x and in y
    leg_m: float = 90.0
    legs: int = 11
    leg_spacing_m: float = 9.0
    speed_m_s: float = 2.0
    step_s: float = 0.05
    steps_a_scan: int = 5
    view_m: float = 8.0  # range of the laser, all around
    blind_m: float = 2.0  # nearer than this nothing is seen: the car would run over it


def lawnmower_controls(survey: Survey) -> Array:
    """Make speed and steering (n, 2) of the track: legs, joined by half circles."""
    leg, half_circle = _leg(survey), _turn(survey, np.pi)
    parts = [leg]
    for number in range(survey.legs - 1):
        parts += [half_circle * (1.0 if number % 2 == 0 else -1.0), leg]
    controls = np.concatenate(parts)
    controls[:, 0] = survey.speed_m_s
    return controls


def simulate_survey(survey: Survey, noise: Noise, seed: int) -> World:
    """Simulate a survey of a field of landmarks. The map's origin is the track's first pose.

    A shift by one cell of an exact grid is a consistent answer to which landmark is which,
    therefore the landmarks are moved off it (`Survey.jitter_m`), which the thesis leaves open.
    """
    rng = np.random.default_rng(seed)
    line = np.arange(survey.cells + 1) * survey.spacing_m
    grid = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    landmarks = grid + rng.uniform(-survey.jitter_m, survey.jitter_m, grid.shape)
    side = survey.cells * survey.spacing_m
    start = np.array([(side - survey.leg_m) / 2, survey.leg_spacing_m / 2])
    controls = lawnmower_controls(survey)
    steps = np.full(len(controls), survey.step_s)
    return simulate(landmarks - start, controls, steps, noise, survey, rng)


def loop_controls(survey: Survey, laps: float) -> Array:
    """Make speed and steering (n, 2) of laps around a square, to the left."""
    controls = np.concatenate([_leg(survey), _turn(survey, np.pi / 2)] * round(4 * laps))
    controls[:, 0] = survey.speed_m_s
    return controls


def _leg(survey: Survey) -> Array:
    """Go straight on: steering (n, 2), the speed yet to be set."""
    return np.zeros((round(survey.leg_m / (survey.speed_m_s * survey.step_s)), 2))


def _turn(survey: Survey, angle_rad: float) -> Array:
    """Turn left on a circle that is as wide as legs are apart: steering (n, 2), as `_leg`."""
    step_m = survey.speed_m_s * survey.step_s
    steps = round(angle_rad * survey.leg_spacing_m / 2 / step_m)
    controls = np.zeros((steps, 2))
    controls[:, 1] = np.arctan(angle_rad * Car().wheelbase_m / (steps * step_m))
    return controls


def simulate_loop(survey: Survey, laps: float, noise: Noise, seed: int) -> World:
    """Simulate laps around a square of `survey.leg_m`, with landmarks along it."""
    rng = np.random.default_rng(seed)
    reach = survey.leg_m + survey.leg_spacing_m + 10.0
    line = np.arange(-10.0, reach, survey.spacing_m)
    grid = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    landmarks = grid + rng.uniform(-survey.jitter_m, survey.jitter_m, grid.shape)
    controls = loop_controls(survey, laps)
    steps = np.full(len(controls), survey.step_s)
    return simulate(landmarks, controls, steps, noise, survey, rng)


def simulate(
    landmarks: Array,
    controls: Array,
    step_s: Array,
    noise: Noise,
    survey: Survey,
    rng: np.random.Generator,
) -> World:
    """Drive among landmarks (k, 2) by true controls, and take readings with noise.

    Parameters
    ----------
    landmarks
        (k, 2) m, in the frame of the track's first pose.
    controls, step_s
        True speed and steering (n, 2), and duration (n,) of each step.
    noise
        Of odometry and laser.
    survey
        What the laser sees, and how many steps pass between scans.
    rng
        Draws the noise.
    """
    car = Car()
    track = np.zeros((len(controls) + 1, 3))
    scans = {}
    for step, (speed, steering) in enumerate(controls):
        track[step + 1] = car.move(track[step], speed, steering, step_s[step])
        if (step + 1) % survey.steps_a_scan == 0:
            scans[step] = _scan(track[step + 1], landmarks, noise, survey, rng)
    sigmas = [noise.speed_m_s, noise.steering_rad]
    odometry = controls + rng.standard_normal(controls.shape) * sigmas
    log = Log(car=car, noise=noise, step_s=step_s, odometry=odometry, scans=scans)
    return World(landmarks=landmarks, track=track, controls=controls, log=log)


def _scan(
    pose: Array, landmarks: Array, noise: Noise, survey: Survey, rng: np.random.Generator
) -> Scan:
    """Simulate a scan from a pose: ranges and bearings of the landmarks in view, with noise."""
    off = np.linalg.norm(landmarks - pose[:2], axis=1)
    seen = np.flatnonzero((off > survey.blind_m) & (off < survey.view_m))
    sigmas = [noise.range_m, noise.bearing_rad]
    readings = observe(pose, landmarks[seen]) + rng.standard_normal((len(seen), 2)) * sigmas
    return Scan(readings=readings, truth=tuple(int(number) for number in seen))


def dead_reckon(log: Log) -> Array:
    """Integrate the odometry alone: poses (n + 1, 3) in the frame of the first."""
    track = np.zeros((len(log.odometry) + 1, 3))
    for step, (speed, steering) in enumerate(log.odometry):
        track[step + 1] = log.car.move(track[step], speed, steering, log.step_s[step])
    return track
