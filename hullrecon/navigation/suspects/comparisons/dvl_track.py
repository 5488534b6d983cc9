# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The path and attitude of the DVL, against which the other sensors are compared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, interpolate, tray_poses
from hullrecon.geometry.rotations import compose, cross
from hullrecon.navigation.dead_reckoning.integral import Integral, integral
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.suspects.comparisons.comparison import LEAST_WINDOWS, TILT_RAD
from hullrecon.records.clock import seconds
from hullrecon.records.sensors import SensorRecords
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class Track:
    """The path and attitude of the DVL at the pings with a velocity."""

    rows: Ints  # (n,) rows of these pings among all pings
    t_ns: Ints  # (n,)
    global_from_dvl: Rotation  # (n,)
    global_from_vehicle: Rotation  # (n,)
    way: Integral  # (n, 3) m, path: the integral of the velocity in `global`
    lever: Array  # (n, 3) m, from pressure sensor to DVL in `global`

    @cached_property
    def sunk_by_tilt(self) -> Array:
        """Compute how much deeper (n, 3), m, the path would be if the DVL were tilted by TILT_RAD.

        The columns are for a tilt about each of its axes.
        """
        # A tilt about the axis a adds (R (a x v))_z = a . (v x r) to the velocity downwards. Here v
        # is the velocity in the DVL's axes, R is global_from_dvl, and r its last row.
        rotation = self.global_from_dvl.as_matrix()
        own = np.einsum("nij,ni->nj", rotation, self.way.signal)
        turned = integral(self.way.t_s, cross(own, rotation[:, 2])).total
        return np.asarray(TILT_RAD * turned)

    def with_velocity(self, velocity: Array) -> Track:
        """Replace the path by the integral of another velocity (n, 3), in the DVL's axes.

        The pings and their attitude stay, as under a hypothesis of the velocity alone.
        """
        way = integral(self.way.t_s, self.global_from_dvl.apply(velocity))
        return replace(self, way=way)


def track_of(records: SensorRecords, rig: Rig) -> Track | None:
    """Integrate the DVL's velocity in the axes of `global`.

    None without DVL or IMU, or where hardly any velocity was measured while the IMU was read.
    """
    dvl, imu = records.dvl, records.imu
    if dvl is None or imu is None or len(imu.t_ns) < 2:
        return None
    rows = rows_with_velocity(records)
    if len(rows) < LEAST_WINDOWS:
        return None
    t_ns = dvl.t_ns[rows]
    turned = Poses(imu.quaternion, np.zeros((len(imu.t_ns), 3)))  # without a position
    global_from_vehicle = interpolate(imu.t_ns, turned, t_ns).rotation
    tray = tray_poses(rig.tray_origin, servo(records.tray, int(t_ns[0])).angle_at(t_ns))
    global_from_tray = compose(global_from_vehicle, tray.rotation)
    global_from_dvl = compose(global_from_tray, rig.tray_from_dvl.rotation)
    velocity = global_from_dvl.apply(dvl.velocity[rows])
    dvl_origin = tray.apply(np.tile(rig.tray_from_dvl.translation, (len(t_ns), 1)))
    return Track(
        rows=rows,
        t_ns=t_ns,
        global_from_dvl=global_from_dvl,
        global_from_vehicle=global_from_vehicle,
        way=integral(seconds(t_ns, int(t_ns[0])), velocity),
        lever=np.asarray(global_from_vehicle.apply(dvl_origin - rig.pressure_origin)),
    )


def rows_with_velocity(records: SensorRecords) -> Ints:
    """List the rows of the pings that have a velocity and lie within the IMU's record."""
    dvl, imu = records.dvl, records.imu
    if dvl is None or imu is None:
        return np.zeros(0, np.int64)
    inside = (dvl.t_ns >= imu.t_ns[0]) & (dvl.t_ns <= imu.t_ns[-1])
    return np.flatnonzero(inside & np.isfinite(dvl.velocity).all(axis=1))
