# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.pose_solver import LinearisedCost, minimise_over_pose
from hullrecon.geometry.poses import Poses, exp, identity
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array

SOURCE = np.random.default_rng(0).normal(size=(12, 3))
SOURCE -= SOURCE.mean(axis=0)  # so that a turn cannot make up for a shift
TRUTH = exp([[0.3, -0.2, 0.5, 0.4, -0.3, 0.2]])


def moved(pose: Poses, step: Array) -> Poses:
    return Poses((pose.rotation * exp(step[None]).rotation).as_quat(), pose.translation + step[:3])


def point_to_point(target: Array) -> object:
    def linearise(pose: Poses) -> LinearisedCost:
        residual = (pose.apply(SOURCE) - target).ravel()
        rotation = pose.rotation.as_matrix()[0]
        jacobian = np.concatenate(
            [np.tile(np.eye(3), (len(SOURCE), 1, 1)), -rotation @ cross_matrix(SOURCE)], axis=2
        ).reshape(-1, 6)
        return LinearisedCost(
            cost=0.5 * float(residual @ residual),
            gradient=jacobian.T @ residual,
            information=jacobian.T @ jacobian,
        )

    return linearise


def test_the_pose_of_least_cost_is_that_of_the_closed_form() -> None:
    target = TRUTH.apply(SOURCE) + np.random.default_rng(1).normal(scale=0.05, size=SOURCE.shape)
    found = minimise_over_pose(
        identity(), point_to_point(target), moved, max_iterations=50, min_relative_decrease=1e-14
    )
    np.testing.assert_allclose(found.pose.matrix(), fit_rigid(SOURCE, target).matrix(), atol=1e-6)
    assert np.abs(found.at_minimum.gradient).max() < 1e-5


def test_directions_that_are_not_free_are_not_moved_along() -> None:
    no_x = np.eye(6)[:, 1:]
    found = minimise_over_pose(
        identity(),
        point_to_point(SOURCE + np.array([1.0, 2.0, 3.0])),
        moved,
        max_iterations=50,
        min_relative_decrease=1e-12,
        free_directions=lambda _: no_x,
    )
    assert found.pose.translation[0, 0] == 0
    assert found.pose.translation[0, 1:] == pytest.approx([2.0, 3.0], abs=1e-3)


def test_a_cost_that_cannot_fall_ends_where_it_began() -> None:
    start = exp([[0.1, 0, 0, 0, 0, 0.1]])

    def rising(pose: Poses) -> LinearisedCost:
        at_start = np.allclose(pose.matrix(), start.matrix(), atol=0)
        return LinearisedCost(
            cost=1.0 if at_start else 2.0, gradient=np.ones(6), information=np.eye(6)
        )

    found = minimise_over_pose(start, rising, moved, max_iterations=100)
    assert np.array_equal(found.pose.matrix(), start.matrix())
