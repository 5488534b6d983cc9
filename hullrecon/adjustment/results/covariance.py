# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Covariances of poses and landmarks in the hull frame, from the marginals of the solve.

With T_M_v = T_g_M^-1 T_g_v and the perturbations of docs/conventions.md (translation added in g,
rotation on the right, T_g_M about the survey's middle c), first order:
    d t_Mv = R_gM^T (d t_gv - d t_gM) + [t_Mv - c]x d w_gM,    d w_Mv = d w_gv - R_Mv^T d w_gM.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array


def poses_in_hull(
    pose: Array, pose_hull: Array, hull: Array, nodes: Poses, global_from_hull: Poses, center: Array
) -> Array:
    """Compute the covariance (n, 6, 6) of hull_from_vehicle.

    The hull's pose has errors of its own, and shares errors with the path. The order is translation
    in M, then rotation perturbed on the right in v.

    Parameters
    ----------
    pose
        Covariance (n, 6, 6) of global_from_vehicle.
    pose_hull
        Cross covariance (n, 6, 6) of global_from_vehicle and global_from_hull.
    hull
        Covariance (6, 6) of global_from_hull about `center`.
    nodes, global_from_hull
        The poses of vehicle and hull in g, at which derivatives are taken.
    center
        (3,) m in M, about which the hull's rotation is perturbed.
    """
    in_hull = global_from_hull.inverse() @ nodes
    to_hull = global_from_hull.rotation.as_matrix()[0].T
    n = len(nodes)
    # Derivatives by the node's pose and by the hull's, as in the module's docstring
    by_pose, by_hull = np.zeros((n, 6, 6)), np.zeros((n, 6, 6))
    by_pose[:, :3, :3], by_pose[:, 3:, 3:] = to_hull, np.eye(3)
    by_hull[:, :3, :3] = -to_hull
    by_hull[:, :3, 3:] = cross_matrix(in_hull.translation - center)
    by_hull[:, 3:, 3:] = -in_hull.rotation.as_matrix().transpose(0, 2, 1)
    return _propagate(by_pose, by_hull, pose, pose_hull, hull)


def points_in_hull(
    point: Array,
    point_hull: Array,
    hull: Array,
    position: Array,
    global_from_hull: Poses,
    center: Array,
) -> Array:
    """Compute the covariance (n, 3, 3) in M of points (n, 3) in g.

    Parameters
    ----------
    point
        Covariance (n, 3, 3) in g.
    point_hull
        Cross covariance (n, 3, 6) of the points and global_from_hull.
    hull
        Covariance (6, 6) of global_from_hull about `center`.
    position
        The points (n, 3) m in g.
    global_from_hull
        The hull's pose.
    center
        (3,) m in M, about which the hull's rotation is perturbed.
    """
    to_hull = global_from_hull.rotation.as_matrix()[0].T
    n = len(position)
    by_point = np.broadcast_to(to_hull, (n, 3, 3))
    by_hull = np.zeros((n, 3, 6))
    by_hull[:, :, :3] = -to_hull
    by_hull[:, :, 3:] = cross_matrix(global_from_hull.inverse().apply(position) - center)
    return _propagate(by_point, by_hull, point, point_hull, hull)


def _propagate(by_own: Array, by_hull: Array, own: Array, cross: Array, hull: Array) -> Array:
    """Propagate covariances of a quantity that depends on its own unknowns and the hull's pose.

    J_own S_own J_own^T + J_own S_cross J_hull^T + its transpose + J_hull S_hull J_hull^T, made
    symmetric.

    Parameters
    ----------
    by_own, by_hull
        Jacobians (n, k, k) and (n, k, 6).
    own, cross, hull
        Covariances (n, k, k) and (6, 6), and cross covariance (n, k, 6).
    """
    mixed = by_own @ cross @ by_hull.transpose(0, 2, 1)
    total = (
        by_own @ own @ by_own.transpose(0, 2, 1)
        + mixed
        + mixed.transpose(0, 2, 1)
        + by_hull @ hull @ by_hull.transpose(0, 2, 1)
    )
    return np.asarray(0.5 * (total + total.transpose(0, 2, 1)))


def hull_axes(hull: Array, global_from_hull: Poses) -> Array:
    """Turn the translation part of the hull pose's covariance (6, 6) from g into M's axes."""
    turn = np.eye(6)
    turn[:3, :3] = global_from_hull.rotation.as_matrix()[0].T
    return np.asarray(turn @ hull @ turn.T)
