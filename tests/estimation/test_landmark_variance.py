# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A landmark's own variance along the hull's normal, told from what all have in common."""

from __future__ import annotations

import numpy as np

from hullrecon.estimation.landmark_variance import (
    MIN_SIGMA_M,
    pose_jacobian,
    shared_variance,
    variance_along_normals,
)
from hullrecon.geometry.poses import exp
from hullrecon.records.solution import HullPose

N = 200
POSE = HullPose(
    global_from_hull=exp(np.array([3.0, -1, 2, 0.2, -0.1, 1.3])),
    covariance=np.diag([0.3, 0.3, 0.1, 0.03, 0.03, 0.05]) ** 2,
    survey_center=np.array([2.0, 0, 2]),
)


def wall() -> tuple[np.ndarray, np.ndarray]:
    """Points on y = 0 and their normals."""
    rng = np.random.default_rng(3)
    return np.column_stack([rng.uniform(0, 4, N), np.zeros(N), rng.uniform(0, 4, N)]), np.tile(
        [0.0, 1, 0], (N, 1)
    )


def along_normal(variance: np.ndarray) -> np.ndarray:
    return np.einsum("n,ij->nij", variance, np.diag([0.0, 1, 0])) + 0.04 * np.diag([1.0, 0, 1])


def test_hull_pose_part_is_common_to_landmarks() -> None:
    position, normal = wall()
    by_pose = pose_jacobian(position, normal, POSE)
    common = np.einsum("ni,ij,nj->n", by_pose, POSE.covariance, by_pose)
    assert common.max() > common.min() + 0.003**2
    found = variance_along_normals(position, normal, along_normal(common + 0.003**2), POSE)
    np.testing.assert_allclose(
        found.own + found.common, common + 0.003**2 + MIN_SIGMA_M**2, rtol=1e-3
    )
    np.testing.assert_array_less(found.own, 0.0032**2)


def test_without_a_pose_what_neighbours_have_in_common_is_common() -> None:
    position, normal = wall()
    own = np.where(np.arange(N) % 4 == 0, 0.001, 0.004) ** 2
    found = variance_along_normals(position, normal, along_normal(0.05**2 + own), None)
    np.testing.assert_allclose(found.common, 0.05**2, rtol=1e-3)
    np.testing.assert_allclose(found.own, own, atol=2 * MIN_SIGMA_M**2)


def test_covariances_without_pose_are_kept() -> None:
    position, normal = wall()
    small = along_normal(np.full(N, 0.002**2))
    with_pose, without = (
        variance_along_normals(position, normal, small, pose) for pose in (POSE, None)
    )
    np.testing.assert_array_equal(with_pose.own, without.own)
    np.testing.assert_array_equal(with_pose.common, without.common)


def test_no_landmark_shares_nothing() -> None:
    assert shared_variance(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3, 3))).shape == (0,)


def test_unmeasured_depth_is_common_to_leaning_normals() -> None:
    """Ten metres along z, as without a pressure sensor: a normal that leans by a degree takes 17 cm
    of it.
    """
    position, normal = wall()
    normal = normal + np.random.default_rng(5).normal(0, 0.02, (N, 1)) * [0, 0, 1]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    covariance = np.tile(np.diag([0.002**2, 0.002**2, 10.0**2]), (N, 1, 1))
    found = variance_along_normals(position, normal, covariance, None)
    np.testing.assert_array_less(found.own, 2 * 0.002**2)
    assert np.sqrt(found.common.max()) > 0.4
