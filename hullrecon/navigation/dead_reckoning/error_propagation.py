# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Propagate the errors of dead reckoning to every node.

Persistent errors are one unknown each for the dive. With Jacobian J and covariance P they add
J P J' to the covariance of the poses. White noise and random walks add to that.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.navigation.dead_reckoning.odometry import velocity_variance
from hullrecon.navigation.dead_reckoning.reckoning import (
    BACKLASH,
    MOMENT,
    MOUNT,
    TILT,
    UP_DOWN,
    Instant,
    Reckoning,
)
from hullrecon.navigation.sensors.depth import Depth
from hullrecon.navigation.sigmas import NavigationSigmas
from hullrecon.records.trajectory import TrajectoryErrorModel
from hullrecon.typing import Array, Ints

UNKNOWN_DEPTH_M = 10.0  # sigma of the start's depth without a pressure sensor
LEAST_SIGMA_M = 1e-4  # of a position: keeps the covariance at the start invertible
# Columns of `pose_by_error`, the persistent errors.
SCALE, DRIFT, MOUNT_TURN, TRAY_BACKLASH = 0, 1, slice(2, 5), 5
ROLL_PITCH, HEADING, DVL_LATE, DEPTH_BIAS, PRESSURE_LATE = slice(6, 8), 8, 9, 10, 11
ERRORS = 12


def dead_reckoning_errors(
    path: Reckoning, at: Instant, poses: Poses, depth: Depth | None, sigmas: NavigationSigmas
) -> TrajectoryErrorModel:
    """Compute the error model of dead-reckoned poses global_from_vehicle (n,).

    Errors are relative to the start of the path, but that of depth is absolute where a pressure
    sensor was logged: its bias and the smoothed noise of its readings. At nodes where it was silent
    the drift since the nearest measured node adds to that. Without a pressure sensor depth drifts
    like x and y.

    Parameters
    ----------
    path, at
        The path, and its instants at the nodes, with the derivatives by persistent errors.
    poses
        The nodes' poses, with the depth that was corrected.
    depth
        The correction by the pressure sensor with its sigma, None without one.
    sigmas
        How large each persistent error may be.
    """
    by_error = pose_by_error(at)
    by_error[:, :3, DVL_LATE] = path.path_by_delay(at.t_ns)
    # errors of the position are zero at the start of the path
    by_error[:, :3] -= pose_by_error(path.at(np.array([path.start_ns])))[:, :3]
    by_error[:, 2, DEPTH_BIAS] = 1.0
    by_error[:, 2, PRESSURE_LATE] = -np.gradient(poses.translation[:, 2], at.t_s)
    # `walk`: errors that add up along the path, common to all later nodes; `white`: each node's own
    walk, white = np.zeros((2, len(at.t_ns), 6, 6))
    walk[:, [0, 1, 2], [0, 1, 2]] = _variance_since_start(path, at)[:, None]
    white[:, [0, 1, 2], [0, 1, 2]] = LEAST_SIGMA_M**2
    in_hole = path.attitude.hole_sigma(at.t_ns)
    white[:, [3, 4, 5], [3, 4, 5]] = (path.attitude.sigma_rad**2 + in_hole**2)[:, None]
    one_stretch = np.zeros(len(at.t_ns), np.int64)
    walk[:, [0, 1, 2], [0, 1, 2]] += _variance_by_direction(
        at, path.servo.unread_sigma(at.t_ns), one_stretch
    )[:, None]
    walk[:, [0, 1, 2], [0, 1, 2]] += _variance_by_direction(
        at, in_hole, path.attitude.holes_before(at.t_ns)
    )[:, None]
    turned = _covariance_by_unread_attitude(path, at, poses)
    # the depth counts from the nearest node at which it was measured, not from the start
    if depth is not None:
        near = _nearest_depth(at, depth)
        by_error[:, 2, :DEPTH_BIAS] -= by_error[near, 2, :DEPTH_BIAS]
        white[:, 2, 2] = depth.sigma**2 + np.abs(walk[:, 2, 2] - walk[near, 2, 2])
        walk[:, 2, 2] = 0.0
    to_twist = twist_by_pose_error(poses)
    # Noise of the velocities shifts the remaining path: a shift is the same twist at every node.
    return TrajectoryErrorModel(
        by_error=to_twist @ by_error,
        error_covariance=np.diag(_error_sigma(sigmas, depth is not None) ** 2),
        walk=walk + turned,
        white=to_twist @ white @ np.swapaxes(to_twist, 1, 2),
    )


