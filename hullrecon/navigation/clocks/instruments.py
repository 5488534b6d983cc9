# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The clocks of IMU and pressure sensor against the DVL's.

The DVL's ranges say how the instrument is turned to the hull, and the IMU how the vehicle turns:
the hull stands still at the right shift alone. The DVL's velocity along the vertical, summed, is
the depth that the pressure sensor measures.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import tray_poses
from hullrecon.navigation.clocks.time_shift import Disagreement
from hullrecon.navigation.dead_reckoning.integral import integral
from hullrecon.navigation.dead_reckoning.returns import mark_lost
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.servo import Servo
from hullrecon.navigation.sensors.smoothing import local_line, running_median
from hullrecon.records.clock import seconds
from hullrecon.records.sensors import DvlPings, PressureSamples
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

# between the three looks at the hull whose second difference shows how the vehicle turned
APART_S = 1.0
# between three depths: a mount that tilts the DVL adds a steady rate, which their second difference
# has not
SUNK_S = 2.0
LATE = 0.3  # of those: how much later the next ping may be
# in which errors go together: the hull's form, a wave; fewer do not tell their scatter
BLOCK_S, LEAST_BLOCKS = 10.0, 6
LEAST_ROWS, MOST_ROWS = 60, 5_000
NEIGHBOURS, AWAY_M = 9, 0.15  # pings whose median a range may leave by so much
LEAST_BEAMS = 3
SMOOTH_S = 0.3  # of the pressure
# the tray turns about this axis of the vehicle: along it its angle changes no direction
ACROSS = np.array([0.0, 1.0, 0.0])


def imu_beside_dvl(
    dvl: DvlPings, attitude: AttitudeHistory, servo: Servo, rig: Rig
) -> Disagreement | None:
    """Return how the IMU's attitude, looked up at the DVL's stamps and a shift, lets the hull turn;
    None where no pings have returns.

    Turns about the tray's own axis are left aside: its servo's play looks like a clock that is
    late.
    """
    t_ns, normal = hull_normals(dvl)
    if not len(t_ns):
        return None
    in_vehicle = _vehicle_from_dvl(servo, rig, t_ns).apply(normal)
    rows = _rows_apart(t_ns, APART_S)
    if not len(rows):
        return None
    used = np.unique(rows)
    of = np.searchsorted(used, rows)

    def residuals(shift_s: float) -> Array:
        at_ns = t_ns[used] + round(shift_s * 1e9)
        global_from_vehicle = attitude.rotation(at_ns)
        seen, across = (
            global_from_vehicle.apply(in_vehicle[used]),
            global_from_vehicle.apply(ACROSS),
        )
        seen[(at_ns < attitude.t_ns[0]) | (at_ns > attitude.t_ns[-1])] = np.nan
        bend = seen[of[:, 0]] - 2 * seen[of[:, 1]] + seen[of[:, 2]]
        return np.asarray((bend * across[of[:, 1]]).sum(axis=1, keepdims=True))

    return Disagreement(
        residuals=residuals, block=_blocks(t_ns[rows[:, 0]]), is_enough=_enough(t_ns, rows)
    )


