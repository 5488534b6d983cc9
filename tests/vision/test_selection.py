# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import TrajectoryErrorModel
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.selection import footprint_overlap, propose

CAMERA = CameraModel(640, 512, 640.0, 640.0, 319.5, 255.5)  # at 1 m: 1 m wide, 0.8 m high
DEPTH = 1.0


def random_walk(covariance):
    """An error model without errors that persist: covariance (n, 6, 6) of twists that accumulates."""
    n = len(covariance)
    return TrajectoryErrorModel(
        by_error=np.zeros((n, 6, 0)), error_covariance=np.zeros((0, 0)), walk=covariance, white=np.zeros((n, 6, 6))
    )


def track(places, sigma_m=0.0):
    """Cameras that all look along z, at x, y."""
    n = len(places)
    covariance = np.zeros((n, 6, 6))
    covariance[:, [0, 1, 2], [0, 1, 2]] = (sigma_m**2 * np.arange(n) / max(n - 1, 1))[:, None]
    poses = Poses(np.tile([0, 0, 0, 1.0], (n, 1)), np.column_stack([places, np.zeros(n)]))
    return CameraTrack(global_from_camera=poses, errors=random_walk(covariance))


def lawnmower(step=0.2, leg=11, apart=0.5):
    """Two legs of 2 m, there and back."""
    x = step * np.arange(leg)
    return np.concatenate([np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + apart])])


def proposed(places, options=None, depth=DEPTH, sigma_m=0.0, usable=None, salient=None):
    n = len(places)
    usable = np.ones(n, bool) if usable is None else usable
    salient = np.ones(n, bool) if salient is None else salient
    return propose(track(places, sigma_m), usable, np.full(n, depth), CAMERA, options or MatchOptions(), salient)


def pairs(proposal, across=None):
    rows = np.ones(len(proposal), bool) if across is None else proposal.across == across
    return set(zip(proposal.first[rows].tolist(), proposal.second[rows].tolist(), strict=True))


def test_overlap_is_the_share_of_the_image_that_is_seen_again():
    places = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.8], [0.25, 0.4]])
    found = footprint_overlap(track(places), np.zeros(4, int), np.arange(4), np.ones(4), CAMERA)
    np.testing.assert_allclose(found, [1.0, 0.5, 0.0, 0.375], atol=0.01)


def test_without_depth_no_overlap_is_claimed():
    places = np.array([[0.0, 0.0], [0.5, 0.0]])
    assert np.isnan(footprint_overlap(track(places), np.array([0]), np.array([1]), np.array([np.nan, 1.0]), CAMERA)).all()


def test_neighbours_along_the_dive_are_always_compared():
    _, found = proposed(lawnmower(), MatchOptions(sequential=2, across=0))
    assert pairs(found) == {(k, k + s) for s in (1, 2) for k in range(22 - s)}


def test_nodes_of_two_legs_that_saw_the_same_place_are_compared():
    _, found = proposed(lawnmower(), MatchOptions(sequential=1, across=1))
    across = pairs(found, across=True)
    assert {(k, 21 - k) for k in range(7)} <= across  # opposite each other; at the turn the footprint is never left
    assert {b for a, b in across if a == 0} == {21}  # the first node's best partner is the last node


def test_a_neighbour_that_was_never_lost_from_sight_is_not_across_a_leg():
    slow = np.column_stack([0.05 * np.arange(30), np.zeros(30)])
    _, found = proposed(slow, MatchOptions(sequential=1, across=3))
    assert pairs(found, across=True) == set()


def test_legs_too_far_apart_are_compared_only_when_navigation_is_unsure():
    far = lawnmower(apart=0.9)
    assert pairs(proposed(far, MatchOptions(sequential=1))[1], across=True) == set()
    assert pairs(proposed(far, MatchOptions(sequential=1), sigma_m=0.3)[1], across=True) != set()


def test_without_depth_only_neighbours_are_compared():
    _, found = proposed(lawnmower(), MatchOptions(sequential=1), depth=np.nan)
    assert pairs(found) == {(k, k + 1) for k in range(21)}


def test_a_node_without_image_is_stepped_over():
    usable = np.ones(22, bool)
    usable[5] = False
    keyframes, found = proposed(lawnmower(), MatchOptions(sequential=1), usable=usable)
    assert 5 not in keyframes
    assert (4, 6) in pairs(found)
    assert not any(5 in pair for pair in pairs(found))


def test_a_hovering_vehicle_leaves_few_keyframes():
    hover = np.concatenate([lawnmower()[:5], np.tile(lawnmower()[5], (20, 1)), lawnmower()[6:]])
    keyframes, _ = proposed(hover)
    assert len(keyframes) == 22


def test_images_of_low_saliency_stay_in_the_chain_but_not_across_legs():
    salient = np.ones(22, bool)
    salient[3] = False
    _, found = proposed(lawnmower(), MatchOptions(sequential=1, across=2), salient=salient)
    assert {(2, 3), (3, 4)} <= pairs(found)
    assert not any(3 in pair for pair in pairs(found, across=True))


def test_pairs_come_sorted_and_once():
    _, found = proposed(lawnmower())
    rows = np.column_stack([found.first, found.second])
    np.testing.assert_array_equal(rows, np.unique(rows, axis=0))
    assert (found.first < found.second).all()


@pytest.mark.parametrize("count", [0, 1])
def test_one_image_or_none_makes_no_pairs(count):
    _, found = proposed(np.zeros((count, 2)))
    assert len(found) == 0
