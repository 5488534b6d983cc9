# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare the signals of an IMU with each other, and its accelerations with the DVL's velocity.

- rates and attitude: the integral of an IMU's rates against the turn of its orientation, and over
  seconds about the vertical alone, as a compass swings slowly near a ship's steel,
- attitude and acceleration: what an accelerometer feels at rest points up, opposite to gravity,
- acceleration and DVL: the integral of the IMU's acceleration, less gravity, against the change of
  the DVL's velocity.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.streams.imu import GRAVITY_M_S2
from hullrecon.geometry.robust import robust_sigma
from hullrecon.geometry.rotations import compose, cross
from hullrecon.navigation.dead_reckoning.integral import Integral, integral
from hullrecon.navigation.sensors.motion_signals import acceleration_in_global, is_still
from hullrecon.navigation.sensors.smoothing import local_line
from hullrecon.navigation.suspects.comparisons.comparison import (
    LATE_S,
    LEAST_WINDOWS,
    SMOOTH_S,
    Comparison,
    Sensor,
    change_over,
    cut_windows,
)
from hullrecon.navigation.suspects.comparisons.dvl_track import Track
from hullrecon.records.clock import seconds
from hullrecon.records.sensors import ImuSamples

# length of the windows in which turns, turns of the heading and velocities are compared
TURNED_S, SWUNG_S, CHANGED_S = 1.0, 6.0, 1.0
RATE_BIAS_RAD_S, RATE_SHARE = 0.01, 0.05  # of a MEMS gyroscope: bias, and scale with axes
TURN_SIGMA_RAD = 0.003  # of a turn, at least
HEADING_SIGMA_RAD = np.radians(0.5)  # of a filter that draws the rates' heading to a compass
GRAVITY_SIGMA = 1.0  # m/s2, of a median over the dive
# m/s2 by a MEMS accelerometer's bias and by roll and pitch (half a degree); m/s by vibration of
# thrusters in a window; m between the IMU and the vehicle's origin
FELT_BIAS_M_S2, CHANGED_SIGMA_M_S, IMU_LEVER_M = 0.1, 0.02, 0.2
CHANGED_SHARE = 0.05  # of an accelerometer's scale and axes


def compare_rates(imu: ImuSamples) -> Comparison | None:
    """Compare the turns of an IMU's orientation with the integrals of its rates.

    None where too few windows have both.
    """
    known = np.isfinite(imu.angular_velocity).all(axis=1)
    t_ns, rates = imu.t_ns[known], imu.angular_velocity[known]
    windows = cut_windows(t_ns, TURNED_S)
    if len(windows) < LEAST_WINDOWS:
        return None
    t_s = seconds(t_ns, int(t_ns[0]))
    by_rates = change_over(integral(t_s, rates).total, windows)
    attitude = Rotation.from_quat(imu.quaternion[known])
    turn = compose(attitude[windows[:, 0]].inv(), attitude[windows[:, 1]]).as_rotvec()
    # White noise of the orientation, from the steps between readings that the rates do not explain,
    # or from the scatter of the turns themselves if that is less.
    step = (
        compose(attitude[:-1].inv(), attitude[1:]).as_rotvec()
        - 0.5 * (rates[1:] + rates[:-1]) * np.diff(t_s)[:, None]
    )
    white = min(robust_sigma(step.ravel()), robust_sigma(np.diff(turn, axis=0).ravel()))
    # by a time offset of LATE_S, where the rate changes within a window
    lag = np.abs(rates[windows[:, 1]] - rates[windows[:, 0]]) * LATE_S
    sigma = np.sqrt(white**2 + TURN_SIGMA_RAD**2 + (RATE_SHARE * turn) ** 2 + lag**2)
    lasts = (t_s[windows[:, 1]] - t_s[windows[:, 0]])[:, None, None]
    return Comparison(
        kind="turn",
        sensors=frozenset({Sensor.RATES, Sensor.ATTITUDE}),
        residual=(turn - by_rates).ravel(),
        sigma=sigma.ravel(),
        by_nuisance=(RATE_BIAS_RAD_S * lasts * np.eye(3)).reshape(-1, 3),
        first=by_rates.ravel(),
        second=turn.ravel(),
    )


