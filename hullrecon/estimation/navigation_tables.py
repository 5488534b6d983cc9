# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tables of a native problem that come from navigation, and the prior that fixes frame g."""

from __future__ import annotations

import numpy as np

from hullrecon import native
from hullrecon.geometry.poses import Poses, pose_vector
from hullrecon.records.trajectory import Attitude, Odometry
from hullrecon.typing import Array, Ints

BRIDGED_M_S = 0.05  # of a step's sigma over its time: no DVL that sees the bottom is so bad
LONGEST_STEP_S = 5.0  # between nodes, over which a velocity goes on
# Variance of a velocity's change in a second, of a vehicle that turns at the end of a leg
MANOEUVRES_M2_S3 = 0.01
FREE_RAD_S = 1e2  # sigma of the change of turn, which is left to the IMU


def attitude_table(attitude: Attitude, depth_weight: float = 1.0) -> native.AttitudeTable:
    """Build the table of depth, roll and pitch; depth_weight multiplies the sigma of depths."""
    return native.AttitudeTable(
        node=attitude.node.astype(np.int32),
        measured=np.stack([attitude.depth, attitude.roll, attitude.pitch], axis=1),
        sigma=attitude.sigma * np.array([depth_weight, 1.0, 1.0]),
    )


def tray_table(
    tray_rad: Array, direction: Array, sigma_rad: float, unread_rad: Array
) -> native.TrayTable:
    """Build the table of the tray's angle at every node (n,).

    Parameters
    ----------
    tray_rad
        As measured.
    direction
        (n,) sense in which the backlash lies.
    sigma_rad
        Of a reading.
    unread_rad
        (n,) sigma of what it may have turned where it was not read.
    """
    return native.TrayTable(
        node=np.arange(len(tray_rad), dtype=np.int32),
        measured=tray_rad,
        direction=direction,
        sigma=np.hypot(sigma_rad, unread_rad),
    )


def odometry_table(
    odometry: Odometry, tray_rad: Array, tray_from_dvl: Poses, path: Poses
) -> native.OdometryTable:
    """Build the table of odometry.

    A wrong scale stretches the true motion, not the noise of the measured one: taken from what was
    measured, the derivative by the scale lets a shorter scale explain noise across the motion away,
    where images tell its direction (errors in variables).

    Parameters
    ----------
    odometry
        As measured.
    tray_rad, tray_from_dvl
        Angles (n,) and mount that dead reckoning used.
    path
        (n,) in g as it is known by now.
    """
    motion = path[odometry.first].inverse() @ path[odometry.second]
    by_navigation = odometry.by_navigation.copy()
    by_navigation[:, :3, 0] += motion.translation - odometry.translation
    return native.OdometryTable(
        first=odometry.first.astype(np.int32),
        second=odometry.second.astype(np.int32),
        measured=Poses(odometry.quaternion, odometry.translation).vectors(),
        sqrt_information=np.linalg.inv(np.linalg.cholesky(odometry.covariance)),
        by_navigation=by_navigation,
        by_mount=odometry.by_mount,
        by_tray=odometry.by_tray,
        tray=0.5 * (tray_rad[odometry.first] + tray_rad[odometry.second]),
        mount=pose_vector(tray_from_dvl),
    )


def velocity_table(odometry: Odometry, t_ns: Ints) -> native.VelocityTable:
    """Build the constant-velocity rows of steps that were bridged, to their neighbours.

    Odometry alone gives each bridged step, where the DVL was silent, an independent error of many
    times its length. One camera does not measure lengths: with it, steps would then shrink to
    nothing wherever that suits the directions. t_ns (n,): of the nodes.
    """
    duration_s = (t_ns[odometry.second] - t_ns[odometry.first]) * 1e-9
    sigma_m_s = np.sqrt(odometry.covariance[:, 0, 0]) / np.maximum(duration_s, 1e-3)
    bridged = (sigma_m_s > BRIDGED_M_S) & ~odometry.from_images
    rows = np.arange(len(odometry) - 1)
    near = (odometry.second[:-1] == odometry.first[1:]) & (
        np.maximum(duration_s[:-1], duration_s[1:]) < LONGEST_STEP_S
    )
    rows = rows[(bridged[:-1] | bridged[1:]) & near]
    before, after = duration_s[rows], duration_s[rows + 1]
    sigma = np.sqrt(MANOEUVRES_M2_S3 * (before + after) / 3)
    free = np.full((len(rows), 3), FREE_RAD_S)
    return native.VelocityTable(
        first=odometry.first[rows].astype(np.int32),
        second=odometry.second[rows].astype(np.int32),
        third=odometry.second[rows + 1].astype(np.int32),
        before=before,
        after=after,
        sigma=np.hstack([np.repeat(sigma[:, None], 3, axis=1), free]),
    )


def gauge_prior(nodes: Poses, attitude: Attitude) -> native.PosePriors:
    """Build the prior that fixes g by the first pose.

    x, y and heading are that pose's; depth, roll and pitch are left to their sensors where there
    are any. A depth that nothing measured is part of the gauge: held loosely relative to links of a
    tenth of a millimetre, it is undetermined as far as double precision can tell.
    """
    tight_m, tight_rad = 1e-4, 1e-5
    free_m = 10.0 if attitude.has_depth.any() else tight_m
    free_rad = 1.0 if len(attitude.node) else tight_rad
    free = (free_m, free_rad, free_rad)
    sigma_in_global = np.array([tight_m, tight_m, *free, tight_rad])
    to_global = nodes.rotation.as_matrix()[0]
    rows = np.asarray(np.kron(np.eye(2), to_global) / sigma_in_global[:, None])
    first = nodes[:1].vectors()
    return native.PosePriors(node=np.zeros(1, np.int32), value=first, sqrt_information=rows[None])


def mount_prior_table(
    nominal: Poses | None, sqrt_information: Array | None, found: Poses | None
) -> native.MotionPrior | None:
    """Build the prior of a mount; None where it is held, or absent from rig or state (`found`)."""
    if nominal is None or sqrt_information is None or found is None:
        return None
    return native.MotionPrior(value=pose_vector(nominal), sqrt_information=sqrt_information)
