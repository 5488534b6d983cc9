# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
from vision.scene import camera_rig, follow_nodes

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import exp
from hullrecon.vision.features.extraction import no_features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs import matching, pose_from_points
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import FEW, PairMatcher
from hullrecon.vision.pairs.pair_match import REASON_TEXTS, Reason, agrees
from hullrecon.vision.pairs.stereo_adjustment import NodeObservations, adjust_stereo_motion
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import DepthPrior, NodeFeatures, stereo_of_node, view_of_node

OPTIONS = MatchOptions()
PRIOR = DepthPrior(mean=1.3, sigma=0.2, nearest=0.8, farthest=2.0)
KNOWN = np.diag([0.02**2] * 3 + [0.01**2] * 3)
HERE, THERE = [0, 0, 0, 0, 0, 0], [0.3, 0.02, 0.05, 0.01, -0.04, 0.02]


def stereo_view(rig, node):
    stereo = stereo_of_node(rig, node.top, node.bottom, PRIOR, OPTIONS)
    return view_of_node(
        rig, NodeFeatures(top=node.top, bottom=node.bottom, stereo=stereo), PRIOR, OPTIONS.sigma_px
    )


def mono_view(rig, node, prior=PRIOR):
    return view_of_node(
        rig,
        NodeFeatures(top=node.top, bottom=no_features(), stereo=no_matches()),
        prior,
        OPTIONS.sigma_px,
    )


def truth(first, second):
    return (second.pose.inverse() @ first.pose).matrix()[0]


def expected(first, second, off=(0.015, -0.01, 0.01, 0.005, 0.004, -0.006)):
    return Motion((exp([off]) @ second.pose.inverse() @ first.pose).matrix()[0], KNOWN)


@pytest.fixture
def two(look):
    return look(HERE, seed=1), look(THERE, seed=2)


@pytest.mark.parametrize("informed", [True, False])
def test_two_stereo_nodes_give_right_matches_and_their_motion(rig, two, informed):
    first, second = two
    prior = expected(first, second) if informed else None
    found = PairMatcher(rig, OPTIONS).match(
        stereo_view(rig, first), stereo_view(rig, second), prior, (1,), False
    )
    assert found.reason is Reason.MATCHED
    assert (first.top_id[found.first] == second.top_id[found.second]).mean() > 0.99
    assert len(found.first) > 0.85 * len(np.intersect1d(first.top_id, second.top_id))
    gap = np.linalg.inv(found.motion.second_from_first) @ truth(first, second)
    assert np.linalg.norm(gap[:3, 3]) < 0.003
    assert agrees(found, Motion(truth(first, second), 1e-12 * np.eye(6)), 40.0)


def test_from_few_seeds_motion_is_that_of_matches_it_comes_with(rig, two, monkeypatch):
    """The first motion is so rough that the search along it misses some of what the second search
    finds.
    """
    rough = truth(*two) @ exp([[0.012, 0.008, 0.0, 0.006, -0.004, 0.01]]).matrix()[0]
    monkeypatch.setattr(pose_from_points, "refine", lambda *_: (rough, 1e-6 * np.eye(6)))
    monkeypatch.setattr(matching, "_count_inliers", lambda *_: OPTIONS.min_inliers)
    monkeypatch.setattr(matching, "SEEDS", 30)
    views, searched = [stereo_view(rig, node) for node in two], []
    search = PairMatcher.search_along
    monkeypatch.setattr(
        PairMatcher, "search_along", lambda *given: searched.append(search(*given)) or searched[-1]
    )
    found = PairMatcher(rig, OPTIONS).match(*views, expected(*two), (1,), False)
    assert found.reason is Reason.MATCHED
    assert found.putative < FEW
    assert len(searched[0]) < 0.9 * len(searched[1]) == 0.9 * len(found.first)
    seen = [
        NodeObservations(lead=view.xy[rows], other=view.other[rows], point=view.point[rows])
        for view, rows in zip(views, (found.first, found.second), strict=True)
    ]
    again = adjust_stereo_motion(found.motion.second_from_first, *seen, rig.from_top(Camera.BOTTOM))
    step = np.linalg.inv(found.motion.second_from_first) @ again.second_from_first
    sigma = np.sqrt(np.diag(again.covariance))
    assert np.linalg.norm(step[:3, 3]) < 0.02 * np.linalg.norm(sigma[:3])
    np.testing.assert_allclose(np.sqrt(np.diag(found.motion.covariance)), sigma, rtol=0.02)


