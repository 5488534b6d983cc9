# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses, exp
from hullrecon.records.trajectory import TrajectoryErrorModel
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs import selection
from hullrecon.vision.pairs.camera_track import CameraTrack, NavigationErrors
from hullrecon.vision.pairs.expected_overlap import expect_overlap
from hullrecon.vision.pairs.footprints import footprint_overlap
from hullrecon.vision.pairs.selection import (
    choose_informative,
    propose_neighbours,
    propose_revisits,
    select_keyframes,
)

CAMERA = CameraModel(640, 512, 640.0, 640.0, 319.5, 255.5)  # at 1 m: 1 m wide, 0.8 m high
DEPTH = 1.0


def random_walk(covariance):
    """An error model of twists that accumulate, covariance (n, 6, 6)."""
    n = len(covariance)
    return TrajectoryErrorModel(
        by_error=np.zeros((n, 6, 0)),
        error_covariance=np.zeros((0, 0)),
        walk=covariance,
        white=np.zeros((n, 6, 6)),
    )


def track(places, sigma_m=0.0):
    """Cameras that all look along z, at x, y."""
    n = len(places)
    covariance = np.zeros((n, 6, 6))
    covariance[:, [0, 1, 2], [0, 1, 2]] = (sigma_m**2 * np.arange(n) / max(n - 1, 1))[:, None]
    poses = Poses(np.tile([0, 0, 0, 1.0], (n, 1)), np.column_stack([places, np.zeros(n)]))
    errors = NavigationErrors(global_from_camera=poses, model=random_walk(covariance))
    return CameraTrack(global_from_camera=poses, errors=errors)


def lawnmower(step=0.2, leg=11, apart=0.5):
    """Two legs of 2 m, there and back."""
    x = step * np.arange(leg)
    return np.concatenate([np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + apart])])


def keyframes_of(places, depth=DEPTH, usable=None):
    n = len(places)
    usable = np.ones(n, bool) if usable is None else usable
    return select_keyframes(track(places), usable, np.full(n, depth), CAMERA)


def neighbours(places, options=None, depth=DEPTH, usable=None):
    keyframes = keyframes_of(places, depth, usable)
    return propose_neighbours(
        track(places), keyframes, np.full(len(places), depth), CAMERA, options or MatchOptions()
    )


def revisits(
    places, options=None, depth=DEPTH, sigma_m=0.0, keyframes=None, min_probability=0.2, compared=()
):
    keyframes = keyframes_of(places, depth) if keyframes is None else keyframes
    depths, compared = np.full(len(places), depth), np.array(compared, np.int64)
    return propose_revisits(
        track(places, sigma_m),
        keyframes,
        depths,
        CAMERA,
        options or MatchOptions(),
        min_probability,
        compared,
    ).proposal


def pairs(proposal):
    return set(zip(proposal.first.tolist(), proposal.second.tolist(), strict=True))


def test_overlap_is_share_of_image_that_is_seen_again():
    places = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.8], [0.25, 0.4]])
    found = footprint_overlap(track(places), np.zeros(4, int), np.arange(4), np.ones(4), CAMERA)
    np.testing.assert_allclose(found, [1.0, 0.5, 0.0, 0.375], atol=0.01)


def test_without_depth_no_overlap_is_claimed():
    places = np.array([[0.0, 0.0], [0.5, 0.0]])
    assert np.isnan(
        footprint_overlap(
            track(places), np.array([0]), np.array([1]), np.array([np.nan, 1.0]), CAMERA
        )
    ).all()


def test_neighbours_along_dive_are_always_compared():
    found = neighbours(lawnmower(), MatchOptions(sequential=2))
    assert pairs(found) == {(k, k + s) for s in (1, 2) for k in range(22 - s)}
    assert not found.across.any()


def test_nodes_of_two_legs_that_saw_same_place_are_compared():
    found = revisits(lawnmower(), MatchOptions(sequential=1))
    # opposite each other; at the turn the footprint is never left
    assert {(k, 21 - k) for k in range(7)} <= pairs(found)
    # the first node sees the end of the other leg
    assert {b for a, b in pairs(found) if a == 0} == {19, 20, 21}
    assert found.across.all()


def test_neighbour_never_lost_from_sight_is_not_across():
    slow = np.column_stack([0.05 * np.arange(30), np.zeros(30)])
    assert pairs(revisits(slow, MatchOptions(sequential=1))) == set()


def test_nodes_without_depth_do_not_make_neighbours_across():
    slow = lawnmower(step=0.05, leg=41)
    # a DVL that is slower than the camera
    depths = np.where(np.arange(len(slow)) % 5 < 3, np.nan, DEPTH)
    options = MatchOptions(sequential=1)
    found = propose_revisits(
        track(slow), np.arange(len(slow)), depths, CAMERA, options, 0.2, np.zeros(0, np.int64)
    ).proposal
    assert len(found) > 0
    assert all(a < 41 <= b for a, b in pairs(found))


