# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare the clocks of pressure sensor and IMU with that of the DVL.

- pressure and DVL: the depth against the integral of the DVL's vertical velocity,
- attitude and DVL: the plane through a ping's returns, turned into the global frame, stands still,
- acceleration and DVL: the change of the DVL's velocity against the integral of the IMU's
  acceleration.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import tray_poses
from hullrecon.navigation.clocks.comparisons.comparison import (
    TRAY_AXIS,
    ClockComparison,
    ClockedSensor,
    Offsets,
    fast_rotation,
    shift_between_ns,
)
from hullrecon.navigation.dead_reckoning.integral import integral
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.motion_signals import (
    hull_normals,
    integrate_acceleration,
    is_still,
)
from hullrecon.navigation.sensors.servo import Servo
from hullrecon.navigation.sensors.smoothing import local_line
from hullrecon.records.clock import NS, seconds
from hullrecon.records.sensors import DvlPings, ImuSamples, PressureSamples
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

# Sigmas of the systematic error of each comparison's offset, s. The largest offsets found on 56
# simulated dives with right clocks are 0.16 s of pressure and DVL and 0.21 of attitude and DVL, and
# on seven dives 0.06 of accelerations and DVL.
DEPTH_S, HULL_S, ACCELERATION_S = 0.05, 0.04, 0.04
LEAST_DEPTH_BLOCKS = 4  # so few determine a sigma badly, but most of the sigma is DEPTH_S
TURNED_S = 1.0  # between three normals of the hull, whose second difference is the residual
SUNK_S = 2.0  # between three depths; second differences cancel the steady rate of a wrong mount
CHANGED_S = 0.8  # between three velocities; second differences cancel gravity and a bias
CHANGED_BLOCK_S = 3.0  # within which their errors are common, those of roll and pitch
LATE = 0.3  # by which the next ping may come after the wanted time, as a share of the spacing
# time within which errors are common, and how many such blocks and rows a comparison has to have;
# more rows than the last are thinned out
BLOCK_S, LEAST_BLOCKS, LEAST_ROWS, MOST_ROWS = 10.0, 6, 60, 5_000
SMOOTH_S = 0.3  # sigma of the weights by which the pressure is smoothed