def test_one_stereo_and_one_mono_node_give_motion_with_length(rig, two):
    first, second = two
    for pair in (
        (stereo_view(rig, first), mono_view(rig, second)),
        (mono_view(rig, first), stereo_view(rig, second)),
    ):
        found = PairMatcher(rig, OPTIONS).match(*pair, expected(first, second), (1,), False)
        assert found.reason is Reason.MATCHED
        assert found.scaled
        np.testing.assert_allclose(found.motion.second_from_first, truth(first, second), atol=0.02)


@pytest.mark.parametrize("informed", [True, False])
def test_two_mono_nodes_give_direction_and_right_matches(rig, two, informed):
    first, second = two
    mono = camera_rig(rig.model(Camera.TOP))
    depth, prior = (PRIOR, expected(first, second)) if informed else (None, None)
    found = PairMatcher(mono, OPTIONS).match(
        mono_view(mono, first, depth), mono_view(mono, second, depth), prior, (1,), True
    )
    assert found.reason is Reason.MATCHED
    assert not found.scaled
    assert (first.top_id[found.first] == second.top_id[found.second]).mean() > 0.97


def test_one_image_twice_has_no_direction_of_motion(rig, two):
    first, _ = two
    mono = camera_rig(rig.model(Camera.TOP))
    found = PairMatcher(mono, OPTIONS).match(
        mono_view(mono, first), mono_view(mono, first), None, (1,), True
    )
    assert found.reason is Reason.NO_MOTION
    assert found.motion is None
    assert len(found.first) > 0.9 * len(first.top)
    np.testing.assert_array_equal(found.first, found.second)


def test_mono_motion_has_covariance_of_its_five_numbers(rig, two):
    first, second = two
    mono = camera_rig(rig.model(Camera.TOP))
    found = PairMatcher(mono, OPTIONS).match(
        mono_view(mono, first), mono_view(mono, second), expected(first, second), (1,), True
    )
    sigma = np.sqrt(np.linalg.eigvalsh(found.motion.covariance))
    assert sigma[-1] == pytest.approx(0.02, rel=0.05)  # navigation's, along the motion
    assert sigma[:-1].max() < 0.02
    gap = np.linalg.inv(found.motion.second_from_first[:3, :3]) @ truth(first, second)[:3, :3]
    assert np.arccos(0.5 * (np.trace(gap) - 1)) < 0.01


def test_mono_motion_against_navigation_is_refused(rig, two):
    """Navigation has the rotation right and is sure that the vehicle went down the image, not
    across it.
    """
    first, second = two
    mono = camera_rig(rig.model(Camera.TOP))
    wrong = truth(first, second)
    wrong[:3, 3] = [0.0, 0.3, 0.0]
    views = mono_view(mono, first, None), mono_view(mono, second, None)
    assert (
        PairMatcher(mono, OPTIONS).match(*views, Motion(wrong, KNOWN), (1,), True).reason
        is Reason.AGAINST_NAVIGATION
    )
    right = Motion(truth(first, second), KNOWN)
    assert PairMatcher(mono, OPTIONS).match(*views, right, (1,), True).reason is Reason.MATCHED


def few_points(view, count):
    """The view with all but `count` of its stereo points lost."""
    rows = np.flatnonzero(view.stereo)[count:]
    point, other = view.point.copy(), view.other.copy()
    point[rows] = other[rows] = np.nan
    return replace(view, point=point, other=other)


@pytest.mark.parametrize("count", [1, 5])
def test_pair_with_few_stereo_points_is_matched_like_mono(rig, two, count):
    first, second = two
    views = few_points(stereo_view(rig, first), count), few_points(stereo_view(rig, second), count)
    found = PairMatcher(rig, OPTIONS).match(*views, expected(first, second), (1,), True)
    assert found.reason is Reason.MATCHED
    assert not found.scaled
    assert (first.top_id[found.first] == second.top_id[found.second]).mean() > 0.97


def test_full_search_overrules_navigation_that_points_elsewhere(rig, two):
    first, second = two
    astray = expected(first, second, off=(0.4, 0.3, 0.0, 0.0, 0.0, 0.0))
    views = stereo_view(rig, first), stereo_view(rig, second)
    assert (
        PairMatcher(rig, OPTIONS).match(*views, astray, (1,), True).reason
        is Reason.AGAINST_NAVIGATION
    )
    assert PairMatcher(rig, OPTIONS).match(*views, astray, (1,), False).reason in (
        Reason.FEW_PUTATIVE,
        Reason.FEW_INLIERS,
    )