def test_distant_legs_are_compared_only_where_path_is_unsure():
    far = lawnmower(apart=0.9)
    assert pairs(revisits(far, MatchOptions(sequential=1), min_probability=0.05)) == set()
    assert (
        pairs(revisits(far, MatchOptions(sequential=1), min_probability=0.05, sigma_m=0.3)) != set()
    )


def test_less_probable_overlap_may_be_more_is_compared():
    far, options = lawnmower(apart=0.9), MatchOptions(sequential=1)
    found = [
        pairs(revisits(far, options, sigma_m=0.6, min_probability=p)) for p in (0.5, 0.2, 0.05)
    ]
    assert found[0] < found[1] < found[2]


def test_compared_pair_is_not_proposed_again():
    first = revisits(lawnmower())
    half = revisits(lawnmower(), compared=(first.first * 22 + first.second)[::2])
    assert len(first) > 0
    assert pairs(half) == {pair for k, pair in enumerate(sorted(pairs(first))) if k % 2}


def test_pairs_of_most_worth_are_chosen():
    first, second = np.array([0, 1, 2, 3]), np.array([9, 8, 7, 6])
    probability, gain = np.array([0.1, 1.0, 0.5, 1.0]), np.array([5.0, 4.0, 3.0, 0.9])
    assert choose_informative(first, second, probability, gain, 1.0).tolist() == [1, 2]


def test_a_node_is_chosen_again_as_long_as_that_tells_enough():
    """Of a motion as good as unknown, the second measurement of six numbers tells 3 ln 2 = 2.1
    nats, the third 1.2, the fourth 0.9.
    """
    first, second = np.zeros(5, int), np.arange(5, 10)
    chosen = choose_informative(first, second, np.ones(5), np.arange(40.0, 35, -1), 1.0)
    assert chosen.tolist() == [0, 1, 2]
    # twice as good as known: 2.1 nats, and a second one 1.2
    assert len(choose_informative(first, second, np.ones(5), np.full(5, 2.08), 1.0)) == 2


def test_without_depth_only_neighbours_are_compared():
    assert pairs(neighbours(lawnmower(), MatchOptions(sequential=1), depth=np.nan)) == {
        (k, k + 1) for k in range(21)
    }
    assert len(revisits(lawnmower(), MatchOptions(sequential=1), depth=np.nan)) == 0


def test_node_without_image_is_stepped_over():
    usable = np.ones(22, bool)
    usable[5] = False
    found = neighbours(lawnmower(), MatchOptions(sequential=1), usable=usable)
    assert 5 not in keyframes_of(lawnmower(), usable=usable)
    assert (4, 6) in pairs(found)
    assert not any(5 in pair for pair in pairs(found))


def test_hovering_vehicle_leaves_few_keyframes():
    hover = np.concatenate([lawnmower()[:5], np.tile(lawnmower()[5], (20, 1)), lawnmower()[6:]])
    assert len(keyframes_of(hover)) == 22


def test_only_keyframes_given_are_compared_across_legs():
    salient = np.setdiff1d(np.arange(22), [3])
    found = revisits(lawnmower(), MatchOptions(sequential=1), keyframes=salient)
    assert len(found) > 0
    assert not any(3 in pair for pair in pairs(found))


@pytest.mark.parametrize("propose", [neighbours, revisits])
def test_pairs_come_sorted_and_once(propose):
    found = propose(lawnmower())
    rows = np.column_stack([found.first, found.second])
    np.testing.assert_array_equal(rows, np.unique(rows, axis=0))
    assert (found.first < found.second).all()


@pytest.mark.parametrize("propose", [neighbours, revisits])
@pytest.mark.parametrize("count", [0, 1])
def test_one_image_or_none_makes_no_pairs(propose, count):
    assert len(propose(np.zeros((count, 2)))) == 0


# how probably two nodes show the same


class KnownErrors:
    """The same covariance (6, 6) for every pair."""

    def __init__(self, covariance):
        self.covariance = covariance

    def relative_covariance(self, first, second):
        return np.tile(self.covariance, (len(first), 1, 1))


