# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rounds of links on two legs with truth: pairs are matched by a matcher that knows the truth and
looks only where the path, within its covariance, has the other image.
"""

from dataclasses import dataclass, field
from io import BytesIO
from types import SimpleNamespace

import numpy as np
import pytest
from navigation.linked_dive import (
    LINK_SIGMA,
    TOP_FROM_BOTTOM,
    TRAY_FROM_TOP,
    TRAY_ORIGIN_M,
    aligned_error_m,
    simulate,
)
from scipy.spatial.transform import Rotation
from vision.scene import camera_rig

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.pose_graph.graph import PoseGraph
from hullrecon.records.trajectory import TrajectoryErrorModel
from hullrecon.vision.link_images import NavigatedDive, link_images
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.pair_match import FeatureSpool, PairMatch, Reason
from hullrecon.vision.stereo.matching import StereoMatches

PER_LEG, DEPTH_M, SEEN = 30, 1.6, 0.25
CAMERA = CameraModel(640, 512, 640.0, 640.0, 319.5, 255.5)  # at 1.6 m: 1.6 m wide, 1.28 m high
# of three numbers: the matcher looks no farther from where the path has the scene
SEARCH_CHI2 = 16.3
NO_ROWS = np.zeros(0, np.int64)


def error_model(dive, drift_sigma):
    """What makes dead reckoning wrong: scale and heading drift of the whole dive, and steps that
    accumulate.
    """
    n, place = len(dive.trajectory.t_ns), dive.trajectory.translation
    by_error = np.zeros((n, 6, 2))
    by_error[:, :3, 0] = place - place[0]
    t = dive.trajectory.t_ns * 1e-9
    middle = 0.5 * (t[1:] + t[:-1])[:, None] * np.diff(place, axis=0)
    moved = np.cross([0, 0, 1.0], np.vstack([np.zeros(3), np.cumsum(middle, axis=0)]))
    turn = t[:, None] * [0, 0, 1.0]
    by_error[:, :3, 1], by_error[:, 3:, 1] = moved + np.cross(place, turn), turn
    walk = np.arange(n)[:, None, None] * np.diag(np.repeat([5e-3, 6e-4], 3) ** 2)
    return TrajectoryErrorModel(
        by_error=by_error,
        error_covariance=np.diag(np.square([0.01, drift_sigma])),
        walk=walk,
        white=np.tile(1e-8 * np.eye(6), (n, 1, 1)),
    )


@dataclass
class KnowingMatcher:
    """Gives the stereo and the pairs of a dive whose truth it knows; `wrong`: pairs that give a
    motion that is none of theirs. turn_sigma: rad, of the links' rotations. calls: what was asked
    for, and of how many.
    """

    dive: object
    wrong: tuple = ()
    turn_sigma: float = LINK_SIGMA[3]
    calls: list = field(default_factory=list)

    def __call__(self, function, items, label):
        self.calls.append(
            (label, sum(len(pairs) for _, pairs in items) if label == "pairs" else len(items))
        )
        if label == "stereo":
            return [(100, stereo_points()) for _ in items]
        return [[self.match(pair) for pair in pairs] for _, pairs in items]

    def match(self, pair):
        camera = self.dive.cameras()
        truth = np.linalg.inv(camera[pair.second]) @ camera[pair.first]
        if (pair.first, pair.second) in self.wrong:
            return self.found(truth @ turned([0.3, -0.2, 0.4], 0.5), pair)
        off = truth[:3, 3] - pair.expected.second_from_first[:3, 3]
        chi2 = off @ np.linalg.solve(pair.expected.covariance[:3, :3], off)
        if overlap(truth) < SEEN or chi2 > SEARCH_CHI2:
            return PairMatch(
                first=NO_ROWS,
                second=NO_ROWS,
                distance=NO_ROWS.astype(np.float32),
                putative=3,
                reason=Reason.FEW_INLIERS,
            )
        noise = self.sigma * np.random.default_rng((pair.first, pair.second)).standard_normal(6)
        noisy = truth @ turned(noise[3:], 1.0)
        noisy[:3, 3] += noise[:3]
        return self.found(noisy, pair)

    @property
    def sigma(self):
        return np.r_[LINK_SIGMA[:3], np.full(3, self.turn_sigma)]

    def found(self, second_from_first, pair):
        rows = np.arange(20) + pair.first % 7
        return PairMatch(
            first=rows,
            second=rows,
            distance=np.full(20, 0.3, np.float32),
            putative=40,
            reason=Reason.MATCHED,
            motion=Motion(second_from_first, np.diag(self.sigma**2)),
            scaled=True,
        )


def turned(axis, angle):
    out = np.eye(4)
    out[:3, :3] = Rotation.from_rotvec(angle * np.asarray(axis)).as_matrix()
    return out


def stereo_points():
    rows = np.arange(10)
    return StereoMatches(top=rows, bottom=rows, point=np.tile([0.0, 0.0, DEPTH_M], (10, 1)))


def overlap(second_from_first):
    """The share of the first image's footprint, a plane at DEPTH_M, that falls into the second."""
    u, v = (
        x.ravel() for x in np.meshgrid(np.linspace(-0.48, 0.48, 12), np.linspace(-0.38, 0.38, 12))
    )
    points = (
        DEPTH_M * np.column_stack([u, v, np.ones(144)]) @ second_from_first[:3, :3].T
        + second_from_first[:3, 3]
    )
    x, y = (points[:, :2] / points[:, 2:]).T
    return float(((np.abs(x) < 0.5) & (np.abs(y) < 0.4) & (points[:, 2] > 0)).mean())


