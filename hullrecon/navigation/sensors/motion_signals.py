# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Signals of one sensor that show the vehicle's motion, by which sensors are compared."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.streams.imu import GRAVITY_M_S2, is_without_gravity
from hullrecon.navigation.dead_reckoning.integral import Integral, integral
from hullrecon.navigation.sensors.smoothing import running_median
from hullrecon.records.clock import seconds
from hullrecon.records.sensors import DvlPings, ImuSamples
from hullrecon.typing import Array, Ints

STILL = 0.1  # of the motion that others measure; a signal that moves by less has no information
NEIGHBOURS, JUMP_M = 9, 0.15  # pings of a running median, and how far a range may be from it
LEAST_BEAMS = 3  # of a ping, to fit a plane


def hull_normals(dvl: DvlPings) -> tuple[Ints, Array]:
    """Fit a plane to each ping's returns, without outliers from the running median of their beam.

    Empty with fewer than NEIGHBOURS pings or LEAST_BEAMS beams.

    Returns
    -------
    tuple
        Stamps (n,) of the pings with enough returns, and the planes' unit normals (n, 3) in the
        DVL's frame, away from the instrument.
    """
    ranges = dvl.ranges
    if len(ranges) < NEIGHBOURS or ranges.shape[1] < LEAST_BEAMS:
        return np.zeros(0, np.int64), np.zeros((0, 3))
    with np.errstate(invalid="ignore"):
        fair = np.abs(ranges - running_median(ranges, NEIGHBOURS)) < JUMP_M
    enough = fair.sum(axis=1) >= LEAST_BEAMS
    fair, ends = fair[enough], (ranges[:, :, None] * dvl.beams)[enough]
    weight = fair[:, :, None].astype(float)
    ends = np.where(fair[:, :, None], ends, 0.0)
    middle = ends.sum(axis=1) / weight.sum(axis=1)
    from_middle = weight * (ends - middle[:, None])
    # the direction in which the ends scatter least
    normal = np.linalg.eigh(np.einsum("nbi,nbj->nij", from_middle, from_middle))[1][:, :, 0]
    away = np.sign((normal * middle).sum(axis=1))
    return dvl.t_ns[enough], np.asarray(normal * away[:, None])


def acceleration_in_global(imu: ImuSamples) -> tuple[Ints, Array]:
    """Turn accelerations, as an accelerometer feels them, into `global`: stamps (n,), m/s2 (n, 3).

    At rest it feels the force that holds it up, opposite to gravity. Empty without accelerations,
    or where gravity was taken off.
    """
    acceleration = Rotation.from_quat(imu.quaternion).apply(imu.acceleration)
    known = np.isfinite(acceleration).all(axis=1)
    t_ns, acceleration = imu.t_ns[known], acceleration[known]
    if not len(acceleration) or is_without_gravity(acceleration):
        return t_ns[:0], acceleration[:0]
    return t_ns, acceleration


def integrate_acceleration(imu: ImuSamples, start_ns: int) -> Integral | None:
    """Integrate an IMU's accelerations, less gravity, to its velocity in `global` up to a constant.

    Times are seconds since start_ns. None where `acceleration_in_global` has fewer than two.
    """
    t_ns, acceleration = acceleration_in_global(imu)
    if len(acceleration) < 2:
        return None
    return integral(seconds(t_ns, start_ns), acceleration + np.array([0.0, 0.0, GRAVITY_M_S2]))


def is_still(values: Array, others: Array) -> bool:
    """Tell whether a sensor measures almost none of the motion (n, k) that others measure."""
    own, whole = (float(np.sqrt(np.mean(np.square(each)))) for each in (values, others))
    return own < STILL * whole