def _variance_since_start(path: Reckoning, at: Instant) -> Array:
    """Compute the variance (n,), m2, each axis, of the integral of the velocities' noise.

    It counts from the start of the path, and is negative before it.
    """
    start = np.full(len(at.t_ns), path.start_ns)
    variance = velocity_variance(path, np.minimum(start, at.t_ns), np.maximum(start, at.t_ns))
    return np.asarray(np.sign(at.t_ns - start) * variance)


def _covariance_by_unread_attitude(path: Reckoning, at: Instant, poses: Poses) -> Array:
    """Compute the covariance (n, 6, 6) of twists by turns that the IMU did not measure.

    They happen beyond the IMU's readings, and where its heading stepped. Each rotates the remaining
    path about the position where it happened, so it adds to the twists of all later nodes.
    """
    unread, stepped = (
        path.attitude.variance_of_unread_turns(at.t_ns),
        path.attitude.variance_of_steps(at.t_ns),
    )
    # a turn w about the position p between two nodes is the twist (p x w, w)
    about = 0.5 * (poses.translation[1:] + poses.translation[:-1])
    by_turn = np.concatenate([cross_matrix(about), np.tile(np.eye(3), (len(about), 1, 1))], axis=1)
    # about the axes of g (n - 1, 3): unread turns about all alike, steps of the heading about z
    variance = np.diff(unread)[:, None] + np.diff(stepped)[:, None] * UP_DOWN**2
    steps = (by_turn * variance[:, None]) @ np.swapaxes(by_turn, 1, 2)
    walk = np.concatenate([np.zeros((1, 6, 6)), np.cumsum(steps, axis=0)])
    return np.asarray(walk - walk[min(int(np.searchsorted(at.t_ns, path.start_ns)), len(walk) - 1)])


def _variance_by_direction(at: Instant, sigma_rad: Array, stretch: Ints) -> Array:
    """Compute the variance (n,), m2, each axis, of positions by velocities in a wrong direction.

    The direction is wrong where the tray or the attitude was not read. Within a stretch of nodes
    the error is common, so its effect grows with the distance travelled. Stretches are independent.
    The variance counts from the start of the path, and is negative before it.

    Parameters
    ----------
    at
        The nodes, with the DVL's path whose steps are turned.
    sigma_rad
        Sigma (n,) of the direction, zero where it was read.
    stretch
        Number (n,) of each node's stretch, ascending.
    """
    step_m = np.linalg.norm(np.diff(at.instrument, axis=0), axis=1)
    # by how far the position is shifted up to each node, one sigma: step lengths times their sigmas
    shift_m = np.concatenate([[0.0], np.cumsum(0.5 * (sigma_rad[1:] + sigma_rad[:-1]) * step_m)])
    # row before each node's stretch: the step to its first node counts
    begin = np.maximum(np.searchsorted(stretch, stretch) - 1, 0)
    # at the first node of a stretch: the variance of the whole stretch before it
    whole = np.where(
        np.diff(stretch, prepend=stretch[0]) > 0, np.roll(shift_m - shift_m[begin], 1) ** 2, 0.0
    )
    variance = np.cumsum(whole) + (shift_m - shift_m[begin]) ** 2
    return np.asarray(variance - np.interp(0.0, at.t_s, variance))  # t_s is 0 at the path's start


def _nearest_depth(at: Instant, depth: Depth) -> Ints:
    """Find for each node (n,) the node nearest in time at which the depth was measured."""
    read = np.flatnonzero(depth.unread_s == 0)
    after = np.minimum(np.searchsorted(read, np.arange(len(at.t_ns))), len(read) - 1)
    before = np.maximum(after - 1, 0)
    is_before = at.t_ns - at.t_ns[read[before]] < np.abs(at.t_ns[read[after]] - at.t_ns)
    return np.asarray(read[np.where(is_before, before, after)])