def pressure_beside_dvl(
    dvl: DvlPings,
    attitude: AttitudeHistory,
    pressure: PressureSamples,
    servo: Servo,
    rig: Rig,
    imu_late_s: float | None = 0.0,
) -> Disagreement | None:
    """Return how the depth, looked up at the DVL's stamps and a shift, differs from what the DVL
    sank; None where no pings or too few readings are there.

    imu_late_s: how late the IMU is, by whose attitude the DVL's velocity is level or not, beside
    the DVL; None: as late as the pressure sensor.
    """
    known = np.isfinite(dvl.velocity).all(axis=1)
    read = np.isfinite(pressure.depth)
    t_ns, sounded_ns = dvl.t_ns[known], pressure.t_ns[read]
    if len(t_ns) < 2 or len(sounded_ns) < LEAST_ROWS:
        return None
    rows = _rows_apart(t_ns, SUNK_S)
    if not len(rows):
        return None
    used = np.unique(rows)
    of = np.searchsorted(used, rows)
    t_s, sounded_s = seconds(t_ns, int(t_ns[0])), seconds(sounded_ns, int(t_ns[0]))
    velocity = _vehicle_from_dvl(servo, rig, t_ns).apply(dvl.velocity[known])
    smooth = local_line(sounded_s, pressure.depth[read], sounded_s, SMOOTH_S)[0][:, 0]
    lever = (
        tray_poses(rig.tray_origin, servo.angle_at(t_ns)).apply(rig.tray_from_dvl.translation)
        - rig.pressure_origin
    )

    def sunk(shift_s: float) -> Array:
        """Return how far the pressure sensor had sunk at the pings used, by a DVL beside which the
        IMU is so late.
        """
        at_ns = t_ns + round(shift_s * 1e9)
        level = attitude.rotation(at_ns)
        instrument = integral(t_s, level.apply(velocity)[:, 2]).total
        found = np.asarray(instrument - level.apply(lever)[:, 2])
        found[(at_ns < attitude.t_ns[0]) | (at_ns > attitude.t_ns[-1])] = np.nan
        return found[used]

    known_sunk = None if imu_late_s is None else sunk(imu_late_s)

    def residuals(shift_s: float) -> Array:
        at_s = t_s[used] + shift_s
        depth = np.interp(at_s, sounded_s, smooth)
        depth[(at_s < sounded_s[0]) | (at_s > sounded_s[-1])] = np.nan
        apart = depth - (sunk(shift_s) if known_sunk is None else known_sunk)
        return np.asarray((apart[of[:, 0]] - 2 * apart[of[:, 1]] + apart[of[:, 2]])[:, None])

    return Disagreement(
        residuals=residuals, block=_blocks(t_ns[rows[:, 0]]), is_enough=_enough(t_ns, rows)
    )


def hull_normals(dvl: DvlPings) -> tuple[Ints, Array]:
    """Return the stamps (n,) of the pings whose returns lie about a plane's width apart, and the
    plane's unit normal (n, 3) in `dvl`, away from the instrument. Returns that leave the median of
    their beam's neighbours are left out.
    """
    ranges = mark_lost(dvl.ranges)
    if len(ranges) < NEIGHBOURS or ranges.shape[1] < LEAST_BEAMS:
        return np.zeros(0, np.int64), np.zeros((0, 3))
    with np.errstate(invalid="ignore"):
        fair = np.abs(ranges - running_median(ranges, NEIGHBOURS)) < AWAY_M
    enough = fair.sum(axis=1) >= LEAST_BEAMS
    fair, ends = fair[enough], (ranges[:, :, None] * dvl.beams)[enough]
    weight = fair[:, :, None].astype(float)
    ends = np.where(fair[:, :, None], ends, 0.0)
    middle = ends.sum(axis=1) / weight.sum(axis=1)
    from_middle = weight * (ends - middle[:, None])
    normal = np.linalg.eigh(np.einsum("nbi,nbj->nij", from_middle, from_middle))[1][:, :, 0]
    away = np.sign((normal * middle).sum(axis=1))
    return dvl.t_ns[enough], np.asarray(normal * away[:, None])


def _vehicle_from_dvl(servo: Servo, rig: Rig, t_ns: Ints) -> Rotation:
    """Return R_v_d (n) at times (n,)."""
    return tray_poses(rig.tray_origin, servo.angle_at(t_ns)).rotation * rig.tray_from_dvl.rotation


def _rows_apart(t_ns: Ints, apart_s: float) -> Ints:
    """Return rows (m, 3) of stamps: each one with those that follow it by so many seconds and by
    twice as many, where there are some; no more than MOST_ROWS, evenly chosen.
    """
    rows = [np.arange(len(t_ns))]
    near = np.ones(len(t_ns), bool)
    for times in (1, 2):
        wanted = t_ns + round(times * apart_s * 1e9)
        row = np.searchsorted(t_ns, wanted)
        near &= row < len(t_ns)
        row = np.minimum(row, len(t_ns) - 1)
        near &= t_ns[row] - wanted <= LATE * apart_s * 1e9
        rows.append(row)
    found = np.stack(rows, axis=1)[near]
    return found[:: 1 + len(found) // MOST_ROWS]


def _enough(t_ns: Ints, rows: Ints) -> bool:
    """Return whether rows of stamps are enough to tell a shift, and how sure it is."""
    return len(rows) >= LEAST_ROWS and len(np.unique(_blocks(t_ns[rows[:, 0]]))) >= LEAST_BLOCKS


def _blocks(t_ns: Ints) -> Ints:
    return np.asarray((t_ns - t_ns[0]) // round(BLOCK_S * 1e9), np.int64)
