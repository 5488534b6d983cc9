# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""SIFT features and corners matched side by side. Each corner is a copy of a SIFT feature."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon.geometry.poses import exp
from hullrecon.studies.matching.corners import MatchWithCorners, is_corner, orders
from hullrecon.vision.appearance.recognition import learn_words
from hullrecon.vision.features.descriptors import FeatureSet, match_descriptors
from hullrecon.vision.features.extraction import Features, no_features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import MatchStrategy, PairMatcher
from hullrecon.vision.pairs.pair_match import Reason
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import (
    DepthPrior,
    NodeFeatures,
    stereo_of_node,
    view_of_node,
)

POINTS = 900
PRIOR = DepthPrior(mean=1.3, sigma=0.2, nearest=0.8, farthest=2.0)
KNOWN = np.diag([0.02**2] * 3 + [0.01**2] * 3)
OPTIONS = MatchOptions()


def unit(rows):
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)


def feature_set(sift, corners, seed=1, noise=0.05):
    """Random descriptors of so many SIFT features and corners, and the same seen with noise."""
    rng = np.random.default_rng(seed)
    rows = rng.gamma(0.5, 1.0, (sift + corners, 128))
    rows[sift:, len(orders()) :] = 0
    sigma = noise * rng.uniform(0.2, 1.0, (len(rows), 1))
    again = np.where(rows > 0, np.abs(rows + sigma * rng.standard_normal(rows.shape)), 0)
    place = np.arange(len(rows))
    return [FeatureSet(descriptor=unit(seen), place=place) for seen in (rows, again)]


def everything(count):
    return tuple(grid.ravel() for grid in np.mgrid[0:count, 0:count])


def test_features_of_one_kind_alone_are_compared():
    first, second = feature_set(6, 6)
    mixed = np.r_[6:12, 0:6]
    moved = FeatureSet(descriptor=second.descriptor[mixed], place=second.place)
    for allowed in (None, everything(12)):
        found = MatchWithCorners(0.5)(first, moved, allowed)
        assert len(found) == 12
        np.testing.assert_array_equal(mixed[found.second], found.first)
        assert ((found.first >= 6) == is_corner(moved.descriptor)[found.second]).all()


@pytest.mark.parametrize("corners_of_first", [True, False])
def test_corner_meets_nothing_where_other_side_has_none(corners_of_first):
    first, second = feature_set(6, 6)
    bare = FeatureSet(descriptor=second.descriptor[:6], place=second.place[:6])
    sets = (first, bare) if corners_of_first else (bare, first)
    found = MatchWithCorners(0.5)(*sets, None)
    np.testing.assert_array_equal(found.first, np.arange(6))
    np.testing.assert_array_equal(found.second, np.arange(6))


def test_without_corners_matching_is_products():
    first, second = feature_set(40, 0, noise=0.6)
    for allowed in (None, everything(40)):
        found = MatchWithCorners(0.3)(first, second, allowed)
        plain = match_descriptors(first, second, allowed)
        for name in ("first", "second", "distance"):
            np.testing.assert_array_equal(getattr(found, name), getattr(plain, name))


@pytest.mark.parametrize("share", [0.1, 0.2, 0.3, 0.5])
def test_corners_are_share_asked_for(share):
    found = MatchWithCorners(share)(*feature_set(200, 300), None)
    got = (found.first >= 200).mean()
    assert got <= share
    assert got == pytest.approx(share, abs=0.01)


def test_larger_share_adds_next_alike_and_drops_none():
    sets, before = feature_set(100, 80), set()
    whole = MatchWithCorners(0.5)(*sets, None)
    distance = dict(zip(whole.first.tolist(), whole.distance.tolist(), strict=True))
    for share in np.linspace(0, 0.5, 11):
        kept = MatchWithCorners(float(share))(*sets, None).first
        corners = set(kept[kept >= 100].tolist())
        assert before <= corners
        left = {k for k in distance if k >= 100} - corners
        if corners and left:
            assert max(distance[k] for k in corners) <= min(distance[k] for k in left)
        before = corners
    assert len(before) == 80


def test_sift_matches_are_all_kept_in_their_order():
    sets = feature_set(50, 40)
    kept = MatchWithCorners(0.2)(*sets, None)
    np.testing.assert_array_equal(kept.first, np.sort(kept.first))
    np.testing.assert_array_equal(kept.first[:50], np.arange(50))
    np.testing.assert_array_equal(kept.second, kept.first)


def test_without_sift_matches_no_corner_is_kept():
    assert len(MatchWithCorners(0.5)(*feature_set(0, 40), None)) == 0


