# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Nodes whose features are of two kinds; beside each SIFT feature is a corner that looks just like
it.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon.geometry.poses import exp
from hullrecon.vision.appearance.recognition import learn_words
from hullrecon.vision.features.extraction import Features, no_features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pair_match import Reason
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.matching import PairMatcher
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import DepthPrior, stereo_of_node, view_of_node
from hullrecon.vision.tracks.landmarks import NodeFeatures

POINTS = 900
PRIOR = DepthPrior(mean=1.3, sigma=0.2, nearest=0.8, farthest=2.0)
KNOWN = np.diag([0.02**2] * 3 + [0.01**2] * 3)


def with_corners(found, point):
    """The features, and behind them each once more, a little aside, as a corner that looks the
    same; their points.
    """
    aside = found.keypoints + np.array([1.5, 0, 0, 0], np.float32)
    descriptors, color = np.tile(found.descriptors, (2, 1)), np.tile(found.color, (2, 1))
    both = Features(
        np.concatenate([found.keypoints, aside]), descriptors, color, corners=len(found)
    )
    return both, np.concatenate([point, point + POINTS])


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
    """What the two nodes have in common: (points of the first, points of the second, whether of
    corners).
    """
    options = MatchOptions(harris_share=share)
    views = []
    for node in two:
        top, bottom = view(node.top), view(node.bottom) if stereo else no_features()
        pairs = stereo_of_node(rig, top, bottom, PRIOR, options) if stereo else no_matches()
        views.append(view_of_node(rig, top, bottom, pairs, PRIOR, options.sigma_px))
    truth = two[1].pose.inverse() @ two[0].pose
    prior = (
        Motion((exp([[0.015, -0.01, 0.01, 0.005, 0.004, -0.006]]) @ truth).matrix()[0], KNOWN)
        if informed
        else None
    )
    found = PairMatcher(rig, options).match(*views, prior, (1,), False)
    assert found.reason is Reason.MATCHED
    return two[0].top_id[found.first], two[1].top_id[found.second], views[0].corner[found.first]


@pytest.mark.parametrize("stereo", [True, False])
@pytest.mark.parametrize("informed", [True, False])
def test_features_match_those_of_their_kind_and_are_the_share_asked_for(rig, two, informed, stereo):
    for share in (0.1, 0.2, 0.3):
        first, second, corner = match(rig, two, share, informed, stereo)
        assert (first == second).mean() > 0.99
        assert ((first >= POINTS) == (second >= POINTS)).all()
        assert corner.mean() == pytest.approx(share, abs=0.05)


@pytest.mark.parametrize("informed", [True, False])
def test_without_a_share_corners_change_nothing(rig, two, informed):
    with_corners = match(rig, two, 0.0, informed)
    without = match(rig, two, 0.0, informed, view=lambda features: features.without_corners())
    for one, other in zip(with_corners, without, strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_two_cameras_of_a_node_match_by_kind_too(rig, two):
    node = two[0]
    for share in (0.0, 0.1, 0.3):
        found = stereo_of_node(rig, node.top, node.bottom, PRIOR, MatchOptions(harris_share=share))
        assert (node.top_id[found.top] == node.bottom_id[found.bottom]).mean() > 0.98
        assert node.top.corner[found.top].mean() == pytest.approx(share, abs=0.03)


def test_places_are_recognised_by_sift_alone(two):
    def words(view):
        worker = SimpleNamespace(
            read=lambda k, stereo: NodeFeatures(top=view(two[k].top), bottom=no_features()),
            options=MatchOptions(),
        )
        nodes = [SimpleNamespace(image=k, stereo=no_matches()) for k in range(2)]
        return learn_words(worker, nodes)

    both, sift = (
        words(lambda features: features),
        words(lambda features: features.without_corners()),
    )
    np.testing.assert_array_equal(both[0].fine, sift[0].fine)
    for one, other in zip(both[1], sift[1], strict=True):
        np.testing.assert_array_equal(one, other)
