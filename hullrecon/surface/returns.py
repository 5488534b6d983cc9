# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the DVL's beams met the hull."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Array


def return_points(returns: Returns, T_x_v: Poses, tray_rad: Array, tray_origin: Array, T_s_d: Poses) -> Array:
    """End points (m, 3) of the beams in frame x.

    T_x_v and tray_rad: the vehicle and its tray at the n nodes; T_s_d: batch of one. The ping's own motion since its node, and
    the tray's, come from the returns.
    """
    since_node = Poses(returns.quaternion, returns.translation)
    tray_at_ping = tray_rad[returns.node] + returns.tray_offset
    T_x_d = T_x_v[returns.node] @ since_node @ poses.tray_poses(tray_origin, tray_at_ping) @ T_s_d
    return T_x_d.apply(returns.beam * returns.range_m[:, None])


def pose_sigma_along(normals: Array, levers: Array, covariance: Array, rotation: Array) -> Array:
    """One sigma (m,) of points along their normals that the poses' covariances cause.

    normals (m, 3) and levers (m, 3: point minus vehicle) in x; covariance (m, 6, 6) of (translation in x, rotation
    right-perturbed in v); rotation (m, 3, 3) R_x_v. A point R p + t moves by dt + R (w x p).
    """
    lever_v = np.einsum("nji,nj->ni", rotation, levers)
    normal_v = np.einsum("nji,nj->ni", rotation, normals)
    by_pose = np.hstack([normals, np.cross(lever_v, normal_v)])
    return np.asarray(np.sqrt(np.maximum(0.0, np.einsum("ni,nij,nj->n", by_pose, covariance, by_pose))))