def compare_depth(
    dvl: DvlPings,
    attitude: AttitudeHistory,
    pressure: PressureSamples,
    servo: Servo,
    rig: Rig,
) -> ClockComparison | None:
    """Compare pressure sensor and DVL by the depth.

    The depth by pressure is held against the integral of the DVL's vertical velocity. The attitude
    that levels the velocity is looked up with the IMU's offset. None without three pings that lie
    SUNK_S apart, or with fewer than LEAST_ROWS pressure readings.

    Residuals are second differences over such three pings, so that a bias of the depth and a steady
    rate, as by a wrong mount, cancel.
    """
    known, read = np.isfinite(dvl.velocity).all(axis=1), np.isfinite(pressure.depth)
    t_ns, read_ns = dvl.t_ns[known], pressure.t_ns[read]
    triples = _triples_apart(t_ns, SUNK_S)
    if not len(triples) or len(read_ns) < LEAST_ROWS:
        return None
    t_s, read_s = seconds(t_ns, int(t_ns[0])), seconds(read_ns, int(t_ns[0]))
    velocity = _vehicle_from_dvl(servo, rig, t_ns).apply(dvl.velocity[known])
    smooth = local_line(read_s, pressure.depth[read], read_s, SMOOTH_S)[0][:, 0]
    dvl_origin = tray_poses(rig.tray_origin, servo.angle_at(t_ns)).apply(
        rig.tray_from_dvl.translation
    )
    lever = dvl_origin - rig.pressure_origin
    attitude_at = fast_rotation(attitude)

    @lru_cache(maxsize=8)
    def sunk(shift_ns: int) -> Array:
        """Integrate how far the pressure sensor sank (n,), m, by DVL and an attitude shifted so."""
        at_ns = t_ns + shift_ns
        level = attitude_at(at_ns)
        found = integral(t_s, level.apply(velocity)[:, 2]).total - level.apply(lever)[:, 2]
        found[(at_ns < attitude.t_ns[0]) | (at_ns > attitude.t_ns[-1])] = np.nan
        return np.asarray(found)

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the second difference (n, 1), m, of what the two depths differ by.

        NaN where pressure or attitude were not read at one of the three pings.
        """
        at_s = t_s + shift_between_ns(offsets, ClockedSensor.PRESSURE, ClockedSensor.DVL) / NS
        depth = np.interp(at_s, read_s, smooth)
        depth[(at_s < read_s[0]) | (at_s > read_s[-1])] = np.nan
        apart = depth - sunk(shift_between_ns(offsets, ClockedSensor.IMU, ClockedSensor.DVL))
        return _second_difference(apart[:, None], triples[rows])

    found = _compare_with_dvl(t_ns, triples, ClockedSensor.PRESSURE, DEPTH_S, evaluate)
    return replace(found, least_blocks=LEAST_DEPTH_BLOCKS)


def compare_hull_turns(
    dvl: DvlPings, attitude: AttitudeHistory, servo: Servo, rig: Rig
) -> ClockComparison | None:
    """Compare attitude and DVL by the apparent turns of the hull, which does not move.

    The normal of the hull is that of a plane through a ping's returns. Turned into the global frame
    with an attitude of the right time, it stands still or turns evenly. None without three such
    pings that lie TURNED_S apart.
    """
    t_ns, normal = hull_normals(dvl)
    triples = _triples_apart(t_ns, TURNED_S)
    if not len(triples):
        return None
    used, of_used = np.unique(triples, return_inverse=True)
    used_ns, of_used = t_ns[used], of_used.reshape(-1, 3)
    in_vehicle = _vehicle_from_dvl(servo, rig, used_ns).apply(normal[used])
    attitude_at = fast_rotation(attitude)

    @lru_cache(maxsize=8)
    def turned(shift_ns: int) -> tuple[Array, Array]:
        """Turn the normals and the tray axis (n, 3) into `global`, by an attitude shifted so."""
        at_ns = used_ns + shift_ns
        turn = attitude_at(at_ns).as_matrix()
        seen, axis = np.einsum("nij,nj->ni", turn, in_vehicle), turn @ TRAY_AXIS
        seen[(at_ns < attitude.t_ns[0]) | (at_ns > attitude.t_ns[-1])] = np.nan
        return seen, axis

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the second difference (n, 1) of the normals in `global` along the tray axis.

        A servo that is off turns the normals across this axis, so it does not count.
        """
        of = of_used[rows]
        seen, axis = turned(shift_between_ns(offsets, ClockedSensor.IMU, ClockedSensor.DVL))
        # the normal of a curved hull turns evenly as the vehicle passes, which cancels
        bend = _second_difference(seen, of)
        return np.asarray((bend * axis[of[:, 1]]).sum(axis=1, keepdims=True))

    return _compare_with_dvl(t_ns, triples, ClockedSensor.IMU, HULL_S, evaluate)


