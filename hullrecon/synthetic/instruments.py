# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What DVL, IMU, pressure cell, USBL and servos report, with the errors they have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.synthetic.built_hull import BuiltHull
from hullrecon.synthetic.options import DiveSpec
from hullrecon.synthetic.vehicle import BEAMS, TRANSPONDER, TRAY_ORIGIN, Motion, TrueRig, ticks
from hullrecon.typing import Array

ATMOSPHERE_PA, DENSITY, GRAVITY = 101325.0, 1025.0, 9.81  # kg/m3, m/s2
VELOCITY_SIGMA, RANGE_SIGMA = 0.003, 0.01  # m/s, m
LOST_SHARE, WILD_SHARE = 0.02, 0.005  # of the DVL's ranges: missing ones, outliers
ROLL_PITCH_SIGMA, HEADING_SIGMA = np.radians(0.1), np.radians(0.05)
GYRO_SIGMA, ACCELERATION_SIGMA = 0.002, 0.03  # rad/s, m/s2
DEPTH_SIGMA = 0.02  # m
DVL_HZ, IMU_HZ, PRESSURE_HZ, JOINTS_HZ = 5.0, 25.0, 10.0, 10.0
LEAST_POSITION_SIGMA_M = 0.001  # in dive.toml, for positions simulated without noise


@dataclass(frozen=True, kw_only=True)
class Dvl:
    """The readings of the DVL."""

    t_s: Array
    velocity: Array  # (n, 3) in its own frame, m/s
    ranges: Array  # (n, 4) m, NaN where lost


@dataclass(frozen=True, kw_only=True)
class Imu:
    """The readings of the IMU."""

    t_s: Array
    quaternion: Array  # (n, 4) global_from_vehicle
    rates: Array  # (n, 3) in the vehicle, rad/s
    force: Array  # (n, 3) specific force in the vehicle, m/s2


@dataclass(frozen=True)
class Series:
    """Values (n,) or (n, k) at times (n,)."""

    t_s: Array
    value: Array


NO_POSITIONS = Series(np.zeros(0), np.zeros((0, 3)))


def dvl(spec: DiveSpec, motion: Motion, rig: TrueRig, hull: BuiltHull) -> Dvl:
    """Simulate the DVL: velocity over ground with noise and scale error, and ranges to the hull."""
    random = spec.random("dvl")
    t = ticks(motion, DVL_HZ, random)
    at = motion.on_tray(t, rig.tray_from_dvl, TRAY_ORIGIN)
    # The DVL's own velocity, lever arm and tray included, is a central difference over 80 ms.
    ahead, behind = (
        motion.on_tray(t + dt, rig.tray_from_dvl, TRAY_ORIGIN).translation for dt in (0.04, -0.04)
    )
    true = at.rotation.inv().apply((ahead - behind) / 0.08)
    velocity = true * (1 + spec.errors.dvl_scale_error) + VELOCITY_SIGMA * random.standard_normal(
        true.shape
    )
    return Dvl(t_s=t, velocity=velocity, ranges=_ranges(random, motion.in_hull(at), hull))


