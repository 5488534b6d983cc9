# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A vehicle found again in an old map by planes."""

from __future__ import annotations

import numpy as np

from hullrecon.studies.sessions.motions import plane_in
from hullrecon.studies.sessions.particles import (
    FREE_M,
    as_poses,
    drawn_again,
    moved_on,
    plane_distances,
    spread,
    weights,
)
from hullrecon.studies.sessions.particles_study import old_map, run

MAP = old_map(np.random.default_rng(0))


def metres_outside(place: np.ndarray) -> np.ndarray:
    plane = MAP.planes[MAP.nearest(place)[0]]
    norm = np.linalg.norm(plane, axis=1)
    return np.asarray(-(np.sum(plane * place, axis=1) + norm**2) / norm)


def test_the_vehicle_is_among_the_candidates() -> None:
    rng = np.random.default_rng(1)
    trials = [run(MAP, rng) for _ in range(3)]
    assert all(trial.found for trial in trials)
    assert all(trial.true[-1] > 0 for trial in trials)
    assert max(trial.images[-1] for trial in trials) < 0.7 * len(MAP.poses)


def test_particles_start_before_the_hull_within_three_metres() -> None:
    particles = spread(MAP, 2.0, 300, np.random.default_rng(0))
    outside = metres_outside(as_poses(particles, 2.0).translation)
    assert outside.min() > 0
    assert outside.max() < FREE_M


def test_each_of_the_two_rules_for_free_cells_alone_as_printed_leaves_too_many() -> None:
    """[Ozog2016 2.4.3.1] prints those outside the nearest plane, Fig. 2.10 those within 3 m."""
    ends = np.array([of(MAP.poses.translation[:, :2], axis=0) for of in (np.min, np.max)])
    x, y = np.meshgrid(*np.linspace(ends[0] - FREE_M, ends[1] + FREE_M, 40).T)
    place = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 2.0)])
    outside = metres_outside(place)
    assert (outside[outside > 0] > FREE_M).mean() > 0.3
    assert (outside[np.abs(outside) < FREE_M] < 0).mean() > 0.3  # in the hull


def test_the_right_pose_has_the_largest_weight_and_not_as_printed() -> None:
    """The print weighs by the squared distance itself: the worst would weigh most."""
    where = 30
    right = MAP.poses[[where]]
    rpy = right.rotation.as_euler("xyz")[0]
    particle = np.r_[right.translation[0, :2], rpy[2]]
    others = particle + np.array([[0, 0, 0], [0, 0.6, 0], [0, 0, 0.3]])
    poses = as_poses(others, float(right.translation[0, 2]))
    seen = plane_in(right, MAP.planes[[where]])[0][0]
    distances, sigmas = plane_distances(MAP, poses, seen)
    assert np.argmax(weights(distances, sigmas)) == 0
    assert np.argmax(distances) != 0  # the printed weight


def test_the_print_takes_the_nodes_pose_for_the_particles_own() -> None:
    """Every particle near one node would have one weight, whatever its heading."""
    node = MAP.poses[[30]]
    by_node = plane_in(node, MAP.planes[[30]])[0]
    turned = as_poses(
        np.r_[node.translation[0, :2], node.rotation.as_euler("xyz")[0, 2] + 0.5][None],
        float(node.translation[0, 2]),
    )
    assert np.linalg.norm(plane_in(turned, MAP.planes[[30]])[0] - by_node) > 0.3


def test_particles_move_in_their_own_frames() -> None:
    particles = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, np.pi / 2]])
    moved = moved_on(particles, np.r_[1.0, 0.0, 0.0], np.zeros(3), np.random.default_rng(0))
    np.testing.assert_allclose(moved[:, :2], [[1, 0], [0, 1]], atol=1e-12)


def test_particles_are_drawn_by_their_weights() -> None:
    particles = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0]])[np.repeat([0, 1], 50)]
    weight = np.repeat([0.018, 0.002], 50)
    again = drawn_again(particles, weight, np.random.default_rng(0))
    assert 85 <= (again[:, 0] < 50).sum() <= 95