def compare_accelerations(
    dvl: DvlPings, imu: ImuSamples, attitude: AttitudeHistory, servo: Servo, rig: Rig
) -> ClockComparison | None:
    """Compare IMU and DVL by the change of velocity, with the integral of the acceleration.

    Residuals are second differences of the velocity over three pings, in which a wrong gravity and
    a constant bias of the IMU cancel. None without three pings that lie CHANGED_S apart, without
    accelerations that hold gravity, or where these hold hardly anything else.
    """
    known = np.isfinite(dvl.velocity).all(axis=1)
    t_ns = dvl.t_ns[known]
    triples = _triples_apart(t_ns, CHANGED_S)
    integrated = integrate_acceleration(imu, int(t_ns[0])) if len(triples) else None
    if integrated is None:
        return None
    t_s, imu_s = seconds(t_ns, int(t_ns[0])), integrated.t_s
    velocity = _vehicle_from_dvl(servo, rig, t_ns).apply(dvl.velocity[known])
    lever = tray_poses(rig.tray_origin, servo.angle_at(t_ns)).apply(rig.tray_from_dvl.translation)
    attitude_at = fast_rotation(attitude)

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the second difference (n, 3), m/s, of what the two velocities differ by.

        NaN where the IMU gave no acceleration at one of the three pings.
        """
        shift_ns = shift_between_ns(offsets, ClockedSensor.IMU, ClockedSensor.DVL)
        at_ns, at_s = t_ns + shift_ns, t_s + shift_ns / NS
        level = attitude_at(at_ns)
        # velocity of the DVL relative to the vehicle's origin, as the vehicle turns
        swept = np.gradient(level.apply(lever), t_s, axis=0)
        apart = level.apply(velocity) - swept - integrated.at(at_s)
        apart[(at_s < imu_s[0]) | (at_s > imu_s[-1])] = np.nan
        return _second_difference(apart, triples[rows])

    moved = attitude_at(t_ns).apply(velocity)
    if is_still(*(_second_difference(each, triples) for each in (integrated.at(t_s), moved))):
        return None  # gravity alone, as of a filter that gives the vertical of its attitude
    found = _compare_with_dvl(t_ns, triples, ClockedSensor.IMU, ACCELERATION_S, evaluate)
    block = (found.begin_ns - t_ns[0]) // round(CHANGED_BLOCK_S * NS)
    return replace(found, block=np.asarray(block, np.int64))


def _compare_with_dvl(
    t_ns: Ints,
    triples: Ints,
    first: ClockedSensor,
    systematic_s: float,
    evaluate: Callable[[Offsets, Ints], Array],
) -> ClockComparison:
    """Make a comparison of a sensor with the DVL, a row for each triple of pings.

    Parameters
    ----------
    t_ns, triples
        Stamps of the pings, and rows (m, 3) of three each.
    first
        The sensor that is compared with the DVL.
    systematic_s
        Sigma of the offset's systematic error.
    evaluate
        Computes the residuals of rows at given offsets.
    """
    begin_ns = t_ns[triples[:, 0]]
    return ClockComparison(
        first=first,
        second=ClockedSensor.DVL,
        systematic_s=systematic_s,
        begin_ns=begin_ns,
        end_ns=t_ns[triples[:, 2]],
        block=np.asarray((begin_ns - t_ns[0]) // round(BLOCK_S * NS), np.int64),
        evaluate=evaluate,
        rows=np.arange(len(triples)),
        least_rows=LEAST_ROWS,
        least_blocks=LEAST_BLOCKS,
    )


def _second_difference(values: Array, triples: Ints) -> Array:
    """Compute first - 2 middle + last (m, k) of values (n, k) at triples of rows (m, 3).

    A constant bias and a steady drift cancel in it.
    """
    first, middle, last = (values.take(rows, axis=0) for rows in triples.T)
    return np.asarray(first - 2 * middle + last)


def _vehicle_from_dvl(servo: Servo, rig: Rig, t_ns: Ints) -> Rotation:
    return tray_poses(rig.tray_origin, servo.angle_at(t_ns)).rotation * rig.tray_from_dvl.rotation


def _triples_apart(t_ns: Ints, apart_s: float) -> Ints:
    """List the rows of three pings each that lie about apart_s from one to the next.

    Of a quantity at three such pings the second difference is formed, in which a constant bias and
    a steady drift cancel. The second and third ping are the first ones at or after the wanted time.
    A triple is dropped where one of them comes later than that by more than LATE * apart_s, as
    after an outage.

    Parameters
    ----------
    t_ns
        Times (n,) of the pings, in order.
    apart_s
        From the first to the second, and from the second to the third.

    Returns
    -------
    Ints
        Rows (m, 3) of `t_ns`, thinned evenly to about MOST_ROWS. (0, 3) where there are none.
    """
    rows = [np.arange(len(t_ns))]
    near = np.ones(len(t_ns), bool)  # pings whose second and third are not late
    for times in (1, 2):
        wanted = t_ns + round(times * apart_s * NS)
        row = np.searchsorted(t_ns, wanted)
        near &= row < len(t_ns)
        row = np.minimum(row, len(t_ns) - 1)
        near &= t_ns[row] - wanted <= LATE * apart_s * NS
        rows.append(row)
    found = np.stack(rows, axis=1)[near]
    return found[:: 1 + len(found) // MOST_ROWS]
