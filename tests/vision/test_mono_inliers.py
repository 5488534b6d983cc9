# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Wrong matches that bend the motion of two views of a nearly plane hull are found out by navigation, which is not counted."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from vision.test_mono_motion import SIGMA, TRUE, UNIT, five, matches

from hullrecon.vision.pairs import mono_inliers, mono_motion
from hullrecon.vision.pairs.gating import Motion

SEEDS = range(4)
KNOWN = np.diag(np.repeat([0.02, 0.005], 3)) ** 2  # 2 cm, 5 mrad
WRONG = 6


def navigation(seed, covariance=KNOWN):
    """The true motion, off by half of what navigation says of itself."""
    error = 0.5 * np.sqrt(np.diag(covariance)) * np.random.default_rng(100 + seed).standard_normal(6)
    out = TRUE.copy()
    out[:3, 3] += error[:3]
    out[:3, :3] = TRUE[:3, :3] @ Rotation.from_rotvec(error[3:]).as_matrix()
    return Motion(out, covariance)


def with_wrong_ones(seed):
    """Matches of a nearly plane wall, some at one corner wrong by twelve sigma across their epipolar lines."""
    first, second = matches(relief_m=0.01, n=70, seed=seed, width=0.6)
    corner = np.argsort(-first.sum(axis=1))[:WRONG]
    second[corner, 1] += 12 * SIGMA
    return first, second


def turned_by(found):
    return np.linalg.norm(five(found)[:3])


def test_wrong_matches_at_one_corner_do_not_turn_the_motion():
    plain = [mono_motion.refine(UNIT, *with_wrong_ones(seed))[0] for seed in SEEDS]
    assert np.mean([turned_by(motion) for motion in plain]) > 0.06
    chosen = [
        mono_inliers.refine_on_inliers(start, *with_wrong_ones(seed), navigation(seed))[0]
        for seed, start in zip(SEEDS, plain, strict=True)
    ]
    assert max(turned_by(motion) for motion in chosen) < 0.025


@pytest.mark.parametrize("seed", SEEDS)
def test_what_the_matches_say_of_the_motion_is_said_without_navigation(seed):
    own, covariance = mono_motion.refine(UNIT, *matches(seed=seed))
    for surer in (1.0, 0.01):
        found, chosen = mono_inliers.refine_on_inliers(UNIT, *matches(seed=seed), navigation(seed, surer * KNOWN))
        np.testing.assert_allclose(five(found, own), 0, atol=0.5 * np.sqrt(covariance.diagonal().max()))
        np.testing.assert_allclose(np.sqrt(chosen.diagonal()), np.sqrt(covariance.diagonal()), rtol=0.15)


def test_matches_that_are_left_out_widen_the_covariance():
    first, second = matches()
    wrong = second.copy()
    wrong[:WRONG, 1] += 40 * SIGMA
    clean, doubted = (mono_inliers.refine_on_inliers(UNIT, first, xy, navigation(1))[1] for xy in (second, wrong))
    assert 1.1 < np.sqrt(np.trace(doubted) / np.trace(clean)) < 1.6


@pytest.mark.parametrize("prior", [None, navigation(1, 100 * KNOWN), Motion(np.eye(4), KNOWN)])
def test_where_navigation_hardly_knows_the_motion_all_matches_count(prior):
    found, covariance = mono_inliers.refine_on_inliers(UNIT, *with_wrong_ones(1), prior)
    expected, own = mono_motion.refine(UNIT, *with_wrong_ones(1))
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(covariance, own)


def test_a_motion_is_well_known_by_its_rotation_and_by_its_direction_but_not_by_its_length():
    length = float(np.linalg.norm(TRUE[:3, 3]))
    along = np.zeros((6, 6))
    along[:3, :3] = np.outer(UNIT[:3, 3], UNIT[:3, 3])
    assert mono_inliers.is_well_known(Motion(TRUE, KNOWN))
    assert mono_inliers.is_well_known(Motion(TRUE, KNOWN + along))
    assert not mono_inliers.is_well_known(Motion(TRUE, KNOWN + np.diag(np.repeat([0.15 * length, 0.0], 3)) ** 2))
    assert not mono_inliers.is_well_known(Motion(TRUE, KNOWN + np.diag(np.repeat([0.0, 0.15], 3)) ** 2))
