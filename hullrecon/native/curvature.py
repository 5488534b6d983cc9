# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The difference between two tangent planes of a curved hull, by two characteristic radii.

As in [Ozog2016 2.3.4, B.6], corrected. Azimuth is the angle about z of the vehicle, elevation that
towards z. Where the vehicle moves by t_a and t_e perpendicular to the normal of a plane at the
distance p, the normal turns by t_a / (radius_azimuth + p) and t_e / (radius_elevation + p).

[Ozog2016] adds t_y over radius_azimuth and t_z over radius_elevation for any direction of the
normal. That holds for a normal along +x of the vehicle alone. It has the wrong sign in azimuth for
a vehicle that looks ahead at the hull, and does not take into account that the vehicle moves
farther than its foot on the hull. It also keeps the distance of the plane. Here the second plane
touches the surface, which has curved away.
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array


def curvature_difference(
    plane: Array, moved: Array, radius_azimuth: Array, radius_elevation: Array
) -> Array:
    """Compute the plane seen after the vehicle has moved minus the plane seen before.

    Parameters
    ----------
    plane
        (n, 3) m, seen from the first pose, in its vehicle frame.
    moved
        (n, 3) m, the second pose's origin in the vehicle frame of the first.
    radius_azimuth, radius_elevation
        (n,) m of the hull, positive where it is convex, inf where it is flat.

    Returns
    -------
    Array
        (n, 3) m in the vehicle frame of the first pose, as PlanePairTable.measured.
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
    """Compute the square root of information (n, 3, 3) of plane pairs.

    It is that of the covariance diag(difference^2) + C S C' + floor^2 [Ozog2016 2.3.4], where C is
    the derivative of the difference by the poses.

    Parameters
    ----------
    plane, moved, radius_azimuth, radius_elevation
        As for `curvature_difference`.
    rotation
        (n, 3, 3) global_from_vehicle of the first pose.
    covariance
        S (n, 14, 14) of both poses, as of `pair_covariance`.
    floor_m
        Sigma of causes other than curvature (frames, weld seams, the fit of the patches).
    """
    step_m = 1e-4

    def shifted(axis: int, sign: float) -> Array:
        return curvature_difference(
            plane, moved + sign * step_m * np.eye(3)[axis], radius_azimuth, radius_elevation
        )

    by_moved = np.stack(
        [(shifted(k, 1) - shifted(k, -1)) / (2 * step_m) for k in range(3)], axis=-1
    )
    # Derivative of `moved`, R1' (t2 - t1), by translation in g, rotation on the right and tray of
    # both poses
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