def across_truly(dive, least=0.5):
    """Pairs of the two legs that overlap by so much, the turn left out."""
    camera, found = dive.cameras(), set()
    for a in range(PER_LEG - 4):
        for b in range(PER_LEG + 4, 2 * PER_LEG):
            if overlap(np.linalg.inv(camera[b]) @ camera[a]) >= least:
                found.add((a, b))
    return found


def link(drift, *, max_rounds=12, wrong=(), saliency=1.0, turn_sigma=LINK_SIGMA[3], **options):
    """The dive linked; and its matcher."""
    dive = simulate(11, PER_LEG, drift=drift)
    rig = camera_rig(CAMERA, CAMERA, TOP_FROM_BOTTOM, TRAY_ORIGIN_M, TRAY_FROM_TOP)
    worker = SimpleNamespace(
        rig=rig,
        options=MatchOptions(**{"sequential": 2} | options),
        saliency=lambda node: saliency,
        bottom_leads=lambda nodes: np.zeros(len(nodes), bool),
        match_stereo=None,
        match_pairs=None,
    )
    navigated = NavigatedDive(
        trajectory=dive.trajectory,
        errors=error_model(dive, max(abs(drift), 1e-4)),
        returns=None,
        tray_sigma_rad=1e-3,
    )
    matcher = KnowingMatcher(dive, wrong, turn_sigma)
    graph = PoseGraph(
        trajectory=dive.trajectory, odometry=dive.odometry, attitude=dive.attitude, rig=dive.rig
    )
    spool = FeatureSpool(BytesIO())
    found, _ = link_images(
        worker, navigated, graph.solve, matcher, spool, max_rounds, appearance=False
    )
    return SimpleNamespace(
        dive=dive, found=found, matcher=matcher, error_m=path_error_m(found, dive)
    )


def path_error_m(found, dive):
    return aligned_error_m(
        Poses(found.path.pose[:, 3:].copy(), found.path.pose[:, :3].copy()),
        dive.global_from_vehicle,
    )


def joined_across(found):
    rows = found.pairs.joined & found.pairs.across
    return set(
        zip(found.pairs.first[rows].tolist(), found.pairs.second[rows].tolist(), strict=True)
    )


SMALL, LARGE = 1e-4, 8e-3  # rad/s: half a degree over the dive, and 54 degrees
LOOSE = 0.04  # rad


@pytest.fixture(scope="module")
def small():
    return link(SMALL)


@pytest.fixture(scope="module")
def large():
    """Links whose rotations are worth little: neighbours alone leave the far ends of the legs a
    metre apart.
    """
    return link(LARGE, turn_sigma=LOOSE)


