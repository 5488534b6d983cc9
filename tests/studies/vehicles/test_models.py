# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Motion, sensors and inverse depth of underwater vehicles, and what the thesis misprints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hullrecon.geometry.poses import from_rpy
from hullrecon.studies.vehicles import motion, sensors, transforms
from hullrecon.studies.vehicles.inverse_depth import (
    DOWN,
    Pinhole,
    direction,
    new_landmark,
    see_landmark,
    to_point,
)

CAMERA = Pinhole(focal_px=277.0, centre_px=(160.0, 120.0), size_px=(320, 240))
ATTITUDE = np.array([0.3, -0.2, 1.1])
POSE = np.r_[2.0, -1.0, 3.0, ATTITUDE]
POINT = np.array([2.4, -0.7, 5.5])


def numeric(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    steps = 1e-6 * np.eye(len(at))
    return np.column_stack([(function(at + h) - function(at - h)) / 2e-6 for h in steps])


def pixel_of(pose: np.ndarray, point: np.ndarray) -> np.ndarray:
    in_camera = DOWN.T @ from_rpy(pose[:3], pose[3:]).inverse().apply(point)[0]
    return CAMERA.focal_px * in_camera[:2] / in_camera[2] + CAMERA.centre_px


def first_sight() -> tuple[np.ndarray, np.ndarray]:
    rho = 1 / np.linalg.norm(POINT - POSE[:3])
    pixel = pixel_of(POSE, POINT)
    return new_landmark(CAMERA, POSE, pixel, rho)[0], pixel


def test_rotation_is_that_of_roll_pitch_yaw() -> None:
    expected = from_rpy(np.zeros(3), ATTITUDE).matrix()[0, :3, :3]
    np.testing.assert_allclose(transforms.rotation(ATTITUDE), expected, atol=1e-15)


def test_last_factor_of_a5_as_printed_is_no_rotation() -> None:
    c, s = np.cos(ATTITUDE[0]), np.sin(ATTITUDE[0])
    printed = np.array([[1, 0, 0], [0, c, c], [0, -s, c]]).T
    assert abs(np.linalg.det(printed) - 1) > 0.1
    corrected = transforms.rotation(np.r_[ATTITUDE[0], 0, 0])
    assert np.linalg.det(corrected) == pytest.approx(1)
    # Nor is it rotz(phi), as the product names it: roll leaves x alone.
    about_z = transforms.rotation(np.r_[0, 0, ATTITUDE[0]])
    assert about_z[0, 0] != pytest.approx(1)
    assert corrected[0].tolist() == [1, 0, 0]


def test_inverse_transform_has_the_translation_turned_back() -> None:
    product = transforms.transform(POSE) @ transforms.inverse_transform(POSE)
    np.testing.assert_allclose(product, np.eye(4), atol=1e-14)


@pytest.mark.parametrize("stray", [0.0, 0.25, 4.0])
def test_inverse_with_the_stray_factor_as_printed_leads_elsewhere(stray: float) -> None:
    """[Aulinas2011 eq. A.4] prints a Delta before t, which is a step of time or a distance."""
    printed = transforms.inverse_transform(POSE)
    printed[:3, 3] = -transforms.rotation(ATTITUDE).T @ (stray * POSE[:3])
    assert np.abs(transforms.transform(POSE) @ printed - np.eye(4)).max() > 1


def test_rotation_derivatives_are_numeric_ones() -> None:
    expected = numeric(lambda a: transforms.rotation(a).ravel(), ATTITUDE).T.reshape(3, 3, 3)
    np.testing.assert_allclose(transforms.rotation_derivatives(ATTITUDE), expected, atol=1e-9)


@pytest.mark.parametrize(("model", "size"), [(motion.move, 9), (motion.move_level, 7)])
def test_motion_jacobian_is_the_numeric_one(model: Callable, size: int) -> None:
    state = np.linspace(-0.8, 1.3, size)
    expected = numeric(lambda x: model(x, 0.7)[0], state)
    np.testing.assert_allclose(model(state, 0.7)[1], expected, atol=1e-8)


def test_pitch_stays_where_the_print_puts_roll() -> None:
    state = np.r_[np.zeros(3), ATTITUDE, 1.0, 0.0, 0.0]
    moved, _ = motion.move(state, 1.0)
    printed = np.r_[moved[:3], ATTITUDE[[0, 0, 2]], state[6:]]  # (5.2): phi, phi, psi
    assert moved[4] == ATTITUDE[1]
    assert printed[4] != pytest.approx(ATTITUDE[1])


def test_level_motion_is_the_full_one_without_roll_and_pitch() -> None:
    level = np.array([1.0, 2.0, 3.0, 0.7, 0.5, -0.2, 0.1])
    full, _ = motion.move(np.r_[level[:3], 0, 0, level[3:]], 0.4)
    moved, _ = motion.move_level(level, 0.4)
    np.testing.assert_allclose(moved, np.delete(full, [3, 4]), atol=1e-15)
    printed_z = level[2] + level[6] * 0.4 * level[3]  # (5.15) runs z and yaw into one row
    assert printed_z != pytest.approx(full[2])


def test_altitude_reads_the_depth_of_the_floor() -> None:
    vehicle = np.zeros(sensors.VEHICLE)
    vehicle[2], depth_of_floor, distance = 12.0, 16.0, 4.0
    vehicle[sensors.FLOOR] = depth_of_floor
    assert (sensors.navigation_rows() @ vehicle)[7] == distance
    vehicle[sensors.FLOOR] = distance  # as the thesis names its tenth state
    assert (sensors.navigation_rows() @ vehicle)[7] != distance


def test_row_of_depth_has_as_many_columns_as_the_state() -> None:
    printed = np.r_[[0, 0, 1], [0], np.zeros(3), np.zeros(1)]  # (5.9) before the landmarks
    assert len(printed) != sensors.VEHICLE
    depth = sensors.navigation_rows()[6]
    assert depth.tolist() == [0, 0, 1, 0, 0, 0, 0, 0, 0, 0]


def test_noise_of_a_target_is_sonar_noise_not_velocity_noise() -> None:
    sigmas = sensors.Sigmas(velocity_mps=0.04, target_m=(0.2, 0.3, 0.4))
    np.testing.assert_allclose(np.sqrt(np.diag(sigmas.target())), [0.2, 0.3, 0.4])
    assert not np.allclose(sigmas.target(), 0.04**2 * np.eye(3))  # R_v, as (5.12) is labelled


def test_target_is_seen_by_the_inverse_of_the_printed_transform() -> None:
    vehicle = np.r_[POSE, 0.1, 0.2, 0.3, 16.0]
    abeam = np.array([0.0, 3.0, 5.0])
    landmark = vehicle[:3] + transforms.rotation(ATTITUDE) @ abeam
    np.testing.assert_allclose(sensors.see_target(vehicle, landmark)[0], abeam, atol=1e-14)
    printed = transforms.transform(POSE) @ np.r_[landmark, 1.0]  # W_T_V of (5.11)
    assert np.linalg.norm(printed[:3] - abeam) > 1


def test_target_is_placed_where_it_was_seen() -> None:
    vehicle = np.r_[POSE, 0.1, 0.2, 0.3, 16.0]
    seen, by_vehicle, by_landmark = sensors.see_target(vehicle, POINT)
    place, placed_by_vehicle, placed_by_seen = sensors.place_target(vehicle, seen)
    np.testing.assert_allclose(place, POINT, atol=1e-14)
    for jacobian, function, at in (
        (by_vehicle, lambda x: sensors.see_target(x, POINT)[0], vehicle),
        (by_landmark, lambda x: sensors.see_target(vehicle, x)[0], POINT),
        (placed_by_vehicle, lambda x: sensors.place_target(x, seen)[0], vehicle),
        (placed_by_seen, lambda x: sensors.place_target(vehicle, x)[0], seen),
    ):
        np.testing.assert_allclose(jacobian, numeric(function, at), atol=1e-8)


def test_direction_is_a_unit_vector_unlike_the_printed_one() -> None:
    a, b = 0.4, -0.3
    m, by_angles = direction(a, b)
    assert np.linalg.norm(m) == pytest.approx(1)
    np.testing.assert_allclose(
        by_angles, numeric(lambda x: direction(*x)[0], np.r_[a, b]), atol=1e-9
    )
    printed = np.array([np.cos(a) * np.sin(b) - np.sin(a), -np.sin(a), np.cos(a) * np.cos(b)])
    assert abs(np.linalg.norm(printed) - 1) > 0.05


def test_new_landmark_lies_on_its_ray_unlike_the_printed_one() -> None:
    landmark, pixel = first_sight()
    np.testing.assert_allclose(to_point(landmark)[0], POINT, atol=1e-12)
    ray = transforms.rotation(ATTITUDE) @ DOWN @ np.append(pixel, 1.0)  # (5.23): no inverse of K
    along = (POINT - POSE[:3]) / np.linalg.norm(POINT - POSE[:3])
    assert ray @ along / np.linalg.norm(ray) < 0.9


def test_landmark_is_seen_where_its_point_is_unlike_the_printed_one() -> None:
    landmark, _ = first_sight()
    pose = POSE + np.array([0.3, -0.2, 0.1, 0.05, -0.04, 0.1])
    expected, by_pose, by_landmark = see_landmark(CAMERA, pose, landmark)
    np.testing.assert_allclose(expected, pixel_of(pose, POINT), atol=1e-9)
    np.testing.assert_allclose(
        by_pose, numeric(lambda x: see_landmark(CAMERA, x, landmark)[0], pose), atol=1e-6
    )
    np.testing.assert_allclose(
        by_landmark, numeric(lambda y: see_landmark(CAMERA, pose, y)[0], landmark), atol=1e-6
    )
    turn = DOWN.T @ transforms.rotation(pose[3:]).T
    m, _ = direction(landmark[3], landmark[4])
    printed = turn @ (landmark[5] * landmark[:3] - pose[:3]) + m  # (5.21)
    pixel = CAMERA.focal_px * printed[:2] / printed[2] + CAMERA.centre_px
    assert np.abs(pixel - pixel_of(pose, POINT)).max() > 10


def test_new_landmark_jacobians_are_numeric_ones() -> None:
    pixel = np.array([100.0, 200.0])
    _, by_pose, by_seen = new_landmark(CAMERA, POSE, pixel, 0.4)
    np.testing.assert_allclose(
        by_pose, numeric(lambda x: new_landmark(CAMERA, x, pixel, 0.4)[0], POSE), atol=1e-8
    )
    np.testing.assert_allclose(
        by_seen,
        numeric(lambda x: new_landmark(CAMERA, POSE, x[:2], x[2])[0], np.r_[pixel, 0.4]),
        atol=1e-8,
    )
