# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compute how the tray moves at given times from readings of DVL and IMU, without a path."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.navigation.sensors.servo import servo
from hullrecon.records.clock import seconds
from hullrecon.records.sensors import DvlPings, ImuSamples, JointSamples
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

NEAR_S = 1.0  # readings on either side have to be as near
# Time over which the tray's motion is averaged: a vehicle keeps its speed for so long, and noise of
# an encoder or an attitude then stays below the motion within an exposure of a camera.
SPAN_S = 0.2


def tray_motion(
    dvl: DvlPings, imu: ImuSamples, tray: JointSamples | None, rig: Rig, t_ns: Ints
) -> Array:
    """Compute the velocity of the tray's origin, m/s, and the tray's angular rate, rad/s.

    They are (n, 6), in the tray's own axes.

    The stereo rig is checked with it before there is a path: a delay of one camera shows as the
    motion within that time. NaN where DVL or IMU were not read within NEAR_S on both sides.

    tray: the servo's readings. Without any, the tray is taken to stand at zero. t_ns (n,): times of
    the result.
    """
    half_ns = round(0.5e9 * SPAN_S)
    joint = servo(tray, int(dvl.t_ns[0]))
    angle = [joint.angle_at(t_ns + step) for step in (-half_ns, half_ns)]
    tray_from_vehicle = Rotation.from_rotvec(np.outer(-0.5 * (angle[0] + angle[1]), [0, 1.0, 0]))
    rate = tray_from_vehicle.apply(_mean_around(imu.t_ns, imu.angular_velocity, t_ns))
    rate[:, 1] += (angle[1] - angle[0]) / SPAN_S  # the servo turns the tray about y
    # from the DVL to the tray's origin: the tray's turn moves the DVL about it
    velocity = rig.tray_from_dvl.rotation.apply(_mean_around(dvl.t_ns, dvl.velocity, t_ns))
    velocity -= np.cross(rate, rig.tray_from_dvl.translation)
    return np.hstack([velocity, rate])


def _mean_around(read_ns: Ints, values: Array, t_ns: Ints) -> Array:
    """Interpolate the values (m, 3) of readings at times t_ns (n,), averaged over SPAN_S.

    NaN where the reading before or the one after is not within NEAR_S.
    """
    known = np.isfinite(values).all(axis=1)
    if known.sum() < 2:
        return np.full((len(t_ns), 3), np.nan)
    read_s, at_s = seconds(read_ns[known], int(t_ns[0])), seconds(t_ns, int(t_ns[0]))
    around_s = at_s[:, None] + SPAN_S * np.linspace(-0.5, 0.5, 5)
    mean = np.stack(
        [np.interp(around_s, read_s, column).mean(axis=1) for column in values[known].T], axis=1
    )
    after = np.clip(np.searchsorted(read_s, at_s), 1, len(read_s) - 1)
    apart_s = np.maximum(np.abs(read_s[after] - at_s), np.abs(read_s[after - 1] - at_s))
    mean[apart_s > NEAR_S] = np.nan
    return mean
