# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The difference that a hull's curvature makes of two planes on it, by two characteristic radii.

As in [Ozog2016 2.3.4, B.6]. Azimuth runs about z of the vehicle, elevation towards z. Where the
vehicle moves by t_a and t_e across the normal of a plane at the distance p, the normal leans by t_a
/ (radius_azimuth + p) and t_e / (radius_elevation + p). The print adds t_y over radius_azimuth and
t_z over radius_elevation whatever the normal's direction; that holds for a normal along +x of the
vehicle alone, has the wrong sign in azimuth for a vehicle that looks ahead at the hull, and forgets
that the vehicle's way is longer than that on the hull. The printed distance stays, too; here the
plane touches the surface that has curved away meanwhile.
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array


def curvature_difference(
    plane: Array, moved: Array, radius_azimuth: Array, radius_elevation: Array
) -> Array:
    """Compute by how much a plane differs from one seen after the vehicle has moved, (m, 3) m.

    In the vehicle frame of the first pose: PlanePairTable.measured.

    Parameters
    ----------
    plane
        (m, 3) m seen by the first pose.
    moved
        (m, 3) m, the second pose's origin in the vehicle frame of the first.
    radius_azimuth, radius_elevation
        (m,) m of the hull; positive of a convex one, inf is flat.
    """
    distance = np.linalg.norm(plane, axis=-1, keepdims=True)
    n = plane / distance
    azimuth = np.arctan2(n[:, 1], n[:, 0])
    along_azimuth = np.stack([-np.sin(azimuth), np.cos(azimuth), np.zeros_like(azimuth)], axis=-1)
    along_elevation = np.cross(n, along_azimuth)
    step = np.stack(
        [np.sum(moved * along, axis=-1) for along in (along_azimuth, along_elevation)], axis=-1
    )
    radius = np.stack(np.broadcast_arrays(radius_azimuth, radius_elevation), axis=-1)
    step /= 1 + distance / radius  # on the hull
    lean = step / radius
    angle = np.linalg.norm(lean, axis=-1, keepdims=True)
    towards = (lean[:, :1] * along_azimuth + lean[:, 1:] * along_elevation) / np.where(
        angle > 0, angle, 1
    )
    normal = np.cos(angle) * n + np.sin(angle) * towards
    sag = 0.5 * np.sum(step * lean, axis=-1, keepdims=True)
    below = step[:, :1] * along_azimuth + step[:, 1:] * along_elevation - (distance + sag) * n
    touching: Array = -np.sum(normal * below, axis=-1, keepdims=True) * normal
    return touching - plane


def curvature_information(
    plane: Array,
    moved: Array,
    radius_azimuth: Array,
    radius_elevation: Array,
    rotation: Array,
    covariance: Array,
    floor_m: float,
) -> Array:
    """Compute the sqrt_information (m, 3, 3) of plane pairs.

    Of diag(difference^2) + C S C' + floor^2 [Ozog2016 2.3.4]; C is the derivative of the difference
    by the poses.

    Parameters
    ----------
    plane, moved, radius_azimuth, radius_elevation
        As in `curvature_difference`.
    rotation
        (m, 3, 3) global_from_vehicle of the first pose.
    covariance
        S (m, 14, 14) of both poses, as `pair_covariance` gives it.
    floor_m
        Sigma of what no radius explains (frames, weld seams, the fit of the patches).
    """
    h = 1e-4

    def along(axis: int, sign: float) -> Array:
        return curvature_difference(
            plane, moved + sign * h * np.eye(3)[axis], radius_azimuth, radius_elevation
        )

    by_moved = np.stack([(along(k, 1) - along(k, -1)) / (2 * h) for k in range(3)], axis=-1)
    by_poses = np.zeros((len(plane), 3, 14))
    to_vehicle = np.swapaxes(rotation, 1, 2)
    by_poses[:, :, 0:3], by_poses[:, :, 7:10] = -to_vehicle, to_vehicle
    by_poses[:, :, 3:6] = np.cross(np.eye(3)[None], moved[:, None, :])  # hat(moved)
    c = by_moved @ by_poses
    difference = curvature_difference(plane, moved, radius_azimuth, radius_elevation)
    whole = c @ covariance @ np.swapaxes(c, 1, 2) + (difference**2 + floor_m**2)[
        :, :, None
    ] * np.eye(3)
    root: Array = np.linalg.inv(np.linalg.cholesky(whole))
    return root
