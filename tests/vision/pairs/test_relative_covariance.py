# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How well the relative pose of two nodes is known: worked out by hand, and by sampling."""

import numpy as np
import pytest

from hullrecon.geometry.poses import Poses, exp
from hullrecon.records.trajectory import TrajectoryErrorModel
from hullrecon.vision.pairs.camera_track import (
    WHITE_ROTATION_RAD,
    WHITE_TRANSLATION_M,
    CameraTrack,
    NavigationErrors,
)


def model(n, by_error=None, sigma=(), walk=None, white=None):
    none = np.zeros((n, 6, 6))
    return TrajectoryErrorModel(
        by_error=np.zeros((n, 6, 0)) if by_error is None else by_error,
        error_covariance=np.diag(np.square(np.asarray(sigma, float))),
        walk=none if walk is None else walk,
        white=none if white is None else white,
    )


def level(places):
    n = len(places)
    return Poses(np.tile([0, 0, 0, 1.0], (n, 1)), np.asarray(places, float))


def by_scale(poses):
    out = np.zeros((len(poses), 6, 1))
    out[:, :3, 0] = poses.translation
    return out


def by_heading(n):
    out = np.zeros((n, 6, 1))
    out[:, 5, 0] = 1.0
    return out


def dead_reckoned(poses, errors):
    return CameraTrack(
        global_from_camera=poses, errors=NavigationErrors(global_from_camera=poses, model=errors)
    )


def relative(track, first, second):
    return track.errors.relative_covariance(np.array([first]), np.array([second]))[0]


def test_nodes_on_either_side_of_start_share_no_scale_error():
    """Each is off by 1 % of 10 m, the other way; the difference of their covariances would be
    nothing.
    """
    poses = level([[10.0, 0, 0], [-10.0, 0, 0]])
    found = relative(dead_reckoned(poses, model(2, by_scale(poses), [0.01])), 0, 1)
    np.testing.assert_allclose(found[:3, :3], np.diag([0.2**2, 0, 0]), atol=1e-15)


def test_return_to_a_place_has_no_error_of_scale():
    poses = level([[10.0, 4.0, 0], [30.0, 4.0, 0], [10.0, 4.0, 0]])
    track = dead_reckoned(poses, model(3, by_scale(poses), [0.01]))
    np.testing.assert_allclose(relative(track, 0, 2), 0, atol=1e-15)
    assert relative(track, 0, 1)[0, 0] == pytest.approx(0.2**2)


def test_constant_heading_error_leaves_relative_poses():
    poses = exp([[30.0, 5.0, 2.0, 0.1, 0.2, 0.3], [32.0, -4.0, 1.0, 0.0, -0.2, 1.3]])
    found = relative(dead_reckoned(poses, model(2, by_heading(2), [0.1])), 0, 1)
    np.testing.assert_allclose(found, 0, atol=1e-14)


def test_turn_of_second_node_swings_first_about_it():
    poses = level([[2.0, 0, 0], [0.0, 0, 0]])
    errors = by_heading(2)
    errors[0] = 0.0
    found = relative(dead_reckoned(poses, model(2, errors, [0.01])), 0, 1)
    np.testing.assert_allclose(np.diag(found), [0, 0.02**2, 0, 0, 0, 0.01**2], atol=1e-15)


def test_errors_accumulated_between_nodes_count_alone():
    walk = np.zeros((5, 6, 6))
    walk[:, 0, 0] = [0.0, 1.0, 4.0, 5.0, 9.0]
    track = dead_reckoned(level(np.zeros((5, 3))), model(5, walk=walk))
    assert relative(track, 2, 4)[0, 0] == relative(track, 4, 2)[0, 0] == 5.0


def test_what_is_new_at_each_node_counts_twice():
    white = np.tile(np.diag([1.0, 0, 0, 0, 0, 0]), (2, 1, 1))
    track = dead_reckoned(level(np.zeros((2, 3))), model(2, white=white))
    assert relative(track, 0, 1)[0, 0] == 2.0
    assert track.relative_sigma(np.array([0]), np.array([1]))[0] == pytest.approx(np.sqrt(2 / 3))


def test_batch_gives_what_each_pair_gives_alone():
    rng = np.random.default_rng(2)
    track = dead_reckoned(
        exp(rng.normal(0, 1, (6, 6))), model(6, rng.normal(0, 1, (6, 6, 3)), [0.1, 0.2, 0.3])
    )
    first, second = np.array([0, 5, 3]), np.array([2, 1, 4])
    together = track.errors.relative_covariance(first, second)
    for k in range(3):
        np.testing.assert_allclose(together[k], relative(track, first[k], second[k]), atol=1e-15)


def test_relative_poses_scatter_as_their_covariance_says():
    """Ten thousand dives: errors that persist, a walk and white noise, put on the poses exactly."""
    rng = np.random.default_rng(4)
    poses = exp([[3.0, 1.0, 2.0, 0.2, -0.1, 0.4], [4.0, -2.0, 1.5, -0.3, 0.1, 2.0]])
    by_error, sigma = rng.normal(0, 1, (2, 6, 2)), np.array([0.003, 0.002])
    roots = [0.002 * rng.normal(0, 1, (6, 6)) for _ in range(4)]
    gained = [root @ root.T for root in roots]
    walk = np.stack([gained[0], gained[0] + gained[1]])
    track = dead_reckoned(poses, model(2, by_error, sigma, walk, np.stack(gained[2:])))
    n = 10_000
    cause = sigma * rng.standard_normal((n, 2))
    steps = [rng.standard_normal((n, 6)) @ root.T for root in roots]
    twist_a = cause @ by_error[0].T + steps[0] + steps[2]
    twist_b = cause @ by_error[1].T + steps[0] + steps[1] + steps[3]
    found = (exp(twist_b) @ poses[[1]]).inverse() @ (exp(twist_a) @ poses[[0]])
    wanted = poses[[1]].inverse() @ poses[[0]]
    error = np.hstack(
        [
            found.translation - wanted.translation,
            (wanted.rotation.inv() * found.rotation).as_rotvec(),
        ]
    )
    predicted = relative(track, 0, 1)
    np.testing.assert_allclose(np.cov(error.T), predicted, atol=0.06 * predicted.max())


def test_motion_adds_what_model_does_not_hold():
    motion = dead_reckoned(level([[1.0, 0, 0], [0, 0, 0]]), model(2)).motion(0, 1)
    np.testing.assert_allclose(motion.second_from_first[:3, 3], [1, 0, 0])
    np.testing.assert_allclose(
        np.diag(motion.covariance), [WHITE_TRANSLATION_M**2] * 3 + [WHITE_ROTATION_RAD**2] * 3
    )
