# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Strapdown dead reckoning at the DVL's rate, with its derivatives by persistent errors.

See [Ozog2016 1.2] and docs/methods.md 2. The DVL measures the velocity of the instrument in its own
axes. The mount T_s_d, the tray's angle and the attitude turn it into a velocity in g, which is
integrated. The vehicle's position is that of the instrument minus the lever arm,
p_v = p_d - R_g_v r_v(theta). That equals the integral of `v_v = v_d - omega x r - r'`, with the
rotation of the tray, but needs no derivative of the attitude.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, tray_poses
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.navigation.dead_reckoning.integral import Integral, integral
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.servo import Servo
from hullrecon.navigation.sensors.smoothing import local_line
from hullrecon.navigation.sensors.velocity import Velocities
from hullrecon.records.clock import seconds
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

UP_DOWN = np.array([0.0, 0.0, 1.0])  # z of g
TILT_AXIS = np.array([0.0, 1.0, 0.0])  # the tray turns about y of the vehicle

SPEED_S = 0.3  # over which the path's derivative by a time offset of the DVL is smoothed

# Columns of the integrals: the path itself, the integral of the velocity times the time, and the
# derivatives of the path by the mount's rotation vector, the tray's angle, its backlash, and roll,
# pitch and heading.
PATH, MOMENT, MOUNT, TRAY, BACKLASH, TILT = 0, 1, slice(2, 5), 5, 6, slice(7, 10)


@dataclass(frozen=True, kw_only=True)
class Reckoning:
    """A path that can be evaluated at any time."""

    start_ns: int  # from which times count
    sums: Integral  # (n, 3, 10) in g, columns as above
    attitude: AttitudeHistory
    servo: Servo
    velocities: Velocities
    rig: Rig

    def at(self, t_ns: Ints) -> Instant:
        """Interpolate the vehicle, and what the derivatives of its path need, at times (n,).

        Beyond the ends attitude, tray and velocity are held at their last values.
        """
        theta = self.servo.angle_at(t_ns)
        rotation = self.attitude.rotation(t_ns)
        mounted = tray_poses(self.rig.tray_origin, theta)
        lever = mounted.apply(self.rig.tray_from_dvl.translation)
        lever_by_tray = np.cross(TILT_AXIS, lever - self.rig.tray_origin)
        return Instant(
            t_ns=t_ns,
            t_s=seconds(t_ns, self.start_ns),
            rotation=rotation,
            sums=self.sums.at(seconds(t_ns, self.start_ns)),
            tray=theta,
            direction=self.servo.direction_at(t_ns),
            lever=lever,
            lever_by_tray=lever_by_tray,
        )

    def path_by_delay(self, t_ns: Ints) -> Array:
        """Compute how far the path (n, 3) moves for each second that the DVL is late, m/s in g.

        The velocities of a DVL whose stamps are late are turned by a later attitude. To first order
        that moves the path by minus the integral of the change of the velocity in the DVL's own
        axes, turned into g (docs/methods.md, *Clocks*).
        """
        own, at_ns = self.velocities.velocity, self.velocities.t_ns
        tray = tray_poses(self.rig.tray_origin, self.servo.angle_at(at_ns)).rotation
        turn = self.attitude.rotation(at_ns) * tray * self.rig.tray_from_dvl.rotation
        step = np.diff(own, axis=0)
        # turned by the mean of the rotations before and after the change
        change = 0.5 * (turn[:-1].apply(step) + turn[1:].apply(step))
        total = np.concatenate([np.zeros((1, 3)), np.cumsum(change, axis=0)])
        at_s, t_s = (seconds(stamps, self.start_ns) for stamps in (at_ns, t_ns))
        return -local_line(at_s, total, t_s, SPEED_S)[0]


@dataclass(frozen=True, kw_only=True)
class Instant:
    """The vehicle at n instants, with what the derivatives of its path need."""

    t_ns: Ints
    t_s: Array  # since the start
    rotation: Rotation  # global_from_vehicle
    sums: Array  # (n, 3, 10) in g: the path and its derivatives, columns PATH to TILT
    tray: Array  # (n,) rad
    direction: Array  # (n,) +1 or -1: in which the tray last moved
    lever: Array  # (n, 3) m, position of the DVL in the vehicle's frame
    lever_by_tray: Array  # (n, 3) m/rad, its derivative by the tray's angle

    @property
    def instrument(self) -> Array:
        """Position (n, 3) m of the DVL in g, from the start of the path."""
        return self.sums[:, :, PATH]

    def poses(self) -> Poses:
        """Compute T_g_v (n) by DVL and IMU alone, the DVL starting at the origin."""
        return Poses(self.rotation.as_quat(), self.instrument - self.rotation.apply(self.lever))


def reckon(
    velocities: Velocities,
    attitude: AttitudeHistory,
    servo: Servo,
    rig: Rig,
    start_ns: int | None = None,
) -> Reckoning:
    """Integrate at least two velocities to a path, with its derivatives by persistent errors.

    Parameters
    ----------
    velocities, attitude, servo
        What is integrated, and what turns it into g: the attitude, and the tray's angle.
    rig
        The mount of the DVL on the tray, and the tray's origin.
    start_ns
        Instant from which times and the path count. None: that of the first velocity.
    """
    t_ns = velocities.t_ns
    start = int(t_ns[0]) if start_ns is None else start_ns
    t = seconds(t_ns, start)
    global_from_vehicle = attitude.rotation(t_ns).as_matrix()
    vehicle_from_tray = tray_poses(rig.tray_origin, servo.angle_at(t_ns)).rotation.as_matrix()
    vehicle_from_dvl = vehicle_from_tray @ rig.tray_from_dvl.rotation.as_matrix()[0]
    v_v = np.einsum("nij,nj->ni", vehicle_from_dvl, velocities.velocity)
    v_g = np.einsum("nij,nj->ni", global_from_vehicle, v_v)
    # Derivatives of the velocity in g, which are integrated as it is: a small turn w of the mount
    # adds R (w x v) = -R [v]x w.
    by_mount = -global_from_vehicle @ vehicle_from_dvl @ cross_matrix(velocities.velocity)
    by_tray = np.einsum("nij,nj->ni", global_from_vehicle, np.cross(TILT_AXIS, v_v))
    by_backlash = by_tray * servo.direction_at(t_ns)[:, None]
    by_tilt = -global_from_vehicle @ cross_matrix(v_v)
    # In the order of the columns PATH to TILT
    columns = [
        v_g[..., None],
        (v_g * t[:, None])[..., None],
        by_mount,
        by_tray[..., None],
        by_backlash[..., None],
        by_tilt,
    ]
    return Reckoning(
        start_ns=start,
        sums=integral(t, np.concatenate(columns, axis=2)),
        attitude=attitude,
        servo=servo,
        velocities=velocities,
        rig=rig,
    )
