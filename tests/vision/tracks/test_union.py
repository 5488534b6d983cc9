# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.vision.tracks.landmarks import FeatureMatches, join_matches


def joined(node_of, edges, quality=None):
    quality = np.zeros(len(edges)) if quality is None else np.array(quality)
    return join_matches(np.array(node_of), [matches_of(edges, quality)]).tolist()


def matches_of(edges, quality):
    first, second = np.array(edges, np.int64).reshape(-1, 2).T
    return FeatureMatches(first=first, second=second, distance=quality)


def test_chain_of_matches_is_one_landmark():
    assert joined([0, 1, 2, 0], [(0, 1), (1, 2)]) == [0, 0, 0, -1]


def test_landmarks_are_numbered_by_their_first_feature():
    assert joined([0, 0, 1, 1], [(1, 2), (0, 3)]) == [0, 1, 1, 0]


def test_two_features_of_one_node_are_never_one_landmark():
    label = joined([0, 1, 2, 0], [(0, 1), (1, 2), (2, 3)], [0.1, 0.1, 0.5])
    assert label[0] == label[1] == label[2]
    assert label[3] == -1


def test_better_match_wins_conflict():
    assert joined([0, 1, 0], [(0, 1), (1, 2)], [0.4, 0.2]) == [-1, 0, 0]


def test_torn_track_leaves_two_whole_halves():
    nodes = [0, 1, 2, 2, 3, 0]
    label = joined(nodes, [(0, 1), (1, 2), (3, 4), (4, 5), (2, 4)], [0.1, 0.1, 0.1, 0.1, 0.9])
    assert label == [0, 0, 0, 1, 1, 1]


def test_other_tracks_are_left_alone_by_conflict():
    assert joined([0, 1, 0, 4, 5], [(0, 1), (1, 2), (3, 4)], [0.4, 0.2, 0.9])[3:] == [1, 1]


def test_nothing_matched_is_nothing_joined():
    assert joined([0, 1], []) == [-1, -1]


@pytest.mark.parametrize("seed", range(5))
def test_no_landmark_of_random_matches_holds_node_twice(seed):
    rng = np.random.default_rng(seed)
    node_of = np.sort(rng.integers(0, 12, 300))
    edges = rng.integers(0, 300, (260, 2))
    edges = edges[node_of[edges[:, 0]] != node_of[edges[:, 1]]]
    quality = rng.random(len(edges))
    label = join_matches(node_of, [matches_of(edges, quality)])
    blocks = [matches_of(edges[k::3], quality[k::3]) for k in range(3)]
    np.testing.assert_array_equal(join_matches(node_of, blocks), label)
    rows = np.column_stack([label, node_of])[label >= 0]
    assert len(np.unique(rows, axis=0)) == len(rows)
    assert (np.bincount(label[label >= 0]) >= 2).all()
