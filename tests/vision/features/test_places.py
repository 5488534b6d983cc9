# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A place that SIFT describes twice, for two orientations, is seen once."""

from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon.geometry.poses import exp
from hullrecon.vision.features.descriptors import Putative, first_at_place, match_places
from hullrecon.vision.features.extraction import Features, extract, no_features
from hullrecon.vision.options import FeatureOptions, MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import PairMatcher
from hullrecon.vision.pairs.pair_match import Reason
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import DepthPrior, stereo_of_node, view_of_node
from hullrecon.vision.tracks.landmarks import FeatureMatches, NodeFeatures, build_tracks

PRIOR = DepthPrior(mean=1.3, sigma=0.2, nearest=0.8, farthest=2.0)
OPTIONS = MatchOptions()
KNOWN = np.diag([0.02**2] * 3 + [0.01**2] * 3)
ORIENTATIONS = 2


def described_twice(found, point):
    """The features, each followed by itself with another description, and their points."""
    turned = np.roll(found.descriptors, 40, axis=1)
    descriptors = np.stack([found.descriptors, turned], axis=1).reshape(
        -1, found.descriptors.shape[1]
    )
    keypoints, color = (
        np.repeat(table, ORIENTATIONS, axis=0) for table in (found.keypoints, found.color)
    )
    return Features(keypoints, descriptors, color), np.repeat(point, ORIENTATIONS)


@pytest.fixture
def two(look):
    """Two stereo nodes as seen, and with every place described twice."""
    seen = look([0] * 6, seed=1), look([0.3, 0.02, 0.05, 0.01, -0.04, 0.02], seed=2)
    twice = []
    for node in seen:
        top, top_id = described_twice(node.top, node.top_id)
        bottom, bottom_id = described_twice(node.bottom, node.bottom_id)
        twice.append(
            SimpleNamespace(
                pose=node.pose, top=top, bottom=bottom, top_id=top_id, bottom_id=bottom_id
            )
        )
    return seen, twice


def match(rig, nodes, stereo, informed):
    views = []
    for node in nodes:
        pairs = (
            stereo_of_node(rig, node.top, node.bottom, PRIOR, OPTIONS) if stereo else no_matches()
        )
        bottom = node.bottom if stereo else no_features()
        views.append(
            view_of_node(
                rig,
                NodeFeatures(top=node.top, bottom=bottom, stereo=pairs),
                PRIOR,
                OPTIONS.sigma_px,
            )
        )
    truth = nodes[1].pose.inverse() @ nodes[0].pose
    prior = (
        Motion((exp([[0.015, -0.01, 0.01, 0.005, 0.004, -0.006]]) @ truth).matrix()[0], KNOWN)
        if informed
        else None
    )
    found = PairMatcher(rig, OPTIONS).match(*views, prior, (1,), False)
    assert found.reason is Reason.MATCHED
    return found


@pytest.mark.parametrize("stereo", [True, False])
@pytest.mark.parametrize("informed", [True, False])
def test_what_is_described_twice_is_matched_once(rig, two, stereo, informed):
    seen, twice = two
    once, found = match(rig, seen, stereo, informed), match(rig, twice, stereo, informed)
    points = twice[0].top_id[found.first]
    assert len(np.unique(points)) == len(points)
    assert (points == twice[1].top_id[found.second]).mean() > 0.99
    assert len(points) == pytest.approx(len(once.first), rel=0.02)
    np.testing.assert_allclose(
        np.sqrt(np.diag(found.motion.covariance)),
        np.sqrt(np.diag(once.motion.covariance)),
        rtol=0.2,
    )


def test_two_cameras_match_place_once_for_all_its_rows(rig, two):
    node = two[1][0]
    found = stereo_of_node(rig, node.top, node.bottom, PRIOR, OPTIONS)
    assert len(np.unique(node.top_id[found.top])) == len(found) > 150
    view = view_of_node(
        rig, NodeFeatures(top=node.top, bottom=node.bottom, stereo=found), PRIOR, OPTIONS.sigma_px
    )
    assert view.stereo.sum() == ORIENTATIONS * len(found)
    for values in (view.point, view.other, view.depth, view.depth_sigma):
        np.testing.assert_array_equal(values[0::2], values[1::2])


def test_place_whose_description_changes_is_one_landmark():
    features, _ = described_twice(
        Features(
            np.float32([[10, 20, 3, 0.1], [90, 20, 3, 0.1]]),
            np.zeros((2, 128), np.uint8),
            np.zeros((2, 3), np.uint8),
        ),
        np.arange(2),
    )
    place = features.place
    # the first place by its first description from node 0 to 1, by its second from 1 to 2
    first, second = (
        place[[0, 1]] + len(features) * np.array([0, 1]),
        place[[0, 1]] + len(features) * np.array([1, 2]),
    )
    found = FeatureMatches(first=first, second=second, distance=np.zeros(2, np.float32))
    node = NodeFeatures(top=features, bottom=no_features())
    tracks = build_tracks(
        np.full(3, len(features)), [no_matches()] * 3, [found], lambda k: node, False
    )
    np.testing.assert_array_equal(tracks.landmark, [0, 0, 0])
    np.testing.assert_array_equal(tracks.node, [0, 1, 2])


def test_of_matches_of_place_most_alike_is_kept():
    place = np.array([0, 0, 2, 3, 3])
    found = Putative(
        first=np.array([0, 1, 2, 4]),
        second=np.array([3, 2, 0, 4]),
        distance=np.float32([0.3, 0.1, 0.2, 0.2]),
    )
    kept = match_places(found, place, np.arange(5))
    np.testing.assert_array_equal(kept.first, [0, 2, 3])
    np.testing.assert_array_equal(kept.second, [2, 0, 4])
    np.testing.assert_array_equal(kept.distance, np.float32([0.1, 0.2, 0.2]))


def test_rows_at_one_pixel_stand_for_one_place():
    at = np.float32(
        [[5, 1, 2, 1], [5, 1, 2, 1], [5, 2, 2, 1], [6, 2, 2, 1], [6, 2, 3, 1], [6, 2, 4, 1]]
    )
    np.testing.assert_array_equal(first_at_place(at), [0, 0, 2, 3, 3, 3])
    assert len(first_at_place(at[:0])) == 0


def test_what_sift_finds_at_one_pixel_lies_side_by_side():
    rng = np.random.default_rng(3)
    found = extract(rng.integers(0, 255, (300, 300), np.uint8), FeatureOptions())
    places = len(np.unique(found.keypoints[:, :2], axis=0))
    assert len(np.unique(found.place)) == places < len(found)
