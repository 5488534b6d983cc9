# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Uncertainty of a sonar texel's place on the hull, from poses and mount."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.imagery.camera_views import Footprints
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class PingUncertainty:
    """Where the sonar stood at pings (n)."""

    sonar: Poses  # result_from_sonar (n)
    vehicle: Poses  # result_from_vehicle (n)
    pose_covariance: Array  # (n, 6, 6) of the vehicle: translation in M, rotation right-perturbed
    servo_from_sonar: Poses  # one pose
    mount_sigma: Array  # (6,) m along the servo's axes, rad about the sonar's


def position_sigma(pings: PingUncertainty, points: Array, normals: Array) -> tuple[Array, Array]:
    """Propagate pose and mount to points (n, k, 3) on the hull.

    A point R p + t moves by dt + R (w x p), with p seen from the vehicle or, for the mount, from
    the sonar. Sigmas are along the worst direction of the tangent plane; NaN where a point is.

    Parameters
    ----------
    normals
        of the tangent planes (n, k, 3).

    Returns
    -------
    total
        one sigma (n, k) m.
    mount
        what the mount alone has of it (n, k) m.
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
    """Return the median sigma of a texel's place on the hull over all pings, m.

    Members of mosaic.json: of all, and of the mount alone; None where no ping met the surface.
    """
    normals = chart.from_chart(footprints.at.reshape(-1, 2))[1].reshape(footprints.point.shape)
    names = ("position_sigma_m", "position_sigma_of_mount_m")
    both = position_sigma(pings, footprints.point, normals)
    return {
        n: float(np.nanmedian(s)) if np.isfinite(s).any() else None
        for n, s in zip(names, both, strict=True)
    }


def _motion_jacobian(shift_axes: Array, turn_axes: Array, levers: Array) -> Array:
    """Differentiate points' positions (n, k, 3, 6) by a shift and a turn."""
    turned = np.cross(turn_axes.swapaxes(1, 2)[:, None], levers[:, :, None]).swapaxes(2, 3)
    return np.concatenate([np.broadcast_to(shift_axes[:, None], turned.shape), turned], axis=3)


def _largest_sigma(covariance: Array, normals: Array) -> Array:
    """Take the largest sigma of (n, k, 3, 3) in the tangent planes."""
    tangent = np.eye(3) - normals[..., :, None] * normals[..., None, :]
    flat = tangent @ covariance @ tangent
    known = np.isfinite(flat).all(axis=(2, 3))
    sigma = np.full(known.shape, np.nan)
    sigma[known] = np.sqrt(np.maximum(np.linalg.eigvalsh(flat[known])[:, -1], 0))
    return sigma
