# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from hullrecon.adjustment.hull_pose.pose_cost import perturb_pose
from hullrecon.adjustment.results.covariance import hull_axes, points_in_hull, poses_in_hull
from hullrecon.geometry import poses
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import cross_matrix

HULL = poses.from_rpy([9.0, 35.0, 3.8], np.radians([-179.3, 0.4, -96.0]))
NODES = poses.from_rpy([[1.0, 2.0, 2.0], [4.0, 1.0, 2.5]], [[0.02, -0.1, 0.3], [0.0, 0.2, -0.4]])
CENTER = np.array([33.0, 4.0, 2.0])


def moved(nodes, step):
    turned = nodes.rotation * poses.exp(np.c_[np.zeros((len(nodes), 3)), step[:, 3:]]).rotation
    return Poses(turned.as_quat(), nodes.translation + step[:, :3])


def samples_of_a_joint_normal(rng, count=4000):
    root = (
        rng.standard_normal((12, 12))
        * np.r_[np.full(3, 2e-3), np.full(3, 1e-3), np.full(3, 3e-3), np.full(3, 1e-3)][:, None]
        / 3
    )
    return root @ root.T, rng.standard_normal((count, 12)) @ root.T


def test_covariance_of_a_pose_in_the_hull_equals_sampling():
    rng = np.random.default_rng(0)
    joint, draws = samples_of_a_joint_normal(rng)
    one = NODES[1]
    found = poses_in_hull(
        joint[None, :6, :6], joint[None, :6, 6:], joint[6:, 6:], one, HULL, CENTER
    )[0]
    many = moved(one[np.zeros(len(draws), int)], draws[:, :6])
    drawn = [
        (perturb_pose(HULL, CENTER, d[6:]).inverse() @ many[i]).vectors()
        for i, d in enumerate(draws)
    ]
    in_hull = Poses(np.vstack(drawn)[:, 3:], np.vstack(drawn)[:, :3])
    mean = HULL.inverse() @ one
    error = np.c_[
        in_hull.translation - mean.translation, (mean.rotation.inv() * in_hull.rotation).as_rotvec()
    ]
    spread = np.sqrt(np.diag(found))
    np.testing.assert_allclose(
        np.cov(error.T) / np.outer(spread, spread), found / np.outer(spread, spread), atol=0.08
    )


def test_a_hull_known_exactly_only_turns_the_axes():
    sigma = np.diag([1.0, 4.0, 9.0, 0.0, 0.0, 0.0])[None] * 1e-6
    found = poses_in_hull(sigma, np.zeros((1, 6, 6)), np.zeros((6, 6)), NODES[0], HULL, CENTER)[0]
    to_hull = HULL.rotation.as_matrix()[0].T
    np.testing.assert_allclose(found[:3, :3], to_hull @ sigma[0, :3, :3] @ to_hull.T, atol=1e-15)


def test_a_turning_hull_moves_far_points_most():
    hull = np.zeros((6, 6))
    hull[5, 5] = 1e-6  # 1 mrad about M's z axis through the centre
    position = HULL.apply(CENTER + np.array([[0.0, 0, 0], [2.0, 0, 0]]))
    found = points_in_hull(np.zeros((2, 3, 3)), np.zeros((2, 3, 6)), hull, position, HULL, CENTER)
    np.testing.assert_allclose(found[0], 0.0, atol=1e-15)
    np.testing.assert_allclose(np.sqrt(found[1, 1, 1]), 2e-3, rtol=1e-6)


def test_cross_matrices_are_cross_products():
    rng = np.random.default_rng(1)
    a, b = rng.standard_normal((2, 5, 3))
    np.testing.assert_allclose(np.einsum("nij,nj->ni", cross_matrix(a), b), np.cross(a, b))


def test_translation_of_the_hull_is_turned_into_its_axes():
    along = HULL.rotation.as_matrix()[0][:, 0]
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = 0.25 * np.outer(along, along)
    np.testing.assert_allclose(hull_axes(covariance, HULL)[0, 0], 0.25)
