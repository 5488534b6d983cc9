# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hullrecon.geometry.poses import exp
from hullrecon.geometry.rigid_fit import fit_rigid, fit_scale


@given(st.integers(0, 10**6))
def test_the_motion_of_moved_points_is_found(seed: int) -> None:
    rng = np.random.default_rng(seed)
    motion, points = exp(rng.normal(size=(1, 6))), rng.normal(size=(5, 3))
    found = fit_rigid(points, motion.apply(points))
    np.testing.assert_allclose(found.matrix(), motion.matrix(), atol=1e-9)


def test_sets_are_fitted_in_batches() -> None:
    rng = np.random.default_rng(1)
    motions, points = exp(rng.normal(size=(4, 6))), rng.normal(size=(4, 6, 3))
    moved = np.stack([motions[k].apply(points[k]) for k in range(4)])
    np.testing.assert_allclose(fit_rigid(points, moved).matrix(), motions.matrix(), atol=1e-9)


def test_mirrored_points_are_turned_and_not_mirrored() -> None:
    points = np.random.default_rng(2).normal(size=(8, 3))
    found = fit_rigid(points, points * [1, 1, -1])
    assert np.linalg.det(found.rotation.as_matrix()[0]) == pytest.approx(1.0)


def test_no_other_small_motion_leaves_less() -> None:
    rng = np.random.default_rng(3)
    points, target = rng.normal(size=(10, 3)), rng.normal(size=(10, 3))
    found = fit_rigid(points, target)
    least = np.sum((found.apply(points) - target) ** 2)
    for step in np.vstack([np.eye(6), -np.eye(6)]) * 1e-3:
        assert np.sum(((found @ exp(step)).apply(points) - target) ** 2) > least


def test_the_scale_of_a_similarity_is_found_after_its_rigid_part() -> None:
    rng = np.random.default_rng(4)
    points, motion = rng.normal(size=(9, 3)), exp(rng.normal(size=(1, 6)))
    target = motion.apply(1.02 * (points - points.mean(axis=0)) + points.mean(axis=0))
    assert fit_scale(points, target, fit_rigid(points, target)) == pytest.approx(1.02)


@given(st.integers(0, 10**6))
def test_a_fit_moves_with_its_target_and_against_its_source(seed: int) -> None:
    rng = np.random.default_rng(seed)
    source, target, motion = (
        rng.normal(size=(6, 3)),
        rng.normal(size=(6, 3)),
        exp(rng.normal(size=(1, 6))),
    )
    plain = fit_rigid(source, target).matrix()[0]
    np.testing.assert_allclose(
        fit_rigid(source, motion.apply(target)).matrix()[0], motion.matrix()[0] @ plain, atol=1e-6
    )
    against = plain @ motion.inverse().matrix()[0]
    np.testing.assert_allclose(
        fit_rigid(motion.apply(source), target).matrix()[0], against, atol=1e-6
    )


@given(st.integers(0, 10**6))
def test_three_points_in_a_plane_are_enough(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points, motion = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0]]), exp(rng.normal(size=(1, 6)))
    np.testing.assert_allclose(
        fit_rigid(points, motion.apply(points)).matrix(), motion.matrix(), atol=1e-9
    )


@given(st.integers(0, 10**6), st.floats(0.5, 2.0))
def test_any_scale_is_found_and_no_other_leaves_less(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    points, motion = rng.normal(size=(9, 3)), exp(rng.normal(size=(1, 6)))
    middle = points.mean(axis=0)
    target = motion.apply(scale * (points - middle) + middle) + rng.normal(scale=0.01, size=(9, 3))
    found = fit_scale(points, target, motion)
    assert found == pytest.approx(scale, abs=0.05)
    turned, wanted = motion.rotation.apply(points - middle), target - target.mean(axis=0)
    left = [
        np.sum((factor * turned - wanted) ** 2) for factor in (found, found - 1e-3, found + 1e-3)
    ]
    assert left[0] == min(left)
