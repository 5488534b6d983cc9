# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How well the place of a sonar's texel on the hull is known: the poses' and the mount's covariance
carried to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.imagery.camera_views import Footprints
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class PingUncertainty:
    """Where the sonar stood at n pings. sonar: T_M_o; vehicle: T_M_v (T_g_ without a CAD model);
    pose_covariance (n, 6, 6) of the vehicle, (translation in M, rotation perturbed on the right);
    servo_from_sonar: one T_j_o; mount_sigma (6,): m along the servo's axes, rad about the sonar's.
    """

    sonar: Poses
    vehicle: Poses
    pose_covariance: Array
    servo_from_sonar: Poses
    mount_sigma: Array


def position_sigma(pings: PingUncertainty, points: Array, normals: Array) -> tuple[Array, Array]:
    """Return one sigma (n, k) m of points (n, k, 3) along the worst direction of the tangent plane
    of normals (n, k, 3): of all, and of the mount alone; NaN where a point is.

    A point R p + t moves by dt + R (w x p), with p seen from the vehicle or, for the mount, from
    the sonar.
    """
    sonar, vehicle = pings.sonar.rotation.as_matrix(), pings.vehicle.rotation.as_matrix()
    hull_from_servo = sonar @ pings.servo_from_sonar.rotation.as_matrix()[0].T
    of_pose = _motion_jacobian(
        np.broadcast_to(np.eye(3), vehicle.shape),
        vehicle,
        points - pings.vehicle.translation[:, None],
    )
    of_mount = _motion_jacobian(hull_from_servo, sonar, points - pings.sonar.translation[:, None])
    mount = np.einsum("nkai,i,nkbi->nkab", of_mount, np.square(pings.mount_sigma), of_mount)
    pose = np.einsum("nkai,nij,nkbj->nkab", of_pose, pings.pose_covariance, of_pose)
    return _largest_sigma(mount + pose, normals), _largest_sigma(mount, normals)


def median_position_sigma(
    pings: PingUncertainty, footprints: Footprints, chart: Chart
) -> dict[str, float | None]:
    """Return one sigma of a texel's place on the hull, m, in the median over pings and their
    footprints: `position_sigma_m`, and what the mount has of it, `position_sigma_of_mount_m`; None
    where no ping met the surface.
    """
    normals = chart.from_chart(footprints.at.reshape(-1, 2))[1].reshape(footprints.point.shape)
    names = ("position_sigma_m", "position_sigma_of_mount_m")
    both = position_sigma(pings, footprints.point, normals)
    return {
        n: float(np.nanmedian(s)) if np.isfinite(s).any() else None
        for n, s in zip(names, both, strict=True)
    }


def _motion_jacobian(shift_axes: Array, turn_axes: Array, levers: Array) -> Array:
    """Return how points move (n, k, 3, 6) with a shift along the columns of (n, 3, 3) and a turn
    about those of (n, 3, 3).
    """
    turned = np.cross(turn_axes.swapaxes(1, 2)[:, None], levers[:, :, None]).swapaxes(2, 3)
    return np.concatenate([np.broadcast_to(shift_axes[:, None], turned.shape), turned], axis=3)


def _largest_sigma(covariance: Array, normals: Array) -> Array:
    """Return the root of the largest eigenvalue of (n, k, 3, 3) in the tangent planes."""
    tangent = np.eye(3) - normals[..., :, None] * normals[..., None, :]
    flat = tangent @ covariance @ tangent
    known = np.isfinite(flat).all(axis=(2, 3))
    sigma = np.full(known.shape, np.nan)
    sigma[known] = np.sqrt(np.maximum(np.linalg.eigvalsh(flat[known])[:, -1], 0))
    return sigma
