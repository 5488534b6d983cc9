# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The car, its laser and poses in the plane, with what the thesis prints wrongly."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from hullrecon.studies.submaps import models
from hullrecon.studies.submaps.models import Car
from hullrecon.typing import Array

POSE = np.array([3.0, -2.0, 0.7])
OTHER = np.array([1.5, 4.0, -1.1])
POINTS = np.array([[10.0, 3.0], [-4.0, 6.0], [2.0, -9.0]])
SPEED, STEERING, STEP_S = 3.0, 0.4, 0.5


def differentiate(function: Callable[[Array], Array], at: Array) -> Array:
    step = 1e-6
    columns = []
    for axis in np.eye(len(at)):
        columns.append((function(at + step * axis) - function(at - step * axis)) / (2 * step))
    return np.stack(columns, axis=-1)


def test_compose_with_the_inverse_is_nothing() -> None:
    np.testing.assert_allclose(models.compose(POSE, models.invert(POSE)), 0.0, atol=1e-12)


def test_jacobians_of_composition_are_its_derivatives() -> None:
    by_first, by_second = models.compose_jacobians(POSE, OTHER)
    np.testing.assert_allclose(
        by_first, differentiate(lambda p: models.compose(p, OTHER), POSE), atol=1e-8
    )
    np.testing.assert_allclose(
        by_second, differentiate(lambda p: models.compose(POSE, p), OTHER), atol=1e-8
    )


def test_inverse_has_x_sin_minus_y_cos_not_as_printed() -> None:
    numeric = differentiate(models.invert, POSE)
    np.testing.assert_allclose(models.invert_jacobian(POSE), numeric, atol=1e-8)
    x, y, phi = POSE
    assert abs(-x * np.sin(phi) - y * np.cos(phi) - numeric[0, 2]) > 1.0


def test_points_are_placed_with_the_derivative_by_the_pose() -> None:
    np.testing.assert_allclose(
        models.place_by_pose(POSE, POINTS),
        differentiate(lambda p: models.place(p, POINTS).ravel(), POSE),
        atol=1e-7,
    )


def arc(pose: Array, car: Car, seconds: float) -> Array:
    """Drive the axle along the exact arc, and carry the laser along."""
    a, b = car.laser_ahead_m, car.laser_left_m
    turn = SPEED / car.wheelbase_m * np.tan(STEERING)
    axle = models.place(pose, np.array([[-a, -b]]))[0]
    heading = pose[2] + turn * seconds
    radius = SPEED / turn
    axle = axle + radius * np.array(
        [np.sin(heading) - np.sin(pose[2]), np.cos(pose[2]) - np.cos(heading)]
    )
    laser = models.place(np.array([*axle, heading]), np.array([[a, b]]))[0]
    return np.array([*laser, heading])


def test_car_moves_by_its_steering_not_by_its_heading_as_printed() -> None:
    car, seconds = Car(), 1e-4
    exact = (arc(POSE, car, seconds) - POSE) / seconds
    moved = (car.move(POSE, SPEED, STEERING, seconds) - POSE) / seconds
    np.testing.assert_allclose(moved, exact, atol=2e-3)
    printed = SPEED * np.cos(POSE[2]) - SPEED / car.wheelbase_m * np.tan(POSE[2]) * (
        car.laser_ahead_m * np.sin(POSE[2]) + car.laser_left_m * np.cos(POSE[2])
    )
    assert abs(printed - exact[0]) > 0.5


def test_many_steps_of_the_car_are_one_after_the_other() -> None:
    """With the derivatives of (3.18), and noise that each step adds to what follows it."""
    car, rng, count = Car(), np.random.default_rng(3), 4
    odometry, noise = rng.normal([3.0, 0.2], [1.0, 0.2], (count, 2)), np.diag([0.09, 0.01])
    step_s = rng.uniform(0.1, 0.5, count)

    def drive(pose: Array, controls: Array) -> Array:
        for (speed, steering), seconds in zip(controls.reshape(-1, 2), step_s, strict=True):
            pose = car.move(pose, speed, steering, seconds)
        return pose

    pose, by_pose, spread = car.move_steps(POSE, odometry, step_s, noise)
    np.testing.assert_allclose(pose, drive(POSE, odometry), atol=1e-12)
    numeric = differentiate(partial(drive, controls=odometry), POSE)
    np.testing.assert_allclose(by_pose, numeric, atol=1e-8)
    by_odometry = differentiate(partial(drive, POSE), odometry.ravel())
    expected = by_odometry @ np.kron(np.eye(count), noise) @ by_odometry.T
    np.testing.assert_allclose(spread, expected, atol=1e-8)


def test_turns_scatter_by_the_product_of_both_errors_too() -> None:
    """(3.7) of [Aulinas2011] is of first order: at half the speed's error it lacks a fifth."""
    car, rng, noise = Car(), np.random.default_rng(0), np.diag([1.0, np.radians(7.0) ** 2])
    true, step_s = np.array([[2.0, 0.0]]), np.array([0.05])
    drawn = true + rng.standard_normal((40000, 2)) @ np.sqrt(noise)
    turns = step_s * drawn[:, 0] / car.wheelbase_m * np.tan(drawn[:, 1])
    first, second = (
        car.spread(POSE, true, step_s, noise, with_product=flag)[2, 2] for flag in (False, True)
    )
    assert second == pytest.approx(turns.var(), rel=0.06)
    assert first == pytest.approx(0.8 * second)


def test_wheel_that_counts_is_slower_than_the_axle_in_a_left_turn() -> None:
    car = Car()
    radius = car.wheelbase_m / np.tan(STEERING)
    wheel = SPEED * (radius - car.encoder_m) / radius
    assert car.axle_speed(np.array(wheel), np.array(STEERING)) == pytest.approx(SPEED)


def test_range_grows_with_the_landmarks_x_ahead_not_as_printed() -> None:
    by_pose, by_point = models.observe_jacobians(POSE, POINTS)
    for number, point in enumerate(POINTS):
        numeric = differentiate(lambda p: models.observe(POSE, p[None])[0], point)
        np.testing.assert_allclose(by_point[number], numeric, atol=1e-8)
        numeric_pose = differentiate(lambda p, at=point: models.observe(p, at[None])[0], POSE)
        np.testing.assert_allclose(by_pose[number], numeric_pose, atol=1e-8)
        printed = -(point[0] - POSE[0]) / np.linalg.norm(point - POSE[:2])
        assert abs(printed - numeric[0, 0]) > 0.1


def test_what_lies_behind_the_car_is_not_folded_as_printed() -> None:
    behind = np.array([[-5.0, -1.0]])
    readings = models.observe(np.zeros(3), behind)
    np.testing.assert_allclose(models.sighted_points(readings), behind, atol=1e-12)
    printed = np.array([[readings[0, 0], np.arctan(behind[0, 1] / behind[0, 0]) + np.pi / 2]])
    assert np.linalg.norm(models.sighted_points(printed) - behind) > 5.0


def test_sighted_points_scatter_as_their_covariance_says() -> None:
    rng = np.random.default_rng(0)
    noise = np.diag([0.1**2, 0.02**2])
    reading = np.array([[8.0, 2.0]])
    drawn = reading + rng.multivariate_normal([0, 0], noise, 20000)
    scatter = np.cov(models.sighted_points(drawn).T)
    np.testing.assert_allclose(models.sighted_covariance(reading, noise)[0], scatter, atol=1e-3)
