# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Split the variance of landmarks along the hull's normals into an own and a common part.

See docs/methods.md 12. The common part moves a landmark and its neighbours alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.neighbours import Nearest
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.records.solution import HullPose
from hullrecon.rows import blocks_of_rows
from hullrecon.typing import Array

NEIGHBOURS = 32  # of a landmark, with whose variances its own is compared
MIN_SIGMA_M = 0.001  # no landmark is better than its texture's roughness
AT_ONCE = 1 << 15  # landmarks that are compared with their neighbours


@dataclass(frozen=True, kw_only=True)
class VarianceAlongNormals:
    """Variance of landmarks along the hull's normals."""

    own: Array  # (n,) m2, independent from landmark to landmark, at least MIN_SIGMA_M^2
    # (n,) m2, from errors of the hull's pose and of the path, which move neighbours alike
    common: Array


def variance_along_normals(
    position: Array, normal: Array, covariance: Array, hull_pose: HullPose | None
) -> VarianceAlongNormals:
    """Split the variance of landmarks along normals into their own and a common part.

    Parameters
    ----------
    position, normal, covariance
        (n, 3) m, (n, 3) and (n, 3, 3) m2, all in one frame.
    hull_pose
        Whose covariance was added to those of the landmarks. None: it was not. It moves all
        landmarks alike, so it is a common part however large it is.
    """
    rest = covariance - _pose_covariance(position, normal, covariance, hull_pose)
    whole, alone = along_normals(normal, covariance), along_normals(normal, rest)
    shared = shared_variance(position, normal, rest)
    return VarianceAlongNormals(
        own=np.maximum(alone - shared, 0.0) + MIN_SIGMA_M**2,
        common=whole - alone + shared,
    )


def along_normals(normal: Array, covariance: Array) -> Array:
    """Compute the variances (n,) of points with covariances (n, 3, 3) along normals (n, 3)."""
    return np.asarray(np.einsum("ni,nij,nj->n", normal, covariance, normal))


def pose_jacobian(points: Array, normals: Array, hull_pose: HullPose) -> Array:
    """Compute the Jacobian (n, 6) of points (n, 3) in M, along normals (n, 3), by the hull's pose.

    The pose is perturbed by a translation in g, and by a rotation on the right about the survey's
    middle.
    """
    return np.asarray(np.einsum("ni,nij->nj", normals, _motion_by_pose(points, hull_pose)))


def _motion_by_pose(points: Array, hull_pose: HullPose) -> Array:
    """Compute the Jacobian (n, 3, 6) of points (n, 3) in M by an error of the hull's pose."""
    to_hull = hull_pose.global_from_hull.rotation.as_matrix()[0].T
    shift = np.broadcast_to(-to_hull, (len(points), 3, 3))
    return np.concatenate([shift, cross_matrix(points - hull_pose.survey_center)], axis=2)


def shared_variance(position: Array, normal: Array, covariance: Array) -> Array:
    """Estimate the part (n,) m2 of variances along normals that neighbours have in common.

    An error that moves all landmarks is in the covariance of every neighbour, beside the
    neighbour's own variance, which is taken to be MIN_SIGMA_M^2 or more. So the common part is at
    most the smallest of the neighbours' variances along this landmark's normal, less that. The
    second smallest bounds it too, and does not hang on a single landmark. Variances along the
    neighbours' own normals, which have other directions, would not compare: an error of tens of
    metres, as of an unmeasured depth, enters them to a different degree.

    position, normal: (n, 3) m and unit vectors of the landmarks. covariance: (n, 3, 3) m2. All are
    in one frame.
    """
    if not len(position):
        return np.zeros(0)
    near, bound = Nearest(position), np.empty(len(position))
    for rows in blocks_of_rows(len(position), AT_ONCE):
        _, row = near(position[rows], min(NEIGHBOURS, len(position)))
        two_least = np.full((2, len(row)), np.inf)
        for neighbour in row.T:
            variance = along_normals(normal[rows], covariance[neighbour])
            two_least = np.sort([*two_least, variance], axis=0)[:2]
        bound[rows] = two_least[min(1, row.shape[1] - 1)]
    return np.asarray(
        np.maximum(bound - MIN_SIGMA_M**2, 0.0).clip(max=along_normals(normal, covariance))
    )


def _pose_covariance(
    position: Array, normal: Array, covariance: Array, hull_pose: HullPose | None
) -> Array:
    """Compute the part (n, 3, 3) of landmarks' covariances that comes from the hull's pose.

    position, normal, covariance: as of `shared_variance`. Zero where it cannot be a part of them
    because it is larger. Marginals of a solve, for example, contain its correlations with the
    landmarks.
    """
    found = np.zeros_like(covariance)
    if hull_pose is None:
        return found
    for rows in blocks_of_rows(len(position), AT_ONCE):
        motion = _motion_by_pose(position[rows], hull_pose)
        found[rows] = motion @ hull_pose.covariance @ motion.transpose(0, 2, 1)
        whole = along_normals(normal[rows], covariance[rows])
        if not (along_normals(normal[rows], found[rows]) <= whole * (1 + 1e-6)).all():
            return np.zeros_like(covariance)
    return found