def test_small_drift_ties_legs_in_first_round(small):
    pairs = small.found.pairs
    assert (pairs.joined & (pairs.round == 1)).sum() > 20
    assert small.error_m < 0.02


def test_drift_beyond_first_search_is_closed_in_rounds(large):
    """Dead reckoning has the far ends metres apart, neighbours alone leave them 0.7 m apart: what
    the first round ties straightens the path, on which the next finds the rest.
    """
    truth, reckoned = large.dive.global_from_vehicle[:, :3, 3], large.dive.trajectory.translation
    assert np.linalg.norm((reckoned - truth)[-1]) > 1.5
    alone = link(LARGE, turn_sigma=LOOSE, max_rounds=0)
    assert alone.error_m > 0.1
    assert large.error_m < 0.01
    assert (large.found.pairs.joined & (large.found.pairs.round > 1)).any()
    assert min(a for a, _ in joined_across(large.found)) <= 2


def test_most_nodes_are_tied_to_other_leg(large):
    near = {a for a, _ in across_truly(large.dive)}
    tied = {a for a, _ in joined_across(large.found)}
    assert len(near & tied) >= 0.9 * len(near)


def test_pairs_that_tell_little_more_are_not_compared(small):
    """Each node overlaps three of the other leg. One link each ties the path to the links' own
    sigma, and the others add less than they cost.
    """
    overlapping = across_truly(small.dive, SEEN)
    assert len(joined_across(small.found)) < 0.5 * len(overlapping)
    assert small.found.pairs.across.sum() < 0.5 * len(overlapping)
    assert small.error_m < 0.01


def test_rounds_end_when_nothing_new_is_found(small):
    rounds = small.found.rounds()
    assert len(rounds) < 12
    assert rounds[-1]["joined"] == 0 or len(rounds) == 1 + small.found.pairs.round.max()
    assert (
        sum(r["compared"] for r in rounds)
        == len(small.found.pairs)
        == sum(n for label, n in small.matcher.calls if label == "pairs")
    )


def test_no_pair_is_compared_twice(large):
    rows = np.column_stack([large.found.pairs.first, large.found.pairs.second])
    np.testing.assert_array_equal(rows, np.unique(rows, axis=0))


def test_wrong_pair_is_rejected_and_leaves_path_as_it_is(small):
    victims = tuple(sorted(joined_across(small.found)))[3::9]
    assert len(victims) >= 2
    again = link(SMALL, wrong=victims)
    pairs = again.found.pairs
    rejected = set(
        zip(
            pairs.first[pairs.rejected].tolist(), pairs.second[pairs.rejected].tolist(), strict=True
        )
    )
    assert rejected == set(victims)
    assert not rejected & set(
        zip(again.found.links.first.tolist(), again.found.links.second.tolist(), strict=True)
    )
    assert again.error_m < 0.02


def test_what_is_left_is_of_pairs_joined_in_their_order(small):
    found, rows = small.found, small.found.pairs.joined
    np.testing.assert_array_equal(found.links.first, found.pairs.first[rows])
    np.testing.assert_array_equal(found.links.second, found.pairs.second[rows])
    np.testing.assert_array_equal(np.diff(found.features.start), 20)
    first = [rows["first"][0] for rows in found.features.blocks()]
    np.testing.assert_array_equal(first, found.links.first % 7)
    assert found.stereo.features.tolist() == [100] * 60
    np.testing.assert_array_equal(np.diff(found.stereo.start), 10)
    assert found.keyframes.tolist() == list(range(60))


def test_without_rounds_neighbours_alone_are_compared():
    found = link(SMALL, max_rounds=0).found
    assert not found.pairs.across.any()
    assert len(found.pairs) == 59 + 58


def test_images_of_low_saliency_are_not_compared_across_legs():
    found = link(SMALL, saliency=0.2).found
    assert not found.pairs.across.any()
    assert found.path.part.tolist() == [0] * 60


def test_min_saliency_admits_images_across_legs():
    assert joined_across(link(SMALL, saliency=0.4, min_saliency=0.3).found)