def test_nodes_that_see_different_places_do_not_match(rig, look):
    first, second = look(HERE), look([2.6, 0, 0, 0, 0, 0])
    found = PairMatcher(rig, OPTIONS).match(
        stereo_view(rig, first), stereo_view(rig, second), None, (1,), True
    )
    assert found.reason in (Reason.FEW_PUTATIVE, Reason.FEW_INLIERS)
    assert found.motion is None
    assert len(found.first) == 0


def test_image_without_features_is_named_as_such(rig, look):
    view, empty = (
        stereo_view(rig, look(HERE)),
        view_of_node(
            rig,
            NodeFeatures(top=no_features(), bottom=no_features(), stereo=no_matches()),
            None,
            0.4,
        ),
    )
    assert (
        PairMatcher(rig, OPTIONS).match(view, empty, None, (1,), True).reason is Reason.NO_FEATURES
    )


def test_lookalike_point_is_kept_apart_by_its_place(rig, wall, two):
    """Every descriptor occurs twice on the wall: only the place tells one from the other."""
    first, second = two
    for node in two:
        node.top.descriptors[:] = wall.descriptors[node.top_id % 450]
        node.bottom.descriptors[:] = wall.descriptors[node.bottom_id % 450]
    found = PairMatcher(rig, OPTIONS).match(
        stereo_view(rig, first), stereo_view(rig, second), expected(first, second), (1,), False
    )
    assert found.reason is Reason.MATCHED
    assert (first.top_id[found.first] == second.top_id[found.second]).mean() > 0.98


def test_same_pair_gives_same_matches_twice(rig, two):
    views = [stereo_view(rig, node) for node in two]
    first, second = (PairMatcher(rig, OPTIONS).match(*views, None, (1, 2), True) for _ in range(2))
    np.testing.assert_array_equal(first.first, second.first)
    np.testing.assert_array_equal(first.motion.second_from_first, second.motion.second_from_first)


def test_chain_of_stereo_pairs_adds_up_to_path(rig, look):
    nodes = [look([0.25 * k, 0.0, 0.02 * k, 0.0, 0.01 * k, 0.0], seed=k) for k in range(5)]
    found = follow_nodes(
        rig, range(5), lambda k: NodeFeatures(top=nodes[k].top, bottom=nodes[k].bottom)
    )
    path = np.eye(4)
    for step in found:
        path = path @ step.motion.second_from_first
    np.testing.assert_allclose(path, nodes[4].pose.matrix()[0], atol=0.01)


def test_every_reason_has_text():
    assert set(REASON_TEXTS) == set(Reason)
    assert REASON_TEXTS[Reason.AGAINST_NAVIGATION] == "inconsistent with navigation"


def test_motion_without_length_has_five_sixths_of_chi2(rig, two):
    """A rotation off by r sigma has the chi2 r^2 either way."""
    first, second = two
    known = Motion(truth(first, second), np.diag([0.02**2] * 3 + [0.01**2] * 3))
    turned = known.second_from_first.copy()
    # chi2 46
    turned[:3, :3] = turned[:3, :3] @ exp([[0, 0, 0, 0.0, 0.0, 0.01 * 46**0.5]]).matrix()[0][:3, :3]
    found = PairMatcher(rig, OPTIONS).match(
        stereo_view(rig, first), stereo_view(rig, second), None, (1,), True
    )
    certain = replace(found, motion=Motion(turned, 1e-12 * np.eye(6)))
    assert agrees(certain, known, 50.0)
    assert not agrees(replace(certain, scaled=False), known, 50.0)
    assert agrees(replace(certain, scaled=False), known, 50.0 * 6 / 5)


def test_min_inliers_decides_whether_pair_matches(rig, two):
    views = [stereo_view(rig, node) for node in two]
    found = PairMatcher(rig, OPTIONS).match(*views, expected(*two), (1,), False)
    options = MatchOptions(min_inliers=len(found.first) + 1)
    strict = PairMatcher(rig, options).match(*views, expected(*two), (1,), False)
    assert found.reason is Reason.MATCHED
    assert strict.reason is Reason.FEW_INLIERS


def test_smaller_sigma_px_narrows_the_search(rig, two):
    views = [stereo_view(rig, node) for node in two]
    wide, narrow = (
        PairMatcher(rig, MatchOptions(sigma_px=sigma)).match(*views, expected(*two), (1,), False)
        for sigma in (0.4, 0.02)
    )
    assert len(narrow.first) < 0.8 * len(wide.first)
