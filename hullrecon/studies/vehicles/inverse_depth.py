# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks by inverse depth, for one camera [Aulinas2011 5.3.2], [Civera2008].

A landmark (6,) is (c, alpha, beta, rho): where the camera was when it first saw it (3,), m,
azimuth and elevation of the ray in the world, rad, and the inverse of the distance along it, 1/m.
A vehicle's pose is (6,): position, m, and roll, pitch, yaw, rad.

Corrected here: (5.20) prints (cos a sin b - sin a, -sin a, cos a cos b) for m, which is no unit
vector; (5.21) takes r from rho c, and leaves m unrotated; (5.23) has no K^-1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.vehicles.transforms import rotation, rotation_derivatives
from hullrecon.typing import Array

# vehicle_from_camera: looks down, the image's top is forward
DOWN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
SIZE = 6  # of a landmark
PUBLISHED_RHO = 0.1  # 1/m, of a new landmark, after [Civera2008]


@dataclass(frozen=True, kw_only=True)
class Pinhole:
    """A camera without skew and distortion (5.17)."""

    focal_px: float
    centre_px: tuple[float, float]
    size_px: tuple[int, int]

    def project(self, ray: Array) -> tuple[Array, Array]:
        """Project a ray (3,) to a pixel (2,) (5.18), (5.22), with its Jacobian (2, 3)."""
        x, y, z = ray
        pixel = self.focal_px * ray[:2] / z + self.centre_px
        return pixel, self.focal_px / z * np.array([[1, 0, -x / z], [0, 1, -y / z]])

    def ray(self, pixel: Array) -> Array:
        """Turn a pixel (2,) into its ray K^-1 (u, v, 1) (3,)."""
        return np.append((pixel - np.array(self.centre_px)) / self.focal_px, 1.0)

    def sees(self, ray: Array) -> bool:
        """Tell whether a ray (3,) falls into the image."""
        if ray[2] <= 0:
            return False
        pixel, _ = self.project(ray)
        return bool((pixel >= 0).all() and (pixel < np.array(self.size_px)).all())


def direction(alpha: float, beta: float) -> tuple[Array, Array]:
    """Compute the unit vector m (3,) of azimuth and elevation (5.20), and its Jacobian (3, 2)."""
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    m = np.array([cb * sa, -sb, cb * ca])
    return m, np.array([[cb * ca, -sb * sa], [0.0, -cb], [-cb * sa, -sb * ca]])


def to_point(landmark: Array) -> tuple[Array, Array]:
    """Turn a landmark (6,) into its point (3,) (5.19), with the Jacobian (3, 6)."""
    m, by_angles = direction(landmark[3], landmark[4])
    rho = landmark[5]
    by_landmark = np.column_stack([np.eye(3), by_angles / rho, -m / rho**2])
    return landmark[:3] + m / rho, by_landmark


def see_landmark(camera: Pinhole, pose: Array, landmark: Array) -> tuple[Array, Array, Array]:
    """Predict a landmark's pixel: h = R_CW (rho (c - r) + m) (5.21), then (5.22).

    The camera is at the vehicle's origin and looks down. The ray is scaled by rho, so that it is
    finite for a landmark at infinity.

    Returns
    -------
    Array
        Pixel (2,).
    Array
        Jacobian (2, 6) by position and attitude of the vehicle.
    Array
        Jacobian (2, 6) by the landmark.
    """
    m, by_angles = direction(landmark[3], landmark[4])
    off, rho = landmark[:3] - pose[:3], landmark[5]
    in_world = rho * off + m
    camera_from_world = DOWN.T @ rotation(pose[3:]).T
    by_pose, by_landmark = np.empty((3, 6)), np.empty((3, 6))
    by_pose[:, :3] = -rho * camera_from_world
    turned = np.einsum("ajk,j->ka", rotation_derivatives(pose[3:]), in_world)
    by_pose[:, 3:] = DOWN.T @ turned
    by_landmark[:, :3] = rho * camera_from_world
    by_landmark[:, 3:5] = camera_from_world @ by_angles
    by_landmark[:, 5] = camera_from_world @ off
    pixel, by_ray = camera.project(camera_from_world @ in_world)
    return pixel, by_ray @ by_pose, by_ray @ by_landmark


def new_landmark(
    camera: Pinhole, pose: Array, pixel: Array, rho: float
) -> tuple[Array, Array, Array]:
    """Make a landmark of the first pixel that shows it: q = R_WC K^-1 (u, v, 1) (5.23, 5.24).

    Parameters
    ----------
    camera, pose
        The camera, and the vehicle's pose (6,) when it saw the landmark.
    pixel
        (2,) where the image shows it.
    rho
        A guess of its inverse depth, 1/m, which one image does not tell.

    Returns
    -------
    Array
        The landmark (6,).
    Array
        Jacobian (6, 6) by the vehicle's pose.
    Array
        Jacobian (6, 3) by pixel and rho.
    """
    ray = DOWN @ camera.ray(pixel)  # in the vehicle's frame
    q = rotation(pose[3:]) @ ray  # in the world, along y and in the plane of x and z
    flat = np.hypot(q[0], q[2])
    landmark = np.r_[pose[:3], np.arctan2(q[0], q[2]), np.arctan2(-q[1], flat), rho]
    by_q = np.array(
        [
            [q[2] / flat**2, 0.0, -q[0] / flat**2],
            np.array([q[0] * q[1] / flat, -flat, q[2] * q[1] / flat]) / (q @ q),
        ]
    )
    by_pose, by_seen = np.zeros((6, 6)), np.zeros((6, 3))
    by_pose[:3, :3] = np.eye(3)
    by_pose[3:5, 3:] = by_q @ (rotation_derivatives(pose[3:]) @ ray).T
    by_seen[3:5, :2] = by_q @ rotation(pose[3:]) @ DOWN[:, :2] / camera.focal_px
    by_seen[5, 2] = 1.0
    return landmark, by_pose, by_seen