def imu(spec: DiveSpec, motion: Motion) -> Imu:
    """Simulate the IMU: attitude, angular rates and specific force.

    Roll and pitch have a constant bias and noise, the heading a drift, a random walk and noise.
    """
    from scipy.spatial.transform import Rotation

    random = spec.random("imu")
    t = ticks(motion, IMU_HZ, random, first_s=0.06)
    n = len(t)
    level = ROLL_PITCH_SIGMA * (random.standard_normal(2) + 0.3 * random.standard_normal((n, 2)))
    # A random walk whose sigma reaches HEADING_SIGMA in a minute of readings
    walk = HEADING_SIGMA * np.cumsum(random.standard_normal(n)) * np.sqrt(1 / IMU_HZ / 60)
    drift = np.radians(spec.errors.heading_drift_deg_per_hour) / 3600
    heading = drift * t + walk + 0.5 * HEADING_SIGMA * random.standard_normal(n)
    error = Rotation.from_euler("xyz", np.column_stack([level, np.zeros(n)]))
    turn = Rotation.from_euler("z", heading[:, None]) * motion.vehicle(t).rotation * error
    down = np.array([0.0, 0.0, GRAVITY])
    force = motion.vehicle(t).rotation.inv().apply(motion.acceleration(t) - down)
    rates = (
        motion.rates(t)
        + 0.0005 * random.standard_normal(3)
        + GYRO_SIGMA * random.standard_normal((n, 3))
    )
    felt = force + ACCELERATION_SIGMA * random.standard_normal((n, 3))
    return Imu(t_s=t, quaternion=turn.as_quat(), rates=rates, force=felt)


def pressure(spec: DiveSpec, motion: Motion) -> Series:
    """Simulate the pressure sensor: absolute, Pa, at the vehicle's origin.

    Its bias is 3 cm, of either sign.
    """
    random = spec.random("pressure")
    t = ticks(motion, PRESSURE_HZ, random, first_s=0.12)
    bias = 0.03 * random.choice([-1.0, 1.0])
    depth = (
        motion.vehicle(t).translation[:, 2] + bias + DEPTH_SIGMA * random.standard_normal(len(t))
    )
    return Series(t, ATMOSPHERE_PA + DENSITY * GRAVITY * depth)


def positions(spec: DiveSpec, motion: Motion) -> Series:
    """Simulate position fixes by USBL: east, north, up (n, 3), m, with noise and outliers.

    Heading and origin of the local frame are drawn at random.
    """
    if spec.positions.every_s is None:
        return NO_POSITIONS
    random = spec.random("positions")
    heading, origin = random.uniform(-np.pi, np.pi), random.uniform(-200, 200, 2)
    t = ticks(motion, 1 / spec.positions.every_s, random, first_s=0.7)
    x, y, z = motion.vehicle(t).apply(np.array(TRANSPONDER)).T
    north = origin[0] + x * np.cos(heading) - y * np.sin(heading)
    east = origin[1] + x * np.sin(heading) + y * np.cos(heading)
    at = np.stack([east, north, -z], axis=1) + spec.positions.sigma_m * random.standard_normal(
        (len(t), 3)
    )
    wild = random.random(len(t)) < spec.positions.outlier_share
    return Series(t, np.where(wild[:, None], at + random.uniform(-30, 30, at.shape), at))


def joints(spec: DiveSpec, motion: Motion) -> Series:
    """Simulate the encoders of the tray and the sonar's servo: angles (n, 2) with noise, rad."""
    random = spec.random("joints")
    t = ticks(motion, JOINTS_HZ, random, first_s=0.09)
    series = (motion.encoder, motion.sonar_tray)
    reported = np.stack([motion.angle(s, t) for s in series], axis=1)
    return Series(
        t,
        reported + np.radians(spec.errors.servo_sigma_deg) * random.standard_normal(reported.shape),
    )


def _ranges(random: np.random.Generator, hull_from_dvl: Poses, hull: BuiltHull) -> Array:
    """Simulate ranges (n, b) m from n poses to the hull, with noise, outliers and NaN for lost."""
    n, b = len(hull_from_dvl), len(BEAMS)
    direction = np.stack(
        [hull_from_dvl.rotation.apply(np.tile(beam, (n, 1))) for beam in BEAMS], axis=1
    )
    ranges = hull.ranges(hull_from_dvl.translation, direction)
    ranges += RANGE_SIGMA * random.standard_normal((n, b))
    wild, lost = random.random((n, b)) < WILD_SHARE, random.random((n, b)) < LOST_SHARE
    ranges = np.where(wild, ranges * random.uniform(0.3, 2.5, (n, b)), ranges)
    return np.where(lost, np.nan, ranges)
