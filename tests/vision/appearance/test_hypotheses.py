# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a path of two pieces leaves open, and which of its images are compared."""

from dataclasses import dataclass

import numpy as np
import pytest

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.vision.appearance.hypotheses import (
    APART,
    STATIONS,
    footprint_m,
    largest_sigma,
    likeliest_pairs,
    may_be_one,
    open_places,
    scene_offsets,
)
from hullrecon.vision.appearance.vocabulary import invert
from hullrecon.vision.pairs.camera_track import CameraTrack

CAMERA = CameraModel(640, 512, 640.0, 640.0, 319.5, 255.5)
EACH, STEP_M, DEPTH_M = 20, 0.41, 1.25  # a footprint of 1.25 by 1 m
ALL = np.arange(2 * EACH)
DEPTHS = np.full(2 * EACH, DEPTH_M)


@dataclass(frozen=True)
class TwoPieces:
    """Well known within each piece, to so many metres along x between them."""

    between_m: float

    def relative_covariance(self, first, second):
        apart = (first < EACH) != (second < EACH)
        return np.where(apart, self.between_m**2, 1e-6)[:, None, None] * np.diag(
            [1.0, 0.01, 0.01, 0, 0, 0]
        )


def path(between_m=3.0, off_m=0.0):
    """Cameras that look along z; the second piece begins where the first ended, off_m aside, and
    goes back.
    """
    out = np.arange(EACH) * STEP_M
    at = np.column_stack([np.r_[out, off_m + out[::-1]], np.zeros(2 * EACH), np.zeros(2 * EACH)])
    return CameraTrack(
        global_from_camera=Poses(np.tile([0, 0, 0, 1.0], (2 * EACH, 1)), at),
        errors=TwoPieces(between_m),
    )


def words(truth):
    """Three words a place, shared by images less than a footprint apart; truth (n,) m."""
    return invert([np.floor(x / 0.4).astype(int) + np.arange(3) for x in truth], 200)


def test_footprint_is_smaller_side_of_image():
    assert footprint_m(np.array([1.0, 1.25, np.nan, 2.0]), CAMERA) == pytest.approx(
        1.25 * 512 / 640
    )


