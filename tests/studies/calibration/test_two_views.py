# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Covariances of a motion under an uncertain calibration, beside motions with drawn ones."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem.intrinsics import prior_sigma
from hullrecon.studies.calibration.two_views import TwoViews, first_order, sampled, unscented
from hullrecon.studies.calibration.wall import CAMERA, views_of_wall
from hullrecon.studies.calibration.wall import SECOND_FROM_FIRST as MOTION
from hullrecon.vision.pairs.mono_motion import linearise

SIGMA = prior_sigma(CAMERA, AdjustOptions())


@pytest.fixture(scope="module")
def views() -> TwoViews:
    return views_of_wall(np.random.default_rng(0), points=60)


def sigmas(covariance: np.ndarray) -> np.ndarray:
    return np.sqrt(np.diag(covariance))


def test_small_errors_come_out_alike(views: TwoViews) -> None:
    small = np.diag((0.1 * SIGMA) ** 2)
    linear, points = (of(views, MOTION, small) for of in (first_order, unscented))
    np.testing.assert_allclose(points, linear, atol=2e-3 * np.trace(linear))
    scatter = sampled(views, MOTION, small, 200, np.random.default_rng(1)).std(axis=0)
    np.testing.assert_allclose(scatter, sigmas(linear), rtol=0.15)


def test_correlated_errors_are_followed(views: TwoViews) -> None:
    """Pixels that are not square turn the image about its axis; one that is zoomed is not."""
    zoomed = np.zeros((9, 9))
    zoomed[:2, :2] = 0.6**2
    for of in (first_order, unscented):
        alike, apart = (sigmas(of(views, MOTION, c)) for c in (zoomed, zoomed * np.eye(9)))
        assert alike[2] < 0.3 * apart[2]
        assert alike[1] > 0.9 * apart[1]


def test_sigma_points_tell_large_errors_better(views: TwoViews) -> None:
    large = np.diag((4 * SIGMA) ** 2)
    scatter = sampled(views, MOTION, large, 400, np.random.default_rng(2)).std(axis=0)
    linear, points = (sigmas(of(views, MOTION, large)) for of in (first_order, unscented))
    linear, points = (np.abs(np.log(sigma / scatter)) for sigma in (linear, points))
    assert linear.max() > 0.1
    assert points.max() < 0.08
    assert points.max() < 0.6 * linear.max()


def test_unknowns_of_two_views_hold_a_third_as_many_points_as_printed(views: TwoViews) -> None:
    """[Ozog2016 D.1.1] prints points P_1 to P_(M-5) among M unknowns: each has three."""
    numbers = linearise(MOTION, *views.ideal(np.zeros(9)))[1].shape[1]
    points = np.zeros((len(views.first), 3))
    unknowns = numbers + points.size
    assert (unknowns - 5) / 3 == len(points)
    assert unknowns - 5 != len(points)


def test_covariance_of_a_fit_has_the_inverse_in_every_line_unlike_the_print(
    views: TwoViews,
) -> None:
    """[Ozog2016 D.1.1] loses the inverse of S_X in the third line of its expansion."""
    jacobian = linearise(MOTION, *views.ideal(np.zeros(9)))[1]
    noise = np.diag(np.linspace(0.5, 2.0, len(jacobian)) ** 2)
    weight = np.linalg.inv(noise)
    information = jacobian.T @ weight @ jacobian
    by_gradient = np.linalg.inv(2 * information)
    first = by_gradient @ (2 * weight @ jacobian).T @ noise @ (2 * weight @ jacobian) @ by_gradient
    right = 2 * np.linalg.inv(information) @ information @ by_gradient
    printed = 2 * np.linalg.inv(jacobian.T @ noise @ jacobian) @ information @ by_gradient
    scale = np.trace(first)
    np.testing.assert_allclose(right, first, atol=1e-9 * scale)
    assert np.abs(printed - first).max() > 0.1 * scale