def test_share_of_nothing_is_sift_alone():
    assert len(MatchWithCorners(0.0)(*feature_set(30, 40), None)) == 30


def with_corners(found, point):
    """The features, and behind them each once more as a corner a little aside; their points."""
    aside = found.keypoints + np.array([1.5, 0, 0, 0], np.float32)
    aside[:, 3] = np.nan
    alike = found.descriptors.copy()
    alike[:, len(orders()) :] = 0
    both = Features(
        np.concatenate([found.keypoints, aside]),
        np.concatenate([found.descriptors, alike]),
        np.tile(found.color, (2, 1)),
    )
    return both, np.concatenate([point, point + POINTS])


def sift_alone(features):
    rows = features.scored
    return Features(features.keypoints[rows], features.descriptors[rows], features.color[rows])


@pytest.fixture
def two(look):
    """Two stereo nodes, their points by feature."""

    def node(pose, seed):
        seen = look(pose, seed=seed)
        top, top_id = with_corners(seen.top, seen.top_id)
        bottom, bottom_id = with_corners(seen.bottom, seen.bottom_id)
        return SimpleNamespace(
            pose=seen.pose, top=top, bottom=bottom, top_id=top_id, bottom_id=bottom_id
        )

    return node([0] * 6, 1), node([0.3, 0.02, 0.05, 0.01, -0.04, 0.02], 2)


def match(rig, two, share, informed=True, stereo=True, view=lambda features: features):
    """What the two nodes have in common: points of the first, of the second, which are corners."""
    strategy = MatchStrategy(match_descriptors=MatchWithCorners(share))
    views = []
    for node in two:
        features = NodeFeatures(
            top=view(node.top), bottom=view(node.bottom) if stereo else no_features()
        )
        if stereo:
            pairs = stereo_of_node(
                rig, features.top, features.bottom, PRIOR, OPTIONS, strategy.match_descriptors
            )
            features = replace(features, stereo=pairs)
        views.append(view_of_node(rig, features, PRIOR, OPTIONS.sigma_px))
    truth = two[1].pose.inverse() @ two[0].pose
    prior = None
    if informed:
        off = exp([[0.015, -0.01, 0.01, 0.005, 0.004, -0.006]])
        prior = Motion((off @ truth).matrix()[0], KNOWN)
    found = PairMatcher(rig, OPTIONS, strategy).match(*views, prior, (1,), False)
    assert found.reason is Reason.MATCHED
    corner = is_corner(views[0].descriptor)[found.first]
    return two[0].top_id[found.first], two[1].top_id[found.second], corner


@pytest.mark.parametrize("stereo", [True, False])
@pytest.mark.parametrize("informed", [True, False])
def test_nodes_match_by_kind_with_share_asked_for(rig, two, informed, stereo):
    for share in (0.1, 0.2, 0.3):
        first, second, corner = match(rig, two, share, informed, stereo)
        assert (first == second).mean() > 0.99
        assert ((first >= POINTS) == (second >= POINTS)).all()
        assert corner.mean() == pytest.approx(share, abs=0.05)


@pytest.mark.parametrize("informed", [True, False])
def test_without_share_corners_change_nothing(rig, two, informed):
    both = match(rig, two, 0.0, informed)
    sift = match(rig, two, 0.0, informed, view=sift_alone)
    for one, other in zip(both, sift, strict=True):
        np.testing.assert_array_equal(one, other)


def test_two_cameras_of_node_match_by_kind(rig, two):
    node = two[0]
    for share in (0.0, 0.1, 0.3):
        found = stereo_of_node(rig, node.top, node.bottom, PRIOR, OPTIONS, MatchWithCorners(share))
        assert (node.top_id[found.top] == node.bottom_id[found.bottom]).mean() > 0.98
        corner = is_corner(node.top.descriptors)[found.top]
        assert corner.mean() == pytest.approx(share, abs=0.03)


def test_places_are_recognised_by_sift_alone(two):
    def words(view):
        worker = SimpleNamespace(
            read=lambda node: NodeFeatures(top=view(two[node.image].top), bottom=no_features()),
            options=MatchOptions(),
        )
        nodes = [SimpleNamespace(image=k, stereo=no_matches()) for k in range(2)]
        return learn_words(worker, nodes)

    both, sift = words(lambda features: features), words(sift_alone)
    np.testing.assert_array_equal(both[0].fine, sift[0].fine)
    for one, other in zip(both[1], sift[1], strict=True):
        np.testing.assert_array_equal(one, other)