def trajectory_covariance(model: TrajectoryErrorModel, poses: Poses) -> Array:
    """Compute the covariance (n, 6, 6) of each pose global_from_vehicle alone.

    It is what a reader of one pose needs. The error model itself also tells how the errors of two
    poses are correlated. Errors are (translation in the global frame, rotation perturbed on the
    right in the vehicle's).
    """
    persistent = model.by_error @ model.error_covariance @ np.swapaxes(model.by_error, 1, 2)
    from_twist = np.linalg.inv(twist_by_pose_error(poses))
    # before the start of the path the walk is written as negative: its size counts
    walk = np.where(np.trace(model.walk, axis1=1, axis2=2) < 0, -1, 1)[:, None, None] * model.walk
    return np.asarray(
        from_twist @ (persistent + walk + model.white) @ np.swapaxes(from_twist, 1, 2)
    )


def twist_by_pose_error(poses: Poses) -> Array:
    """Compute the matrices (n, 6, 6) that turn pose errors into twists about the global origin.

    As twists, an error that shifts or turns the remaining path is the same at all later nodes, so
    that errors simply add up. Pose errors are (translation in the global frame, rotation perturbed
    on the right in the vehicle's): omega = R w, rho = t + p x omega.
    """
    rotation = poses.rotation.as_matrix()
    out = np.zeros((len(rotation), 6, 6))
    out[:, :3, :3] = np.eye(3)
    out[:, :3, 3:] = cross_matrix(poses.translation) @ rotation
    out[:, 3:, 3:] = rotation
    return out


def pose_by_error(at: Instant) -> Array:
    """Compute the Jacobian (n, 6, ERRORS) of poses by the persistent errors.

    Poses are (translation in the global frame, rotation perturbed on the right in the vehicle's).
    The errors are the DVL's scale, the heading drift, the mount's rotation vector, the tray's
    backlash, roll and pitch bias, and the heading at the start. Columns of the depth's bias and of
    time offsets are left zero here.

    A heading drift c turns the velocity at time s by c s. That moves the path by
    c z x (integral of s v ds), and the lever arm by c t z x (-R r).
    """
    rotation = at.rotation.as_matrix()
    turned_lever = at.rotation.apply(at.lever)
    lever_by_turn = rotation @ cross_matrix(at.lever)  # of -R r
    # the backlash turns the velocities by the side on which it rests, and swings the lever arm
    swing = at.direction[:, None] * at.rotation.apply(at.lever_by_tray)
    backlash = at.sums[:, :, BACKLASH] - swing
    out = np.zeros((len(at.t_ns), 6, ERRORS))
    out[:, :3, SCALE] = at.instrument
    out[:, :3, DRIFT] = np.cross(UP_DOWN, at.sums[:, :, MOMENT] - at.t_s[:, None] * turned_lever)
    out[:, :3, MOUNT_TURN] = at.sums[:, :, MOUNT]
    out[:, :3, TRAY_BACKLASH] = backlash
    out[:, :3, ROLL_PITCH] = (at.sums[:, :, TILT] + lever_by_turn)[:, :, :2]
    out[:, :3, HEADING] = np.cross(UP_DOWN, at.poses().translation)
    out[:, 3:, DRIFT] = rotation[:, 2] * at.t_s[:, None]
    out[:, 3:5, ROLL_PITCH] = np.eye(2)
    out[:, 3:, HEADING] = rotation[:, 2]
    return out


def _error_sigma(sigmas: NavigationSigmas, depth_is_measured: bool) -> Array:
    """Collect the prior sigma (ERRORS,) of each persistent error.

    The heading at the start has the sigma of a roll or pitch.
    """
    out = np.zeros(ERRORS)
    out[SCALE] = sigmas.scale
    out[DRIFT] = sigmas.heading_drift_rad_s
    out[MOUNT_TURN] = sigmas.mount[3:]
    out[TRAY_BACKLASH] = np.hypot(sigmas.tray_rad, sigmas.tray_unknown_rad)
    out[ROLL_PITCH] = sigmas.tilt_bias_rad
    out[HEADING] = sigmas.tilt_rad
    out[DEPTH_BIAS] = sigmas.depth_bias_m if depth_is_measured else UNKNOWN_DEPTH_M
    out[DVL_LATE] = sigmas.dvl_late_s
    out[PRESSURE_LATE] = sigmas.pressure_late_s if depth_is_measured else 0.0
    return out
