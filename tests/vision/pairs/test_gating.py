# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import exp
from hullrecon.vision.pairs.gating import Motion, transfer

XY = np.array([[0.0, 0.0], [0.3, -0.2], [-0.25, 0.1]])
DEPTH = np.array([1.3, 1.5, 1.2])
SIGMA = np.full(3, 0.01)


@pytest.fixture
def motion():
    root = np.diag([0.01, 0.02, 0.01, 0.004, 0.006, 0.003]) @ (np.eye(6) + 0.2 * np.tri(6, k=-1))
    return Motion(exp([[0.15, 0.02, -0.03, 0.01, -0.05, 0.02]]).matrix()[0], root @ root.T)


def look(motion, xy, depth):
    points = np.hstack([xy, np.ones((len(xy), 1))]) * depth[:, None]
    seen = points @ motion[..., :3, :3].swapaxes(-1, -2) + motion[..., None, :3, 3]
    return seen[..., :2] / seen[..., 2:]


def test_centimetre_sideways_is_centimetre_over_depth():
    exact = Motion(np.eye(4), np.diag([0.01**2, 0, 0, 0, 0, 0]))
    mean, covariance = transfer(exact, np.zeros((1, 2)), np.array([2.0]), np.zeros(1), 1e-6)
    np.testing.assert_allclose(mean, 0, atol=1e-12)
    np.testing.assert_allclose(np.sqrt(covariance[0, 0, 0]), 0.005, rtol=1e-3)
    assert covariance[0, 1, 1] < 1e-10


def test_depth_counts_through_baseline_alone():
    step = np.eye(4)
    step[0, 3] = 0.3
    spread = [
        transfer(
            Motion(m, np.zeros((6, 6))), np.zeros((1, 2)), np.array([1.5]), np.array([0.05]), 1e-6
        )[1]
        for m in (np.eye(4), step)
    ]
    assert spread[0][0, 0, 0] < 1e-10
    # b sigma / z^2
    np.testing.assert_allclose(np.sqrt(spread[1][0, 0, 0]), 0.3 * 0.05 / 1.5**2, rtol=0.02)


def test_ellipse_is_that_of_many_random_draws(motion):
    rng = np.random.default_rng(0)
    draw = rng.multivariate_normal(np.zeros(6), motion.covariance, 20_000)
    many = np.tile(motion.second_from_first, (len(draw), 1, 1))
    many[:, :3, 3] += draw[:, :3]
    many[:, :3, :3] = many[:, :3, :3] @ Rotation.from_rotvec(draw[:, 3:]).as_matrix()
    mean, covariance = transfer(motion, XY, DEPTH, SIGMA, 0.001)
    for k in range(3):
        depth = DEPTH[k] + 0.01 * rng.standard_normal(len(draw))
        ray = np.append(XY[k], 1.0) + np.column_stack(
            [0.001 * rng.standard_normal((len(draw), 2)), np.zeros(len(draw))]
        )
        seen = np.einsum("nij,nj->ni", many[:, :3, :3], ray * depth[:, None]) + many[:, :3, 3]
        image = seen[:, :2] / seen[:, 2:] + 0.001 * rng.standard_normal((len(draw), 2))
        np.testing.assert_allclose(mean[k], image.mean(axis=0), atol=3e-4)
        np.testing.assert_allclose(
            covariance[k], np.cov(image.T), atol=0.05 * np.trace(covariance[k])
        )


def test_feature_without_depth_is_nowhere(motion):
    mean, _ = transfer(motion, XY, np.array([np.nan, 1.5, 1.2]), SIGMA, 0.001)
    assert np.isnan(mean[0]).all()
    assert np.isfinite(mean[1:]).all()


def test_point_behind_second_camera_is_nowhere():
    turned = Motion(exp([[0, 0, 0, 0, np.pi, 0]]).matrix()[0], np.zeros((6, 6)))
    assert np.isnan(transfer(turned, XY, DEPTH, SIGMA, 0.001)[0]).all()


def test_inverse_motion_brings_points_back(motion):
    np.testing.assert_allclose(
        motion.inverse().second_from_first @ motion.second_from_first, np.eye(4), atol=1e-12
    )


def test_inverse_carries_covariance_as_random_draws_do(motion):
    rng = np.random.default_rng(1)
    small = Motion(motion.second_from_first, motion.covariance * 1e-4)
    draw = rng.multivariate_normal(np.zeros(6), small.covariance, 20_000)
    rotation = motion.second_from_first[:3, :3] @ Rotation.from_rotvec(draw[:, 3:]).as_matrix()
    back_t = -np.einsum("nji,nj->ni", rotation, motion.second_from_first[:3, 3] + draw[:, :3])
    turn = motion.second_from_first[:3, :3] @ rotation.swapaxes(1, 2)
    gap = np.hstack(
        [back_t - small.inverse().second_from_first[:3, 3], Rotation.from_matrix(turn).as_rotvec()]
    )
    want = small.inverse().covariance
    np.testing.assert_allclose(np.cov(gap.T), want, atol=0.03 * np.abs(want).max())