def compare_heading(imu: ImuSamples) -> Comparison | None:
    """Compare the turns of an IMU's orientation about the vertical with those by its rates.

    Nuisances are the bias of the rates about the vertical, and their scale. None where too few
    windows have both.
    """
    known = np.isfinite(imu.angular_velocity).all(axis=1)
    t_ns, attitude = imu.t_ns[known], Rotation.from_quat(imu.quaternion[known])
    windows = cut_windows(t_ns, SWUNG_S)
    if len(windows) < LEAST_WINDOWS:
        return None
    t_s = seconds(t_ns, int(t_ns[0]))
    rate = attitude.apply(imu.angular_velocity[known])[:, 2]
    step = compose(attitude[1:], attitude[:-1].inv()).as_rotvec()[:, 2]
    by_rates = change_over(integral(t_s, rate).total, windows)
    turn = change_over(np.concatenate([[0.0], np.cumsum(step)]), windows)
    white = robust_sigma(step - 0.5 * (rate[1:] + rate[:-1]) * np.diff(t_s))
    lag = np.abs(change_over(rate, windows)) * LATE_S
    lasts = change_over(t_s, windows)
    return Comparison(
        kind="heading",
        sensors=frozenset({Sensor.RATES, Sensor.ATTITUDE}),
        residual=turn - by_rates,
        sigma=np.sqrt(white**2 + HEADING_SIGMA_RAD**2 + lag**2),
        by_nuisance=np.column_stack([RATE_BIAS_RAD_S * lasts, RATE_SHARE * by_rates]),
        first=by_rates,
        second=turn,
    )


def compare_gravity(imu: ImuSamples) -> Comparison | None:
    """Compare the median acceleration with that at rest, which is -g along z of `global`.

    None without accelerations, or where gravity was taken off.
    """
    _, acceleration = acceleration_in_global(imu)
    if not len(acceleration):
        return None
    median, at_rest = np.median(acceleration, axis=0), np.array([0.0, 0.0, -GRAVITY_M_S2])
    return Comparison(
        kind="gravity",
        sensors=frozenset({Sensor.ACCELERATION, Sensor.ATTITUDE}),
        residual=median - at_rest,
        sigma=np.full(3, GRAVITY_SIGMA),
        by_nuisance=np.zeros((3, 0)),
        first=median,
        second=at_rest,
    )


def compare_acceleration(acceleration: Integral, track: Track) -> Comparison | None:
    """Compare the change of the DVL's velocity with the integral of the IMU's accelerations.

    Nuisances are the bias of the accelerometer and a time offset. None where too few windows have
    both, or where there is hardly anything but gravity.

    acceleration: of the IMU in `global`, less gravity, with its integral, at seconds since the
    start of the track.
    """
    t_s = track.way.t_s
    windows = cut_windows(
        track.t_ns, CHANGED_S, (t_s >= acceleration.t_s[0]) & (t_s <= acceleration.t_s[-1])
    )
    if len(windows) < LEAST_WINDOWS:
        return None
    integrated = acceleration.at(t_s)
    # change of the velocity by the IMU, and of the DVL relative to the pressure sensor, as the
    # vehicle turns
    level, slope = local_line(t_s, np.hstack([integrated, track.lever]), t_s, SMOOTH_S)
    swept = slope[:, 3:]
    by_imu = change_over(level[:, :3], windows)
    by_dvl = change_over(local_line(t_s, track.way.signal - swept, t_s, SMOOTH_S)[0], windows)
    if is_still(by_imu, by_dvl):
        return None  # gravity alone, as of a filter that gives the vertical of its attitude
    late = LATE_S * change_over(slope[:, :3], windows)
    # an IMU that does not sit at the vehicle's origin moves as the vehicle turns
    turn = track.global_from_vehicle[windows[:, 0]].inv()
    spun = IMU_LEVER_M * (turn * track.global_from_vehicle[windows[:, 1]]).magnitude()
    lasts = np.asarray(change_over(t_s, windows))[:, None, None]
    biased = FELT_BIAS_M_S2 * lasts * track.global_from_vehicle[windows[:, 0]].as_matrix()
    sigma = np.hypot(CHANGED_SIGMA_M_S, spun)[:, None] * np.ones(3)
    return Comparison(
        kind="push",
        sensors=frozenset({Sensor.ACCELERATION, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY}),
        residual=(by_dvl - by_imu).ravel(),
        sigma=np.hypot(sigma, CHANGED_SHARE * by_imu).ravel(),
        by_nuisance=np.concatenate([biased.reshape(-1, 3), late.reshape(-1, 1)], axis=1),
        first=by_dvl.ravel(),
        second=by_imu.ravel(),
        by_turn=cross(np.array([0.0, 0.0, 1.0]), by_dvl).ravel(),
    )
