# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The variance of landmarks along the hull's normals: each one's own, and what they have in common (docs/methods.md 12)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.records.solution import HullPose
from hullrecon.typing import Array

MIN_SIGMA_M = 0.001  # no landmark is better than its texture's roughness


@dataclass(frozen=True, kw_only=True)
class VarianceAlongNormals:
    """own (n,) m^2: of each landmark alone, no less than its texture's roughness; common (n,) m^2: of the hull's pose and of
    the dive's place, which move neighbours as one."""

    own: Array
    common: Array


def variance_along_normals(
    position: Array, normal: Array, covariance: Array, hull_pose: HullPose | None
) -> VarianceAlongNormals:
    """Return the variance of landmarks (n, 3) with covariances (n, 3, 3) along normals (n, 3), all in one frame.

    hull_pose: whose error the covariances hold as a sum, None where they hold none; it moves all landmarks as one, and is no
    noise of theirs however large it is.
    """
    whole = np.einsum("ni,nij,nj->n", normal, covariance, normal)
    by_pose = _pose_variance(position, normal, whole, hull_pose)
    shared = shared_variance(position, whole - by_pose)
    return VarianceAlongNormals(
        own=np.maximum(whole - by_pose - shared, 0.0) + MIN_SIGMA_M**2,
        common=by_pose + shared,
    )


def pose_jacobian(points: Array, normals: Array, hull_pose: HullPose) -> Array:
    """Return how points (n, 3) in M move along normals (n, 3) with an error of T_g_M: (n, 6), translation in g, rotation
    perturbed on the right about the survey's middle."""
    to_hull = hull_pose.global_from_hull.rotation.as_matrix()[0].T
    turn = np.einsum("ni,nij->nj", normals, cross_matrix(points - hull_pose.survey_center))
    return np.concatenate([-normals @ to_hull, turn], axis=1)


def shared_variance(position: Array, variance: Array, neighbours: int = 32) -> Array:
    """Return the part of each variance (n,) that neighbours have in common: hardly more than the best of them has."""
    if not len(position):
        return variance
    _, row = nearest(position, position, min(neighbours, len(position)))
    return np.maximum(np.sort(variance[row], axis=1)[:, min(1, row.shape[1] - 1)] - MIN_SIGMA_M**2, 0.0).clip(max=variance)


def _pose_variance(position: Array, normal: Array, variance: Array, hull_pose: HullPose | None) -> Array:
    """Return the part of variances (n,) along normals (n, 3) that comes from the hull's pose; zero where it is no part of them
    (as published they hold its correlations too)."""
    if hull_pose is None:
        return np.zeros(len(variance))
    by_pose = pose_jacobian(position, normal, hull_pose)
    found = np.einsum("ni,ij,nj->n", by_pose, hull_pose.covariance, by_pose)
    return found if (found <= variance * (1 + 1e-6)).all() else np.zeros(len(variance))
