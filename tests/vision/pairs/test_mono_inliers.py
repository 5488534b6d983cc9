# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Wrong matches that bend the motion of two views of a nearly plane hull are found out by
navigation, which is not counted.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from vision.pairs.test_mono_motion import SIGMA, TRUE, UNIT, five, matches

from hullrecon.geometry.poses import exp
from hullrecon.vision.pairs import mono_inliers, mono_motion, two_view
from hullrecon.vision.pairs.gating import Motion

SEEDS = range(4)
KNOWN = np.diag(np.repeat([0.02, 0.005], 3)) ** 2  # 2 cm, 5 mrad
WRONG = 6


def navigation(seed, covariance=KNOWN):
    """The true motion, off by half of what navigation says of itself."""
    error = (
        0.5 * np.sqrt(np.diag(covariance)) * np.random.default_rng(100 + seed).standard_normal(6)
    )
    out = TRUE.copy()
    out[:3, 3] += error[:3]
    out[:3, :3] = TRUE[:3, :3] @ Rotation.from_rotvec(error[3:]).as_matrix()
    return Motion(out, covariance)


def with_wrong_ones(seed):
    """Matches of a nearly plane wall, some at one corner wrong by twelve sigma across their
    epipolar lines.
    """
    first, second = matches(relief_m=0.01, n=70, seed=seed, width=0.6)
    corner = np.argsort(-first.sum(axis=1))[:WRONG]
    second[corner, 1] += 12 * SIGMA
    return first, second


TOLERANCE = 1.0 / 655.0  # a pixel
# to the next leg of a hull whose axis is x
ACROSS = exp([[0.02, 0.5, 0.05, -0.1, 0.05, 0.01]]).matrix()[0]


def of_a_bilge(seed, radius_m=3.0, n=120):
    """Matches of a cylinder, 1.5 m ahead, and its radius is that of a bilge."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-0.6, 0.6, n), rng.uniform(-0.5, 0.5, n)
    points = np.column_stack([x, y, 1.5 + radius_m - np.sqrt(radius_m**2 - y**2)])
    there = points @ ACROSS[:3, :3].T + ACROSS[:3, 3]
    return tuple(
        p[:, :2] / p[:, 2:] + 0.4 * TOLERANCE * rng.standard_normal((n, 2)) for p in (points, there)
    )


def motion_of_plane(seed, prior):
    """The motion by the inliers of a plane alone, how many they are, and the matches."""
    xy = of_a_bilge(seed)
    found = two_view.fit_both(*xy, TOLERANCE).homography.within(TOLERANCE)
    inliers = tuple(view[found.inlier] for view in xy)
    return (
        mono_inliers.choose(two_view.motions_of(found, *xy), inliers, prior, None),
        int(found.inlier.sum()),
        xy,
    )


def turned_by(found):
    return np.linalg.norm(five(found)[:3])


def test_wrong_matches_at_one_corner_do_not_turn_motion():
    plain = [mono_motion.refine(UNIT, *with_wrong_ones(seed))[0] for seed in SEEDS]
    assert np.mean([turned_by(motion) for motion in plain]) > 0.06
    chosen = [
        mono_inliers.refine_on_inliers(start, *with_wrong_ones(seed), navigation(seed))[0]
        for seed, start in zip(SEEDS, plain, strict=True)
    ]
    assert max(turned_by(motion) for motion in chosen) < 0.025


@pytest.mark.parametrize("seed", SEEDS)
def test_what_matches_say_of_motion_is_said_without_navigation(seed):
    own, covariance = mono_motion.refine(UNIT, *matches(seed=seed))
    for surer in (1.0, 0.01):
        found, chosen = mono_inliers.refine_on_inliers(
            UNIT, *matches(seed=seed), navigation(seed, surer * KNOWN)
        )
        np.testing.assert_allclose(
            five(found, own), 0, atol=0.5 * np.sqrt(covariance.diagonal().max())
        )
        np.testing.assert_allclose(
            np.sqrt(chosen.diagonal()), np.sqrt(covariance.diagonal()), rtol=0.15
        )


def test_matches_that_are_left_out_widen_covariance():
    first, second = matches()
    wrong = second.copy()
    wrong[:WRONG, 1] += 40 * SIGMA
    clean, doubted = (
        mono_inliers.refine_on_inliers(UNIT, first, xy, navigation(1))[1] for xy in (second, wrong)
    )
    assert 1.1 < np.sqrt(np.trace(doubted) / np.trace(clean)) < 1.6


@pytest.mark.parametrize("prior", [None, navigation(1, 100 * KNOWN), Motion(np.eye(4), KNOWN)])
def test_where_navigation_hardly_knows_motion_all_matches_count(prior):
    found, covariance = mono_inliers.refine_on_inliers(UNIT, *with_wrong_ones(1), prior)
    expected, own = mono_motion.refine(UNIT, *with_wrong_ones(1))
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(covariance, own)


def test_motion_is_well_known_by_rotation_and_direction():
    length = float(np.linalg.norm(TRUE[:3, 3]))
    along = np.zeros((6, 6))
    along[:3, :3] = np.outer(UNIT[:3, 3], UNIT[:3, 3])
    assert mono_inliers.is_well_known(Motion(TRUE, KNOWN))
    assert mono_inliers.is_well_known(Motion(TRUE, KNOWN + along))
    assert not mono_inliers.is_well_known(
        Motion(TRUE, KNOWN + np.diag(np.repeat([0.15 * length, 0.0], 3)) ** 2)
    )
    assert not mono_inliers.is_well_known(
        Motion(TRUE, KNOWN + np.diag(np.repeat([0.0, 0.15], 3)) ** 2)
    )


@pytest.mark.parametrize(
    "prior", [Motion(ACROSS, KNOWN), Motion(ACROSS, 100 * KNOWN)], ids=["known", "hardly known"]
)
def test_bilge_is_not_made_flatter_by_inliers_of_plane(prior):
    turns = {"plane": [], "gathered": []}
    for seed in range(10):
        of_plane, count, xy = motion_of_plane(seed, prior)
        gathered, inlier = mono_inliers.gather(of_plane, *xy, prior, TOLERANCE)
        assert count < 90
        assert inlier.sum() > 110
        for name, motion in (("plane", of_plane), ("gathered", gathered)):
            turns[name].append(five(motion.second_from_first, ACROSS)[:3])
    assert np.abs(np.mean(turns["plane"], axis=0)).max() > 0.006
    assert np.abs(np.mean(turns["gathered"], axis=0)).max() < 0.0015
    assert np.std(turns["gathered"], axis=0).max() < 0.4 * np.std(turns["plane"], axis=0).max()


def test_matches_off_their_lines_are_not_gathered():
    prior = Motion(ACROSS, KNOWN)
    motion, _, (first, second) = motion_of_plane(0, prior)
    wrong = second.copy()
    wrong[:20, 0] += 8 * TOLERANCE  # across the lines, which run with the motion along y
    expected, whole = mono_inliers.gather(motion, first, second, prior, TOLERANCE)
    found, inlier = mono_inliers.gather(motion, first, wrong, prior, TOLERANCE)
    assert not inlier[:20].any()
    np.testing.assert_array_equal(inlier[20:], whole[20:])
    np.testing.assert_allclose(found.second_from_first, expected.second_from_first, atol=0.005)
