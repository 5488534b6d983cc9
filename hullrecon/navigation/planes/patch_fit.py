# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Fit a curved patch of the hull through the ends of DVL beams."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.geometry.rotations import cross
from hullrecon.typing import Array, Mask

LEAST_RETURNS = 12
LEAST_SPREAD_M = 0.15  # standard deviation of the returns, in both directions along the hull
MAX_RMS_SIGMAS = 3.0  # of the residuals, in sigmas of a range; beyond, the surface is not smooth
OUTLIER_SIGMAS = 3.5
LEAST_KEPT = 0.7  # least share of the returns that are no outliers
LEAST_INCIDENCE = 0.3  # cosine between beam and normal, below which it is clipped
Y, Z = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])  # axes of the frame
TURNS = 4  # iterations of fitting, rejecting outliers and turning the axes into the tangent plane


@dataclass(frozen=True, kw_only=True)
class PatchFit:
    """A patch in the frame of its points, which stands 0.5 x' K x over its tangent plane."""

    center: Array  # (3,) on the surface
    axes: Array  # (3, 3), columns azimuth, elevation, normal towards the vehicle
    curvature: Array  # (3,) 1/m: K_aa, K_ae, K_ee, towards the vehicle
    curvature_covariance: Array  # (3, 3)
    plane_covariance: Array  # (3, 3) of (height m, slopes) at the centre, given K
    by_curvature: Array  # (3, 3) derivative of height and slopes by K
    sigma_m: float  # of a range
    kept: Mask  # (n,) inliers
    to_plane: Array  # (n,) m from a point along its beam to the tangent plane


def fit_patch(
    points: Array, rays: Array, sigma_range_m: float, curvature_sigma: Array
) -> PatchFit | None:
    """Fit a curved patch to the ends of DVL beams.

    The height over the tangent plane, height + slopes' x + 0.5 x' K x, is fitted by weighted least
    squares. Then the plane is moved and turned so that height and slopes vanish, outliers are left
    out, and the fit is repeated. None where the points are too few, lie on a line, or do not lie on
    a smooth surface.

    Parameters
    ----------
    points, rays
        Ends (n, 3) of the beams, m, and their unit directions (n, 3), in one frame.
    sigma_range_m
        Sigma of a range. It is widened where the hull turns out uneven.
    curvature_sigma
        Prior sigma (3,) of K about zero, 1/m. It keeps the bend of a sparse patch plausible.
    """
    kept = np.ones(len(points), bool)
    if len(points) < LEAST_RETURNS:
        return None
    prior = np.diag(np.r_[np.zeros(3), curvature_sigma**-2])  # height and slopes are free

    # Start from the plane through the middle of the points, its normal towards the DVL.
    center = np.median(points, axis=0)
    normal = np.linalg.svd(points - center)[2][2]
    axes = patch_axes(-np.sign(np.median(rays @ normal)) * normal)
    for _ in range(TURNS):
        local = (points - center) @ axes
        incidence = np.maximum(np.abs(rays @ axes[:, 2]), LEAST_INCIDENCE)
        if kept.sum() < LEAST_RETURNS or local[kept, :2].std(axis=0).min() < LEAST_SPREAD_M:
            return None

        # The sigma of a height is that of the range times the cosine of the incidence. `rows` holds
        # the derivatives of the heights by height, slopes and K, all of which are solved for.
        rows = _rows(local)
        weight = 1 / (sigma_range_m * incidence)
        weighted = rows[kept] * weight[kept, None] ** 2
        information = weighted.T @ rows[kept] + prior
        solution = np.linalg.solve(information, weighted.T @ local[kept, 2])
        height, slopes = solution[0], solution[1:3]

        residual = (local[:, 2] - rows @ solution) * weight
        spread = max(1.0, NORMAL_MAD * float(np.median(np.abs(residual[kept]))))
        kept = np.abs(residual) < OUTLIER_SIGMAS * spread
        center = center + axes @ np.r_[0.0, 0.0, height]
        axes = patch_axes(axes @ (np.r_[-slopes, 1.0] / np.hypot(1, np.linalg.norm(slopes))))

    rms = float(np.sqrt(np.mean(residual[kept] ** 2))) if kept.any() else np.inf
    if kept.sum() < max(LEAST_RETURNS, LEAST_KEPT * len(points)) or rms > MAX_RMS_SIGMAS:
        return None
    scale = max(1.0, rms)  # an uneven hull widens all sigmas
    covariance = np.linalg.inv(information) * scale**2
    # of height and slopes where K is known, and how both follow K where it is not
    plane = np.linalg.inv(information[:3, :3])
    over = height_over_plane(solution[3:], (points - center) @ axes)
    return PatchFit(
        center=center,
        axes=axes,
        curvature=solution[3:],
        curvature_covariance=covariance[3:, 3:],
        plane_covariance=plane * scale**2,
        by_curvature=-plane @ information[:3, 3:],
        sigma_m=sigma_range_m * scale,
        kept=kept,
        to_plane=over / np.maximum(np.abs(rays @ axes[:, 2]), LEAST_INCIDENCE),
    )


def patch_axes(normal: Array) -> Array:
    """Choose axes (3, 3) of a patch: azimuth, elevation, and its unit normal (3,), as columns.

    They depend on the normal alone, so that azimuth and elevation mean the same on all patches.
    Azimuth is horizontal, unless the normal is nearly vertical.
    """
    level = cross(Z, normal)
    if np.linalg.norm(level) < 0.3:  # under a flat bottom: the first axis is the vehicle's y
        level = cross(cross(normal, Y), normal)
    azimuth = level / np.linalg.norm(level)
    return np.column_stack([azimuth, cross(normal, azimuth), normal])


def height_over_plane(curvature: Array, local: Array) -> Array:
    """Compute the height (n,) m of the patch over its tangent plane at points (n, >=2)."""
    a, e = local[:, 0], local[:, 1]
    return np.asarray(np.sum(curvature * np.stack([0.5 * a**2, a * e, 0.5 * e**2], axis=1), axis=1))


def _rows(local: Array) -> Array:
    """Build the rows of the fit (n, 6): height, two slopes, and K (aa, ae, ee) at points (n, 3)."""
    a, e = local[:, 0], local[:, 1]
    return np.stack([np.ones_like(a), a, e, 0.5 * a**2, a * e, 0.5 * e**2], axis=1)
