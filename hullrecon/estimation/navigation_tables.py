# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Build the tables of a native problem from navigation, and the prior that fixes frame g."""

from __future__ import annotations

import numpy as np

from hullrecon import native
from hullrecon.geometry.poses import Poses, pose_vector
from hullrecon.records.trajectory import Attitude, Odometry
from hullrecon.typing import Array, Ints

# Sigma of a step over its time, from which the step was bridged without a DVL. No DVL with a lock
# has so large a sigma.
BRIDGED_M_S = 0.05
LONGEST_STEP_S = 5.0  # between nodes, for which a constant velocity is assumed
# Density of the white acceleration of a vehicle that turns at the end of a leg
MANOEUVRES_M2_S3 = 0.01
FREE_RAD_S = 1e2  # sigma of the change of turn rate, which the IMU determines


def attitude_table(attitude: Attitude, depth_weight: float = 1.0) -> native.AttitudeTable:
    """Build the table of depth, roll and pitch. `depth_weight` multiplies the sigmas of depths."""
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
        (n,) as measured.
    direction
        (n,) +1 or -1, side of its backlash on which the tray hangs.
    sigma_rad
        Of a reading of the angle.
    unread_rad
        (n,) sigma of the turn since the nearest reading, 0 where the angle was read.
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

    The derivative by the DVL's scale is the motion of the present path, and not the measured one,
    as a wrong scale stretches the true motion and not the measurement's noise. With the measured
    motion, and images that determine its direction, a shorter scale would explain noise across the
    direction (errors in variables).

    Parameters
    ----------
    odometry
        As measured.
    tray_rad, tray_from_dvl
        Angles (n,) and mount that dead reckoning used.
    path
        (n,) in g, the present estimate.
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
    """Build the constant-velocity table of steps without DVL and their neighbouring steps.

    Where the DVL gave nothing, odometry has a sigma of many times a step's length, independent from
    step to step. A single camera does not measure lengths, so such steps could shrink to nothing.

    t_ns (n,): stamps of the nodes.
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
    # difference of a random walk's means over the two intervals
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
    """Build the prior of the first pose, which fixes the frame g.

    x, y and heading of g are those of this pose. Depth, roll and pitch have wide priors where
    sensors measure them. A depth that was not measured has a tight prior too: with a wide one,
    beside links of a tenth of a millimetre, it would be undetermined in double precision.
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
    """Build the prior of a mount. None where the mount is held.

    A mount is held if it has no `sqrt_information` (6, 6), or is absent from the rig (`nominal`) or
    from the state (`found`).
    """
    if nominal is None or sqrt_information is None or found is None:
        return None
    return native.MotionPrior(value=pose_vector(nominal), sqrt_information=sqrt_information)
