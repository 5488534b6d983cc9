# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Uncertainty of a sonar texel's position on the hull, from vehicle poses and sonar mount."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.imagery.camera_views import Footprints
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class PingUncertainty:
    """Poses of sonar and vehicle at n pings, and what is known of them."""

    sonar: Poses  # result_from_sonar (n)
    vehicle: Poses  # result_from_vehicle (n)
    # (n, 6, 6) of `vehicle`: translation in the frame of the results, rotation perturbed on the
    # right
    pose_covariance: Array
    servo_from_sonar: Poses  # one pose
    mount_sigma: Array  # (6,) m along the servo's axes, rad about the sonar's axes


def position_sigma(pings: PingUncertainty, points: Array, normals: Array) -> tuple[Array, Array]:
    """Propagate the uncertainties of vehicle pose and sonar mount to points on the hull.

    So mosaic.json can say how well a place on the mosaic is known on the hull. A point R p + t
    moves by dt + R (w x p), where p is in the vehicle's axes or, for the mount, in the sonar's.
    Sigmas are along the worst direction in the tangent plane, NaN where a point is.

    Parameters
    ----------
    pings
        Poses at n pings, and the uncertainties of vehicle and mount.
    points
        (n, k, 3) m, k points that each ping met.
    normals
        (n, k, 3) of the tangent planes at the points.

    Returns
    -------
    total
        (n, k) m, one sigma.
    mount
        (n, k) m, one sigma from the mount alone.
    """
    sonar, vehicle = pings.sonar.rotation.as_matrix(), pings.vehicle.rotation.as_matrix()
    # hull_from_sonar times sonar_from_servo: the mount is shifted along the servo's axes
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
    """Compute the median sigma, m, of a texel's position on the hull, as members of mosaic.json.

    One member is for all causes, one for the mount alone. None where no ping met the surface.
    """
    normals = chart.from_chart(footprints.at.reshape(-1, 2))[1].reshape(footprints.point.shape)
    names = ("position_sigma_m", "position_sigma_of_mount_m")
    both = position_sigma(pings, footprints.point, normals)
    return {
        n: float(np.nanmedian(s)) if np.isfinite(s).any() else None
        for n, s in zip(names, both, strict=True)
    }


def _motion_jacobian(shift_axes: Array, turn_axes: Array, levers: Array) -> Array:
    """Compute the Jacobian (n, k, 3, 6) of points by a shift and a turn of their sensor.

    Parameters
    ----------
    shift_axes, turn_axes
        (n, 3, 3) columns are the axes of the shift and of the turn.
    levers
        (n, k, 3) m from the sensor to the points.
    """
    # A turn about an axis moves a point by axis x lever, for each of the three axes
    turned = np.cross(turn_axes.swapaxes(1, 2)[:, None], levers[:, :, None]).swapaxes(2, 3)
    return np.concatenate([np.broadcast_to(shift_axes[:, None], turned.shape), turned], axis=3)


def _largest_sigma(covariance: Array, normals: Array) -> Array:
    """Compute the largest sigma (n, k) m of covariances (n, k, 3, 3) m2 within the tangent planes.

    normals: unit vectors of these planes, which broadcast with the covariances.

    NaN where a covariance or a normal is.
    """
    # Projects onto the tangent planes
    tangent = np.eye(3) - normals[..., :, None] * normals[..., None, :]
    flat = tangent @ covariance @ tangent
    known = np.isfinite(flat).all(axis=(2, 3))
    sigma = np.full(known.shape, np.nan)
    sigma[known] = np.sqrt(np.maximum(np.linalg.eigvalsh(flat[known])[:, -1], 0))
    return sigma
