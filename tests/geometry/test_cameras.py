# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.geometry.cameras import CameraModel

QUICK = settings(max_examples=30, deadline=None, derandomize=True)

BENT = CameraModel(640, 512, 600.0, 610.0, 321.0, 254.0, -0.21, 0.07, 0.001, -0.0008, -0.01)


def test_a_point_on_the_axis_falls_on_the_principal_point() -> None:
    assert np.allclose(BENT.project([[0, 0, 2.0]]), [[321.0, 254.0]])


def test_without_distortion_a_pixel_is_focal_length_times_slope() -> None:
    plain = CameraModel(100, 80, 50.0, 40.0, 49.5, 39.5)
    assert np.allclose(plain.project([[0.2, -0.1, 2.0]]), [[49.5 + 5.0, 39.5 - 2.0]])


def test_a_point_behind_the_camera_has_no_pixel() -> None:
    assert np.isnan(BENT.project([[0.1, 0.1, -1.0], [0.1, 0.1, 0.0]])).all()


def test_the_distortion_is_opencvs() -> None:
    import cv2

    points = np.random.default_rng(0).uniform([-0.5, -0.4, 1], [0.5, 0.4, 2], (50, 3))
    theirs, _ = cv2.projectPoints(
        points, np.zeros(3), np.zeros(3), BENT.matrix(), BENT.distortion()
    )
    assert np.allclose(BENT.project(points), theirs[:, 0], atol=1e-9)


@QUICK
@given(st.floats(0, 639), st.floats(0, 511))
def test_a_pixel_comes_back_from_its_ray(u: float, v: float) -> None:
    ray = BENT.rays([[u, v]])
    assert np.isclose(np.linalg.norm(ray), 1.0)
    assert np.allclose(BENT.project(3.0 * ray), [[u, v]], atol=1e-3)


def test_the_parameters_are_in_the_order_of_the_native_module() -> None:
    assert BENT.parameters().tolist() == [
        600.0,
        610.0,
        321.0,
        254.0,
        -0.21,
        0.07,
        0.001,
        -0.0008,
        -0.01,
    ]


@QUICK
@given(st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-0.4, 0.4)), min_size=1, max_size=9))
def test_ideal_coordinates_come_back_from_their_pixels(xy: list[tuple[float, float]]) -> None:
    ideal = np.array(xy)
    np.testing.assert_allclose(BENT.undistort(BENT.distort(ideal), iterations=60), ideal, atol=1e-9)
    coarse, fine = (
        np.abs(BENT.undistort(BENT.distort(ideal), iterations=n) - ideal).max() for n in (3, 12)
    )
    assert fine <= max(coarse, 1e-12)


@QUICK
@given(st.floats(-0.5, 0.5), st.floats(-0.4, 0.4), st.floats(0.1, 50), st.floats(0.1, 50))
def test_points_along_one_ray_have_one_pixel(x: float, y: float, near: float, far: float) -> None:
    ray = np.array([[x, y, 1.0]])
    np.testing.assert_allclose(BENT.project(near * ray), BENT.project(far * ray), atol=1e-9)
    assert np.isnan(BENT.project(-near * ray)).all()


@QUICK
@given(st.floats(0, 639), st.floats(0, 511))
def test_rays_without_distortion_are_those_of_matrix(u: float, v: float) -> None:
    plain = CameraModel(640, 512, 600.0, 610.0, 321.0, 254.0)
    expected = np.linalg.inv(plain.matrix()) @ [u, v, 1.0]
    np.testing.assert_allclose(
        plain.rays([[u, v]])[0], expected / np.linalg.norm(expected), atol=1e-12
    )
    assert BENT.rays([[u, v]])[0, 2] > 0


def test_points_are_projected_one_by_one() -> None:
    points = np.random.default_rng(1).uniform([-1, -1, -1], [1, 1, 3], (20, 3))
    np.testing.assert_array_equal(
        BENT.project(points), np.vstack([BENT.project(point) for point in points])
    )
    assert np.array_equal(np.isnan(BENT.project(points)[:, 0]), points[:, 2] <= 0)
