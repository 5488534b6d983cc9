# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from hullrecon.vision.features.extraction import nothing
from hullrecon.vision.odometry import chain, view
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.matching import Reason
from hullrecon.vision.tracks.landmarks import NodeFeatures


def pairs(look, places, lost=()):
    nodes = [look([x, 0, 0, 0, 0, 0], seed=k) for k, x in enumerate(places)]
    return lambda k: NodeFeatures(nothing(), nothing()) if k in lost else NodeFeatures(nodes[k].top, nodes[k].bottom)


def test_each_step_has_its_length_and_a_covariance_that_covers_the_error(rig, look):
    found = chain(rig, range(4), pairs(look, [0.0, 0.2, 0.5, 0.6]), MatchOptions())
    for match, length in zip(found, (0.2, 0.3, 0.1), strict=True):
        error = match.motion.second_from_first[:3, 3] + [length, 0, 0]
        assert (np.abs(error) < 5 * np.sqrt(np.diag(match.motion.covariance)[:3]) + 0.001).all()


def test_a_lost_image_breaks_two_links_and_no_more(rig, look):
    found = chain(rig, range(5), pairs(look, [0.0, 0.15, 0.3, 0.45, 0.6], lost=(2,)), MatchOptions())
    assert [match.reason for match in found] == [Reason.MATCHED, Reason.NO_FEATURES, Reason.NO_FEATURES, Reason.MATCHED]


def test_nodes_are_taken_in_the_order_given(rig, look):
    read = pairs(look, [0.0, 0.15, 0.3])
    there = chain(rig, [0, 2], read, MatchOptions())[0].motion.second_from_first
    back = chain(rig, [2, 0], read, MatchOptions())[0].motion.second_from_first
    np.testing.assert_allclose(there @ back, np.eye(4), atol=0.01)
    assert there[0, 3] < 0 < back[0, 3]


def test_one_pair_of_images_makes_no_link(rig, look):
    assert chain(rig, [0], pairs(look, [0.0]), MatchOptions()) == []


def test_depth_comes_from_the_stereo_alone(rig, look):
    seen = view(rig, pairs(look, [0.0])(0), MatchOptions())
    assert seen.stereo.mean() > 0.6
    assert abs(np.median(seen.depth) - 1.3) < 0.03
