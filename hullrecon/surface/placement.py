# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the vehicle was, in the frame of the surface, and how uncertain that makes a point on the
hull.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.typing import Array


def move_to_hull_frame(
    track: VehicleTrack, global_from_hull: Poses, sigma_m: Array
) -> VehicleTrack:
    """Return a track in g moved to M by a first guess of the hull's pose (a batch of one).

    sigma_m (3,): of the guess, along M's axes; it is added to the covariance and soon exceeds the
    rest of it.
    """
    hull_from_global = global_from_hull.inverse()
    turn = np.zeros((6, 6))
    turn[:3, :3], turn[3:, 3:] = hull_from_global.rotation.as_matrix()[0], np.eye(3)
    covariance = turn @ track.covariance @ turn.T
    covariance[:, :3, :3] += np.diag(np.square(sigma_m))
    return replace(
        track, poses=hull_from_global @ track.poses, covariance=covariance, frame=Frame.HULL
    )


def pose_sigma_along(normals: Array, levers: Array, covariance: Array, rotation: Array) -> Array:
    """Return one sigma (m,) of points along their normals that the poses' covariances cause.

    normals (m, 3) and levers (m, 3: point minus vehicle) in x; covariance (m, 6, 6) of (translation
    in x, rotation right-perturbed in v); rotation (m, 3, 3) R_x_v. A point R p + t moves by dt + R
    (w x p).
    """
    lever_v = np.einsum("nji,nj->ni", rotation, levers)
    normal_v = np.einsum("nji,nj->ni", rotation, normals)
    by_pose = np.hstack([normals, np.cross(lever_v, normal_v)])
    return np.asarray(
        np.sqrt(np.maximum(0.0, np.einsum("ni,nij,nj->n", by_pose, covariance, by_pose)))
    )
