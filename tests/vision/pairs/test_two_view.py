# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.geometry.poses import exp
from hullrecon.vision.pairs import two_view

MOTION = exp([[0.3, 0.02, 0.05, 0.02, -0.05, 0.01]]).matrix()[0]
FOCAL = 1200.0


def scene(relief_m, n=100, sigma_px=1.0, seed=0):
    """Matches (n, 2) of a wall 1.5 m ahead with that relief, with noise, in ideal coordinates (the
    camera of [KimEustice2009]).
    """
    rng = np.random.default_rng(seed)
    points = np.column_stack(
        [
            rng.uniform(-0.5, 0.7, n),
            rng.uniform(-0.35, 0.35, n),
            1.5 + relief_m * rng.standard_normal(n),
        ]
    )
    there = points @ MOTION[:3, :3].T + MOTION[:3, 3]
    noise = sigma_px / FOCAL * rng.standard_normal((2, n, 2))
    return points[:, :2] / points[:, 2:] + noise[0], there[:, :2] / there[:, 2:] + noise[1]


@pytest.mark.parametrize(
    ("count", "plane", "general"),
    [(10, 72, 80), (50, 232, 320), (100, 432, 620), (500, 2032, 3020)],
)
def test_penalties_are_those_of_source(count, plane, general):
    assert two_view.criterion(np.zeros(count), 2, 8) == plane
    assert two_view.criterion(np.zeros(count), 3, 5) == general


def test_one_outlier_cannot_decide():
    assert two_view.criterion(np.array([1e6]), 2, 8) == 4 + 4 + 32


def test_one_match_off_the_wall_decides_where_errors_are_not_bounded():
    """A fish before a wall fits the motion, and no homography: its error is of 1e5 variances."""
    fish = np.array([[0.05, 0.03, 0.3]])
    there = fish @ MOTION[:3, :3].T + MOTION[:3, 3]
    first, second = (
        np.vstack([wall, point[:, :2] / point[:, 2:]])
        for wall, point in zip(scene(0.0), (fish, there), strict=True)
    )
    both = two_view.fit_both(first, second, 2 / FOCAL)
    essential, homography = (
        scored.squared_error.sum() * FOCAL**2 + 2 * dimension * len(first) + 4 * parameters
        for scored, (dimension, parameters) in (
            (both.essential, two_view.ESSENTIAL),
            (both.homography, two_view.HOMOGRAPHY),
        )
    )
    assert homography > 1e5 > essential
    assert both.homography.criterion < both.essential.criterion


def test_flat_wall_is_homography_and_rough_one_is_not():
    assert two_view.fit(*scene(0.0), 2 / FOCAL).model == "homography"
    assert two_view.fit(*scene(0.2), 2 / FOCAL).model == "essential"


@pytest.mark.parametrize("relief_m", [0.0, 0.2])
def test_model_of_smaller_criterion_is_chosen(relief_m):
    first, second = scene(relief_m)
    both, found = (
        two_view.fit_both(first, second, 2 / FOCAL),
        two_view.fit(first, second, 2 / FOCAL),
    )
    better = min((both.essential, both.homography), key=lambda scored: scored.criterion)
    assert found.model == better.model
    np.testing.assert_array_equal(found.matrix, better.matrix)
    np.testing.assert_array_equal(found.inlier, better.squared_error < (2 / FOCAL) ** 2)


def test_true_motion_has_no_sampson_error():
    first, second = scene(0.2, sigma_px=0.0)
    np.testing.assert_allclose(
        two_view.sampson_squared(two_view.essential_of(MOTION), first, second), 0, atol=1e-20
    )


def test_sampson_error_is_distance_to_nearest_pair_that_fits():
    sideways = np.eye(4)
    sideways[0, 3] = 1.0  # epipolar lines are rows: a gap of 0.02 is shared by both images
    error = two_view.sampson_squared(
        two_view.essential_of(sideways), np.array([[0.1, 0.0]]), np.array([[0.3, 0.02]])
    )
    np.testing.assert_allclose(error, 0.02**2 / 2)


def test_product_with_the_essential_matrix_is_no_squared_distance():
    """[Ozog2016 D.2.1] takes x' E x for one; it grows with E, whose size says nothing."""
    first, second = np.array([[0.1, 0.0, 1.0]]), np.array([[0.3, 0.02, 1.0]])
    sideways = np.eye(4)
    sideways[0, 3] = 1.0  # the epipolar line is the row of the first, 0.02 from the second
    found, printed = [], []
    for size in (1.0, 3.0):
        essential = size * two_view.essential_of(sideways)
        found.append(two_view.sampson_squared(essential, first[:, :2], second[:, :2])[0])
        printed.append(abs(second[0] @ essential @ first[0]))
    np.testing.assert_allclose(2 * np.array(found), 0.02**2)  # shared by both images
    np.testing.assert_allclose(printed, [0.02, 0.06])


@pytest.mark.parametrize("relief_m", [0.0, 0.2])
def test_motion_is_recovered_up_to_its_length(relief_m):
    first, second = scene(relief_m, n=300, sigma_px=0.1)
    found = two_view.fit(first, second, 1.5 / FOCAL)
    motions = [p.motion for p in two_view.motions_of(found, first, second)]
    direction = MOTION[:3, 3] / np.linalg.norm(MOTION[:3, 3])
    assert (
        min(
            np.abs(m[:3, 3] - direction).max() + np.abs(m[:3, :3] - MOTION[:3, :3]).max()
            for m in motions
        )
        < 0.05
    )


def test_wrong_matches_are_no_inliers():
    first, second = scene(0.2, n=200, sigma_px=0.3)
    second[:60] = second[:60][::-1]
    found = two_view.fit(first, second, 1.5 / FOCAL)
    assert found.inlier[60:].mean() > 0.9
    assert found.inlier[:60].mean() < 0.2


def test_seven_matches_are_too_few():
    first, second = scene(0.2, n=7)
    assert two_view.fit(first, second, 2 / FOCAL) is None
