# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compute the motion between neighbouring nodes by DVL and IMU, and its derivatives by errors.

The pressure is not used here: it enters the adjustment as depth. Each derivative says how the
measured motion would change if dead reckoning had known the error: a true velocity of (1 + e) v, a
true heading of the logged one plus c t, a mount R_s_d Exp(w), a tray angle theta + d.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.navigation.dead_reckoning.reckoning import (
    MOMENT,
    MOUNT,
    PATH,
    TRAY,
    UP_DOWN,
    Instant,
    Reckoning,
)
from hullrecon.records.trajectory import Odometry
from hullrecon.typing import Array, Ints

LEAST_SIGMA_M = 2e-4  # of a step between two nodes, by errors of stamps and lever arms


def odometry(path: Reckoning, at: Instant) -> Odometry:
    """Compute the n - 1 edges between neighbouring nodes, which the adjustment takes as measured.

    An edge is the pose of the second vehicle in the first. Its derivatives are of (translation in
    the first vehicle's axes, rotation perturbed on the right).
    """
    n = len(at.t_ns)
    first, second = np.arange(n - 1), np.arange(1, n)
    poses = at.poses()
    step = poses[first].inverse() @ poses[second]
    covariance = white_covariance(path, at, step)

    first_from_global = np.swapaxes(at.rotation.as_matrix()[:-1], 1, 2)
    second_from_global = np.swapaxes(at.rotation.as_matrix()[1:], 1, 2)
    duration = np.diff(at.t_s)[:, None]
    moved = at.sums[1:] - at.sums[:-1]  # of the DVL, with derivatives

    # A wrong scale stretches the DVL's way.
    by_navigation = np.zeros((n - 1, 6, 2))
    by_navigation[:, :3, 0] = _into(first_from_global, moved[:, :, PATH])

    # A drift of the heading turns each piece of that way by the time since the first node, and at
    # the second node the lever from the vehicle to the DVL.
    since_first = moved[:, :, MOMENT] - at.t_s[:-1, None] * moved[:, :, PATH]
    lever = at.rotation.apply(at.lever)[1:]
    turned = np.cross(UP_DOWN, since_first - duration * lever)
    by_navigation[:, :3, 1] = _into(first_from_global, turned)
    by_navigation[:, 3:, 1] = second_from_global[:, :, 2] * duration

    # A turn of the DVL's mount turns its velocities.
    by_mount = np.zeros((n - 1, 6, 3))
    by_mount[:, :3] = first_from_global @ moved[:, :, MOUNT]

    # Another angle of the tray turns them too, and moves the DVL relative to the vehicle.
    by_tray = np.zeros((n - 1, 6))
    swing = np.diff(at.rotation.apply(at.lever_by_tray), axis=0)
    by_tray[:, :3] = _into(first_from_global, moved[:, :, TRAY] - swing)
    return Odometry(
        first=first,
        second=second,
        quaternion=step.quaternion,
        translation=step.translation,
        covariance=covariance,
        by_navigation=by_navigation,
        by_mount=by_mount,
        by_tray=by_tray,
        from_images=np.zeros(n - 1, bool),
    )


def widen_for_delay(found: Odometry, path: Reckoning, at: Instant, late_s: float) -> Odometry:
    """Widen the edges by the uncertain time offset of the DVL.

    The offset is one error for the dive, but edges are independent. So the variance of the largest
    shift of the path that it causes is distributed among the edges, by how much the velocity
    changes along each.

    late_s: sigma of the offset.
    """
    # by how much the path moves per second of delay, at each node
    shift = path.path_by_delay(at.t_ns)
    largest = np.linalg.norm(shift - shift[0], axis=1).max()
    change = np.linalg.norm(np.diff(shift, axis=0), axis=1)
    share = change / max(change.sum(), 1e-12)
    covariance = found.covariance.copy()
    covariance[:, [0, 1, 2], [0, 1, 2]] += ((late_s * largest) ** 2 * share)[:, None]
    return replace(found, covariance=covariance)


def widen_for_tray(found: Odometry, tray_sigma: Array) -> Odometry:
    """Widen the edges by the second-order effect of a wrong tray angle.

    The derivative of an edge by the tray's angle, which the adjustment uses, holds near the logged
    angle only.

    tray_sigma (n,): rad, of the nodes' tray angles, 0 where the tray was read.
    """
    turn = np.maximum(tray_sigma[found.first], tray_sigma[found.second])
    covariance = found.covariance.copy()
    covariance[:, [0, 1, 2], [0, 1, 2]] += (
        (0.5 * turn**2 * np.linalg.norm(found.translation, axis=1)) ** 2
    )[:, None]
    return replace(found, covariance=covariance)


def white_covariance(path: Reckoning, at: Instant, step: Poses) -> Array:
    """Compute the white covariance (m, 6, 6) of steps by velocity noise, outages and turns.

    White: errors of different steps are independent. The noise of the turn also moves the lever arm
    from the vehicle to the DVL.

    step: pose of the second vehicle in the first, of each pair of neighbouring nodes.
    """
    start, stop = at.t_ns[:-1], at.t_ns[1:]
    shift = (velocity_variance(path, start, stop) + LEAST_SIGMA_M**2)[:, None, None]
    turn = path.attitude.turn_variance(start, stop)[:, None, None]
    # derivative of the step's translation by a turn at its end, through the lever arm there
    shift_by_turn = step.rotation.as_matrix() @ cross_matrix(at.lever[1:])
    out = np.zeros((len(start), 6, 6))
    out[:, :3, :3] = shift * np.eye(3) + turn * shift_by_turn @ np.swapaxes(shift_by_turn, 1, 2)
    out[:, :3, 3:] = turn * shift_by_turn
    out[:, 3:, :3] = np.swapaxes(out[:, :3, 3:], 1, 2)
    out[:, 3:, 3:] = turn * np.eye(3)
    return out


def velocity_variance(path: Reckoning, start_ns: Ints, stop_ns: Ints) -> Array:
    """Compute the variance (m,), m2, each axis, of steps by the velocity's noise and by outages.

    The noise of a velocity is constant until the next ping, so the variance is the integral of
    sigma^2 over the interval times the period of the pings. Outages add `bridged_variance`.

    start_ns, stop_ns (m,): the intervals of the steps.
    """
    v = path.velocities
    period = float(np.median(np.diff(v.t_ns))) * 1e-9
    velocity_s = (v.t_ns - path.start_ns) * 1e-9
    integrated = np.concatenate(
        [[0.0], np.cumsum(0.5 * (v.sigma[1:] ** 2 + v.sigma[:-1] ** 2) * np.diff(velocity_s))]
    )

    def integrated_until(t_ns: Ints) -> Array:
        """Integrate sigma^2 from the first velocity on, holding sigma constant beyond the ends."""
        t_s = (t_ns - path.start_ns) * 1e-9
        early, late = np.minimum(t_s - velocity_s[0], 0), np.maximum(t_s - velocity_s[-1], 0)
        return np.asarray(
            np.interp(t_s, velocity_s, integrated)
            + v.sigma[0] ** 2 * early
            + v.sigma[-1] ** 2 * late
        )

    return np.asarray(
        period * (integrated_until(stop_ns) - integrated_until(start_ns))
        + v.bridged_variance(start_ns, stop_ns)
    )


def _into(rotation: Array, vectors: Array) -> Array:
    return np.asarray(np.einsum("nij,nj->ni", rotation, vectors))
