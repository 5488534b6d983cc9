# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.poses import Poses, exp
from hullrecon.studies.scenes.ellipsoid_dive import (
    MOUNT_SIGMA,
    POLE_DEPTH_M,
    RANGE_SIGMA_M,
    STEP_M,
    STEP_S,
    TRAY_ORIGIN_M,
    EllipsoidDive,
    measured_dive,
    measured_steps,
    reckoned,
    spiral_around_a_sphere,
)

RADIUS_M, DRIFT = 6.0, 30.0


@pytest.fixture(scope="module")
def spiral() -> EllipsoidDive:
    return spiral_around_a_sphere(1, radius_m=RADIUS_M, turns=1.0, drift_deg_per_hour=DRIFT)


def ends(dive: EllipsoidDive, path: Poses) -> np.ndarray:
    dvl = path @ Poses(np.array([[0, 0, 0, 1.0]]), TRAY_ORIGIN_M[None])
    return dvl[dive.returns.node].apply(dive.returns.range_m[:, None] * dive.returns.beam)


def test_spiral_goes_round_sphere_once_turn_half_metre_deeper(
    spiral: EllipsoidDive,
) -> None:
    from_middle = spiral.truth.translation - [RADIUS_M, 0, POLE_DEPTH_M]
    np.testing.assert_allclose(np.linalg.norm(from_middle, axis=1), RADIUS_M + 1.2)
    assert from_middle[-1, 2] - from_middle[0, 2] == pytest.approx(0.5, abs=0.01)
    step = np.linalg.norm(np.diff(spiral.truth.translation, axis=0), axis=1)
    np.testing.assert_allclose(step, STEP_M, rtol=0.01)
    assert step.sum() == pytest.approx(2 * np.pi * (RADIUS_M + 1.2), rel=0.01)


def test_beams_end_on_sphere_up_to_noise_and_turn_of_mount(
    spiral: EllipsoidDive,
) -> None:
    off = (
        np.linalg.norm(ends(spiral, spiral.truth) - [RADIUS_M, 0, POLE_DEPTH_M], axis=1) - RADIUS_M
    )
    assert RANGE_SIGMA_M * 0.7 < off.std() < RANGE_SIGMA_M + 3 * MOUNT_SIGMA
    assert abs(off.mean()) < 0.01


def test_trajectory_and_returns_have_same_clock(spiral: EllipsoidDive) -> None:
    np.testing.assert_array_equal(spiral.returns.t_ns, spiral.trajectory.t_ns[spiral.returns.node])
    assert np.diff(spiral.trajectory.t_ns).tolist() == [int(STEP_S * 1e9)] * (len(spiral.truth) - 1)


def test_heading_drifts_as_told(spiral: EllipsoidDive) -> None:
    turn = (spiral.truth.rotation.inv() * spiral.trajectory.poses().rotation).as_rotvec()[:, 2]
    hours = STEP_S * (len(spiral.truth) - 1) / 3600
    # white noise of 0.0002 rad a step
    assert abs(np.degrees(turn[-1])) == pytest.approx(DRIFT * hours, abs=0.8)


def test_what_hangs_before_hull_shortens_ranges() -> None:
    truth = Poses(
        np.tile([0, 0, 0, 1.0], (3, 1)), np.array([[-1.2, 0.1 * k, POLE_DEPTH_M] for k in range(3)])
    )
    axes = np.array([5.0, 30.0, 6.0])
    bare, hung = (
        measured_dive(
            np.random.default_rng(0), truth, 0.0, axes, nearer_m=off
        ).returns.range_m.reshape(3, 4)
        for off in (0.0, np.array([0.0, 0.3, 0.0]))
    )
    np.testing.assert_array_equal(hung[[0, 2]], bare[[0, 2]])
    np.testing.assert_allclose(bare[1] - hung[1], 0.3 / 0.75**0.5, atol=0.02)


def test_steps_without_error_give_path_back() -> None:
    truth = exp(np.random.default_rng(2).normal(0, 0.3, (6, 6))).matrix()
    steps = measured_steps(
        np.random.default_rng(0), truth, np.zeros(6), np.zeros(3), 1.0, np.zeros(6)
    )
    np.testing.assert_allclose(reckoned(truth[0], steps, 1.0).poses().matrix(), truth, atol=1e-12)


def test_errors_of_step_are_those_that_its_derivatives_say() -> None:
    truth = exp(np.random.default_rng(3).normal(0, 0.3, (5, 6))).matrix()
    errors = np.array([0.01, 1e-3]), np.array([2e-3, -1e-3, 3e-3])
    right, wrong = (
        measured_steps(
            np.random.default_rng(0), truth, k * errors[0], k * errors[1], 2.0, np.zeros(6)
        )
        for k in (0, 1)
    )
    said = right.by_navigation @ errors[0] + right.by_mount @ errors[1]
    np.testing.assert_allclose(right.translation - wrong.translation, said[:, :3], atol=1e-12)
