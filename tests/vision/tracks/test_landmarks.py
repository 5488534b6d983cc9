# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon.vision.features.extraction import Features, no_features
from hullrecon.vision.stereo.matching import StereoMatches, no_matches
from hullrecon.vision.tracks.landmarks import FeatureMatches, NodeFeatures, build_tracks

NODE_FEATURES = 3


def features(base, n, color):
    across = base + np.arange(n)
    table = np.column_stack([across, np.full(n, base), np.ones(n), across / 1000]).astype(
        np.float32
    )
    return Features(table, np.zeros((n, 128), np.uint8), np.full((n, 3), color, np.uint8))


def stereo(*rows):
    a = np.array(rows, np.int64).reshape(-1, 2)
    return StereoMatches(top=a[:, 0], bottom=a[:, 1], point=np.ones((len(a), 3)))


def matches(*rows):
    """Rows of first node, first row, second node, second row."""
    a = np.array(rows, np.int64).reshape(-1, 4)
    first, second = (NODE_FEATURES * a[:, k] + a[:, k + 1] for k in (0, 2))
    return FeatureMatches(first=first, second=second, distance=np.zeros(len(a), np.float32))


@pytest.fixture
def dive():
    """Three nodes of three features; the last has a bottom image alone."""
    nodes = [
        NodeFeatures(top=features(100, 3, 10), bottom=features(500, 3, 0)),
        NodeFeatures(top=features(200, 3, 30), bottom=features(600, 3, 0)),
    ]
    nodes.append(NodeFeatures(top=no_features(), bottom=features(700, 3, 50)))
    pairs = [stereo((0, 2), (2, 1)), stereo((1, 0)), no_matches()]
    return SimpleNamespace(read=nodes.__getitem__, stereo=pairs, count=np.full(3, NODE_FEATURES))


def made(dive, found, single_node=True, find_outliers=None):
    return build_tracks(dive.count, dive.stereo, [found], dive.read, single_node, find_outliers)


def test_track_holds_both_pixels_where_both_cameras_saw_it(dive):
    tracks = made(dive, matches((0, 0, 1, 1), (1, 1, 2, 2)), single_node=False)
    np.testing.assert_array_equal(tracks.landmark, [0, 0, 0])
    np.testing.assert_array_equal(tracks.node, [0, 1, 2])
    np.testing.assert_array_equal(tracks.top, [[100, 100], [201, 200], [np.nan, np.nan]])
    np.testing.assert_array_equal(tracks.bottom, [[502, 500], [600, 600], [702, 700]])
    np.testing.assert_array_equal(tracks.color, [[30, 30, 30]])


def test_observation_has_mean_response_of_its_images(dive):
    found = matches((0, 0, 1, 1), (1, 1, 2, 2), (0, 1, 1, 2))
    tracks = made(dive, found, single_node=False)
    np.testing.assert_allclose(
        tracks.response, [(0.1 + 0.502) / 2, (0.201 + 0.6) / 2, 0.702, 0.101, 0.202], rtol=1e-6
    )
    nodes = [NodeFeatures(top=dive.read(k).top, bottom=no_features()) for k in range(2)]
    for node in nodes:
        node.top.keypoints[-1, 3] = np.nan
    tracks = build_tracks(
        np.array([3, 3]),
        [no_matches()] * 2,
        [matches((0, 1, 1, 1), (0, 2, 1, 2))],
        nodes.__getitem__,
        False,
    )
    np.testing.assert_array_equal(np.isnan(tracks.response), [False, False, True, True])


def test_what_one_camera_alone_matched_keeps_its_one_pixel(dive):
    tracks = made(dive, matches((0, 1, 1, 2)), single_node=False)
    assert np.isfinite(tracks.top).all()
    assert np.isnan(tracks.bottom).all()


def test_stereo_points_of_single_node_are_landmarks_when_wanted(dive):
    tracks = made(dive, matches((0, 0, 1, 1)))
    assert np.bincount(tracks.landmark).tolist() == [2, 1]
    assert tracks.node.tolist() == [0, 1, 0]
    np.testing.assert_array_equal(tracks.bottom[2], [501, 500])


def test_outlier_is_dropped_and_rest_is_judged_anew(dive):
    tracks = made(
        dive,
        matches((0, 1, 1, 2)),
        find_outliers=lambda node, label, top, bottom: (node == 1) & np.isnan(bottom[:, 0]),
    )
    # three stereo points; the mono track of two lost one end and with it the other
    assert len(tracks.color) == 3
    assert np.isfinite(tracks.bottom).all()


def test_tracks_are_sorted_by_landmark_and_node_without_gaps(dive):
    tracks = made(dive, matches((0, 0, 1, 1), (1, 2, 2, 0), (0, 2, 2, 1)))
    rows = np.column_stack([tracks.landmark, tracks.node])
    np.testing.assert_array_equal(rows, np.unique(rows, axis=0))
    np.testing.assert_array_equal(np.unique(tracks.landmark), np.arange(len(tracks.color)))


def test_no_matches_make_no_tracks(dive):
    empty = build_tracks(np.zeros(3, np.int64), [no_matches()] * 3, [matches()], dive.read, True)
    assert len(empty.landmark) == len(empty.color) == 0
