# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Derivatives of poses and planes in each other's frames, beside differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hullrecon.geometry.poses import Poses, exp
from hullrecon.studies.sessions.motions import between, compose, errors, moved, plane_in, plane_out

RNG = np.random.default_rng(0)
FIRST, SECOND = (exp(RNG.normal(size=(3, 6))) for _ in range(2))
PLANES = 3 * RNG.normal(size=(3, 3))
STEP = 1e-6


def numeric(of: Callable[[Poses], np.ndarray], at: Poses) -> np.ndarray:
    """Differentiate (n, d) by the six numbers of poses: (n, d, 6)."""
    steps = [np.tile(STEP * unit, (len(at), 1)) for unit in np.eye(6)]
    return np.stack([(of(moved(at, s)) - of(moved(at, -s))) / (2 * STEP) for s in steps], axis=-1)


def off(poses: Poses, about: Poses) -> np.ndarray:
    turn = (about.rotation.inv() * poses.rotation).as_rotvec()
    return np.hstack([poses.translation - about.translation, turn])


def test_derivatives_of_composition_are_those_of_differences() -> None:
    for of in (compose, between):
        whole, by_first, by_second = of(FIRST, SECOND)
        first = numeric(lambda x, of=of, at=whole: off(of(x, SECOND)[0], at), FIRST)
        second = numeric(lambda x, of=of, at=whole: off(of(FIRST, x)[0], at), SECOND)
        np.testing.assert_allclose(by_first, first, atol=1e-8)
        np.testing.assert_allclose(by_second, second, atol=1e-8)


def test_derivative_of_an_error_is_that_of_differences() -> None:
    np.testing.assert_allclose(
        errors(FIRST, SECOND)[1], numeric(lambda x: errors(FIRST, x)[0], SECOND), atol=1e-7
    )


def test_derivatives_of_planes_are_those_of_differences() -> None:
    _, by_pose, by_plane = plane_in(FIRST, PLANES)
    np.testing.assert_allclose(by_pose, numeric(lambda x: plane_in(x, PLANES)[0], FIRST), atol=1e-7)
    step = STEP * np.eye(3)
    plane = np.stack(
        [
            (plane_in(FIRST, PLANES + s)[0] - plane_in(FIRST, PLANES - s)[0]) / (2 * STEP)
            for s in step
        ],
        axis=-1,
    )
    np.testing.assert_allclose(by_plane, plane, atol=1e-7)


def test_a_plane_that_is_seen_and_put_back_is_the_same() -> None:
    np.testing.assert_allclose(plane_out(FIRST, plane_in(FIRST, PLANES)[0]), PLANES, atol=1e-12)


def test_points_of_a_plane_stay_on_it_in_another_frame() -> None:
    normal = PLANES / np.linalg.norm(PLANES, axis=1, keepdims=True)
    points = -PLANES + np.cross(normal, RNG.normal(size=(3, 3)))
    seen, there = plane_in(FIRST, PLANES)[0], FIRST.inverse().apply(points)
    np.testing.assert_allclose(np.sum(seen * there, axis=1), -np.sum(seen**2, axis=1), atol=1e-12)