def drawn_probability(poses, covariance, min_overlap, draws=4000):
    """Shares of the first image that drawn relative poses leave in the second, and how many reach
    min_overlap.
    """
    rng = np.random.default_rng(5)
    step = rng.multivariate_normal(np.zeros(6), covariance, draws)
    relative = poses[[1]].inverse() @ poses[[0]]
    turn = relative.rotation * exp(np.hstack([np.zeros((draws, 3)), step[:, 3:]])).rotation
    moved = Poses(turn.as_quat(), relative.translation + step[:, :3])
    u, v = np.meshgrid(
        (np.arange(8) + 0.5) / 8 * CAMERA.width - 0.5,
        (np.arange(8) + 0.5) / 8 * CAMERA.height - 0.5,
    )
    rays = np.column_stack(
        [(u.ravel() - CAMERA.cx) / CAMERA.fx, (v.ravel() - CAMERA.cy) / CAMERA.fy, np.ones(64)]
    )
    points = moved.rotation.as_matrix() @ (DEPTH * rays.T) + moved.translation[:, :, None]
    x = CAMERA.fx * points[:, 0] / points[:, 2] + CAMERA.cx
    y = CAMERA.fy * points[:, 1] / points[:, 2] + CAMERA.cy
    inside = (
        (points[:, 2] > 0)
        & (x > -0.5)
        & (x < CAMERA.width - 0.5)
        & (y > -0.5)
        & (y < CAMERA.height - 0.5)
    )
    return float((inside.mean(axis=1) >= min_overlap).mean())


@pytest.mark.parametrize("apart", [(0.2, 0.0), (0.8, 0.1), (0.9, 0.6), (1.6, 0.3)])
@pytest.mark.parametrize("sigmas", [(0.05, 0.01), (0.3, 0.02), (0.8, 0.05)])
def test_probability_of_overlap_is_that_of_drawn_poses(apart, sigmas):
    """36 points stand for the shift of the scene's middle, none of them beyond 1.4 sigma; its turn
    is left out.
    """
    poses = Poses(np.tile([0, 0, 0, 1.0], (2, 1)), np.array([[0.0, 0, 0], [*apart, 0]]))
    covariance = np.diag(np.repeat(np.square(sigmas), 3))
    known = CameraTrack(global_from_camera=poses, errors=KnownErrors(covariance))
    (found,), _ = expect_overlap(
        known, np.array([0]), np.array([1]), np.full(2, DEPTH), CAMERA, 0.15
    )
    assert found == pytest.approx(drawn_probability(poses, covariance, 0.15), abs=0.13)


def test_pose_without_error_overlaps_or_does_not():
    places = np.array([[0.0, 0.0], [0.5, 0.0], [0.95, 0.0], [0.0, 0.5]])
    found, share = expect_overlap(
        track(places), np.zeros(4, int), np.arange(4), np.full(4, DEPTH), CAMERA, 0.3
    )
    np.testing.assert_array_equal(found, [1, 1, 0, 1])
    np.testing.assert_array_equal(share, [1, 0.5, 0, 0.375])


def test_where_no_depth_is_known_nothing_overlaps_probably():
    places = np.zeros((2, 2))
    found, _ = expect_overlap(
        track(places), np.array([0]), np.array([1]), np.array([np.nan, 1.0]), CAMERA, 0.1
    )
    assert found[0] == 0.0


def test_pairs_known_well_need_no_covariance_of_their_own():
    """Every node is asked for once, relative to one of them: 50 sigmas, not 2500."""
    asked = []

    class Errors(KnownErrors):
        def relative_covariance(self, first, second):
            asked.append(len(first))
            return super().relative_covariance(first, second)

    places = np.random.default_rng(0).uniform(0, 1, (50, 2))
    first, second = (x.ravel() for x in np.meshgrid(np.arange(50), np.arange(50)))
    errors = Errors(np.diag(np.repeat(np.square([0.003, 0.001]), 3)))
    at = CameraTrack(global_from_camera=track(places).global_from_camera, errors=errors)
    expect_overlap(at, first, second, np.ones(50), CAMERA, 0.15)
    assert sum(asked) == 50


def test_many_pairs_give_what_each_gives_alone():
    places = np.random.default_rng(0).uniform(0, 2, (50, 2))
    first, second = (x.ravel() for x in np.meshgrid(np.arange(50), np.arange(50)))
    at = track(places, sigma_m=0.4)
    together, _ = expect_overlap(at, first, second, np.ones(50), CAMERA, 0.15)
    for k in (0, 1000, 1001, 2499):
        rows = slice(k, k + 1)
        assert (
            together[k]
            == expect_overlap(at, first[rows], second[rows], np.ones(50), CAMERA, 0.15)[0][0]
        )


@pytest.mark.parametrize("seed", range(3))
def test_pairs_within_reach_are_those_of_all_pairs(seed):
    """One node that is known badly widens the search for its own pairs, not for all."""
    rng = np.random.default_rng(seed)
    middle, more = (
        rng.uniform(0, 8, (2300, 3)) * [1, 1, 0.1],
        np.where(rng.uniform(size=2300) < 0.01, 0.9, 0.02),
    )
    first, second = selection._within_reach(middle, 0.4, more, 1.2)
    apart = np.linalg.norm(middle[:, None] - middle, axis=2)
    wanted = np.argwhere(np.triu(apart <= 0.4 + np.minimum(more[:, None] + more, 1.2), 1))
    np.testing.assert_array_equal(np.column_stack([first, second]), wanted)
