# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.geometry.poses import exp
from hullrecon.vision.pairs import pose_from_points

TRUTH = exp([[0.2, -0.05, 0.03, 0.02, -0.08, 0.04]]).matrix()[0]
DOWN = exp([[0.0, -0.1, 0.0, 0.0, 0.0, 0.01]]).matrix()[0]  # the other node's bottom camera


def image_view(points, xy, camera_from_node, backward, baseline_m):
    return pose_from_points.ObservedPoints(
        points=points,
        xy=xy,
        camera_from_node=camera_from_node,
        backward=backward,
        baseline_m=baseline_m,
    )


def move(motion, points):
    return points @ motion[:3, :3].T + motion[:3, 3]


def image(points):
    return points[:, :2] / points[:, 2:]


@pytest.fixture
def scene():
    rng = np.random.default_rng(0)
    return np.column_stack([rng.uniform(-0.5, 0.5, (200, 2)), rng.uniform(1.2, 1.6, 200)])


def views(points, noise=0.0, seed=1):
    rng = np.random.default_rng(seed)
    there = move(TRUTH, points)
    shake = lambda: noise * rng.standard_normal((len(points), 2))  # noqa: E731
    return [
        image_view(points, image(there) + shake(), np.eye(4), False, 0.1),
        image_view(points, image(move(DOWN, there)) + shake(), DOWN, False, 0.1),
        image_view(there, image(points) + shake(), np.eye(4), True, 0.1),
    ]


def test_errors_are_zero_at_truth_both_ways(scene):
    for view in views(scene):
        np.testing.assert_allclose(
            pose_from_points.squared_errors(TRUTH[None], view), 0, atol=1e-20
        )


def test_error_is_distance_in_image():
    view = image_view(np.array([[0.0, 0.0, 2.0]]), np.array([[0.03, -0.04]]), np.eye(4), False, 0.1)
    np.testing.assert_allclose(pose_from_points.squared_errors(np.eye(4)[None], view), [[0.05**2]])


def test_point_behind_camera_is_infinite_error_unseen_is_none():
    points = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    view = image_view(points, np.array([[0.0, 0.0], [np.nan, np.nan]]), np.eye(4), False, 0.1)
    np.testing.assert_array_equal(
        pose_from_points.squared_errors(np.eye(4)[None], view), [[np.inf, 0.0]]
    )


def test_ransac_finds_motion_among_three_quarters_outliers(scene):
    rng = np.random.default_rng(3)
    wrong = rng.permutation(200)[:150]
    seen = move(TRUTH, scene)
    seen[wrong] = seen[np.roll(wrong, 1)]
    all_views = [
        image_view(scene, image(seen), np.eye(4), False, 0.1),
        image_view(seen, image(scene), np.eye(4), True, 0.1),
    ]
    np.testing.assert_allclose(
        pose_from_points.ransac(scene, seen, all_views, 0.004, 2000, (1,)), TRUTH, atol=1e-6
    )


def test_ransac_repeats_itself_for_one_seed(scene):
    noisy = move(TRUTH, scene) + 0.01 * np.random.default_rng(1).standard_normal(scene.shape)
    first, second = (
        pose_from_points.ransac(scene, noisy, views(scene), 0.01, 256, (4, 2)) for _ in range(2)
    )
    np.testing.assert_array_equal(first, second)


def test_two_points_are_too_few(scene):
    assert pose_from_points.ransac(scene[:2], scene[:2], views(scene[:2]), 0.01, 100, (1,)) is None


def test_refinement_reaches_truth_from_rough_guess(scene):
    start = TRUTH @ exp([[0.003, -0.002, 0.002, 0.001, 0.002, -0.001]]).matrix()[0]
    np.testing.assert_allclose(
        pose_from_points.refine(start, views(scene), 0.02)[0], TRUTH, atol=1e-9
    )


def test_covariance_is_spread_over_many_noisy_scenes(scene):
    found = [pose_from_points.refine(TRUTH, views(scene, 0.0005, seed), 0.02) for seed in range(40)]
    spread = np.std([motion[:3, 3] for motion, _ in found], axis=0)
    claimed = np.sqrt(np.mean([np.diag(c)[:3] for _, c in found], axis=0))
    assert (spread < 2.0 * claimed).all()
    assert (spread > 0.5 * claimed).all()


def test_wrong_depth_is_forgiven_along_its_line_only(scene):
    # a depth off by 1 %: 13 mm, twice what a 0.1 m baseline leaves open at half a pixel
    deep = scene * 1.01
    along = image_view(deep, image(move(TRUTH, scene)), np.eye(4), False, 0.1)
    stiff = image_view(deep, along.xy, along.camera_from_node, False, 1e9)
    everywhere = [np.ones(len(scene), bool)]
    off, off_if_stiff = (
        pose_from_points._normal_equations(TRUTH, [view], everywhere)[2] for view in (along, stiff)
    )
    assert off < 0.25 * off_if_stiff


def test_resection_finds_pose_among_wrong_matches(scene):
    xy = image(move(TRUTH, scene))
    xy[:80] = xy[:80][::-1] + 0.05
    np.testing.assert_allclose(pose_from_points.resect(scene, xy, 0.004, 500), TRUTH, atol=1e-4)


def test_resection_needs_four_points(scene):
    assert pose_from_points.resect(scene[:3], image(scene[:3]), 0.01, 100) is None


def test_rows_without_point_count_as_not_seen():
    view = pose_from_points.hide_unknown_points(
        image_view(np.full((1, 3), np.nan), np.zeros((1, 2)), np.eye(4), False, 0.1)
    )
    assert np.isnan(view.xy).all()
    assert np.isfinite(view.points).all()