def test_offset_of_scenes_is_that_of_their_middles():
    track = path(between_m=2.0, off_m=0.7)
    offset, covariance = scene_offsets(track, np.array([0]), np.array([2 * EACH - 1]), DEPTHS)
    np.testing.assert_allclose(offset, [[-0.7, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(covariance[0], 4.0 * np.diag([1.0, 0.01, 0.01]))
    assert largest_sigma(covariance)[0] == pytest.approx(2.0)


def test_gate_is_of_path_and_of_scene():
    offset = np.array([[3.9, 0, 0], [4.2, 0, 0], [0, 0.3, 0], [0, 2.0, 0]])
    covariance = np.tile(np.diag([1.0, 1e-4, 1e-4]), (4, 1, 1))
    assert may_be_one(offset, covariance, 0.2).tolist() == [True, False, True, False]


def test_path_known_to_less_than_footprint_leaves_nothing_open():
    assert open_places(path(between_m=0.3), ALL, DEPTHS, CAMERA) is None
    assert open_places(path(), ALL[:1], DEPTHS, CAMERA) is None


def test_places_farther_apart_than_path_allows_are_not_open():
    assert open_places(path(between_m=1.5, off_m=60.0), ALL, DEPTHS, CAMERA) is None


def test_places_are_open_between_parts_and_known_within_one():
    found = open_places(path(), ALL, DEPTHS, CAMERA)
    open_between = found.of_keyframes(ALL, found.open)
    assert open_between[:EACH, EACH:].all()
    assert not open_between[:EACH, :EACH].any()
    apart = found.of_keyframes(ALL, found.apart)
    distance = np.abs(np.arange(EACH)[:, None] - np.arange(EACH)) * STEP_M
    np.testing.assert_array_equal(apart[:EACH, :EACH], distance > APART * 1.0)
    assert not apart[:EACH, EACH:].any()
    assert found.reach_m == pytest.approx((EACH - 1) * STEP_M)


def test_pairs_compared_look_alike_and_lie_in_different_pieces():
    track, truth = path(), path().global_from_camera.translation[:, 0]
    found = open_places(track, ALL, DEPTHS, CAMERA)
    pairs, control = likeliest_pairs(track, ALL, DEPTHS, CAMERA, found, words(truth))
    assert len(pairs) >= EACH
    assert ((pairs[:, 0] < EACH) & (pairs[:, 1] >= EACH)).all()
    assert np.abs(truth[pairs[:, 0]] - truth[pairs[:, 1]]).max() < 1.0
    assert len(control) == 0  # nothing apart shares a word
    np.testing.assert_array_equal(pairs, np.unique(pairs, axis=0))


def test_control_is_of_places_known_to_be_two_that_look_alike():
    track, truth = path(), path().global_from_camera.translation[:, 0]
    found = open_places(track, ALL, DEPTHS, CAMERA)
    _, control = likeliest_pairs(track, ALL, DEPTHS, CAMERA, found, words(np.mod(truth, 3.2)))
    assert len(control) > 10
    assert ((control < EACH).all(axis=1) | (control >= EACH).all(axis=1)).all()
    gap = np.abs(truth[control[:, 0]] - truth[control[:, 1]])
    assert gap.min() > APART
    assert np.abs(gap - 3.2).min() < 0.3


def test_outage_next_to_station_makes_no_control_of_first_image(monkeypatch):
    """The station next to a keyframe may stand on the other side of the outage."""
    monkeypatch.setattr("hullrecon.vision.appearance.hypotheses.STATIONS", 7)
    track, truth = path(), path().global_from_camera.translation[:, 0]
    found = open_places(track, ALL, DEPTHS, CAMERA)
    _, control = likeliest_pairs(track, ALL, DEPTHS, CAMERA, found, words(np.mod(truth, 3.2)))
    assert ((control < EACH).all(axis=1) | (control >= EACH).all(axis=1)).all()


LONG, SHORT = 400, 12


@dataclass(frozen=True)
class ShortPart:
    """Three parts, known well within and to 3 m between them: the second is SHORT and shows what
    the middle of the first does.
    """

    edges: tuple[int, ...] = (0, LONG, LONG + SHORT, 2 * LONG)

    def relative_covariance(self, first, second):
        a, b = (np.searchsorted(self.edges, nodes, side="right") for nodes in (first, second))
        return np.where(a != b, 9.0, 1e-6)[:, None, None] * np.diag([1.0, 0.01, 0.01, 0, 0, 0])


def test_each_part_is_asked_however_short_it_is():
    errors = ShortPart()
    truth = np.arange(2 * LONG) * STEP_M
    truth[LONG : LONG + SHORT] = (LONG // 2 + np.arange(SHORT)) * STEP_M
    at = np.column_stack([truth, np.zeros((2 * LONG, 2))])
    at[LONG : LONG + SHORT, 0] += 1.5
    track = CameraTrack(
        global_from_camera=Poses(np.tile([0, 0, 0, 1.0], (2 * LONG, 1)), at), errors=errors
    )
    depths, keyframes = np.full(2 * LONG, DEPTH_M), np.arange(2 * LONG)
    found = open_places(track, keyframes, depths, CAMERA)
    assert found.edges.tolist() == list(errors.edges)
    part = np.searchsorted(errors.edges, keyframes, side="right")
    assert len(np.unique(found.station[part == 2])) == 3
    assert not np.isin(found.station[part == 2], found.station[part != 2]).any()
    images = invert([np.floor(x / 0.4).astype(int) + np.arange(3) for x in truth], 1000)
    pairs, _ = likeliest_pairs(track, keyframes, depths, CAMERA, found, images)
    of_part = pairs[(part[pairs] == 2).any(axis=1)]
    assert len(np.unique(of_part[part[of_part] == 2])) >= 10
    assert (np.abs(np.diff(truth[of_part])) < 1.5).all()


def test_one_part_is_asked_evenly():
    class Walk:
        def relative_covariance(self, first, second):
            return 1e-3 * np.abs(first - second)[:, None, None] ** 2 * np.eye(6)

    n = 1000
    at = np.column_stack([0.01 * np.arange(n), np.zeros((n, 2))])
    track = CameraTrack(
        global_from_camera=Poses(np.tile([0, 0, 0, 1.0], (n, 1)), at), errors=Walk()
    )
    found = open_places(track, np.arange(n), np.full(n, DEPTH_M), CAMERA)
    assert found.edges.tolist() == [0, n]
    stations = np.linspace(0, n - 1, STATIONS).round()
    np.testing.assert_array_equal(
        found.station, np.abs(np.arange(n)[:, None] - stations).argmin(axis=1)
    )


def test_pairs_are_bounded_and_best_place_of_image_comes_first(monkeypatch):
    monkeypatch.setattr("hullrecon.vision.appearance.hypotheses.MOST_PAIRS", 12)
    track, truth = path(), path().global_from_camera.translation[:, 0]
    found = open_places(track, ALL, DEPTHS, CAMERA)
    pairs, _ = likeliest_pairs(track, ALL, DEPTHS, CAMERA, found, words(truth))
    assert len(pairs) == 12
    assert np.abs(truth[pairs[:, 0]] - truth[pairs[:, 1]]).max() < 0.01
