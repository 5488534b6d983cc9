# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two legs with an outage of metres between them, and a hull whose paint is known cell by cell: it
may come again.
"""

from dataclasses import dataclass, replace
from io import BytesIO
from types import SimpleNamespace

import numpy as np
import pytest
from navigation.linked_dive import (
    NAVIGATION_SIGMA,
    STEP_S,
    STEP_SIGMA,
    TOP_FROM_BOTTOM,
    TRAY_FROM_TOP,
    TRAY_ORIGIN_M,
    simulate,
)
from vision.scene import camera_rig
from vision.test_link_images import CAMERA, SEEN, KnowingMatcher, error_model, overlap, path_error_m

from hullrecon.navigation.pose_graph.graph import PoseGraph
from hullrecon.studies.scenes.ellipsoid_dive import measured_steps, reckoned
from hullrecon.vision.appearance.recognition import Recognition, is_confirmed
from hullrecon.vision.compared_pairs import ComparedPairs
from hullrecon.vision.features.extraction import Features, root_sift
from hullrecon.vision.link_images import NavigatedDive, link_images
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.pair_match import FeatureSpool, PairMatch, Reason, failed_match
from hullrecon.vision.pairs.selection import Proposal

CELL_M, OUTAGE_SIGMA_M, OFF_M = 0.2, 3.0, np.array([0.3, 5.0, 0.2])
# of 60 nodes: the second leg begins 3 m beyond where the first ended, and goes back over it
BLANK = range(14, 40)
ATTITUDE_FIELDS = ("depth", "roll", "pitch", "sigma", "tray_direction", "tray_sigma")
NONE = Reason.FEW_INLIERS


def dive_with_outage(off_m=OFF_M, blank=BLANK):
    """The simulated legs without the nodes of the blank; the step across it is wrong by off_m and
    says so.
    """
    rng = np.random.default_rng(3)
    whole = simulate(11, 30, drift=1e-4)
    keep = np.setdiff1d(np.arange(60), blank)
    truth, gap = whole.global_from_vehicle[keep], blank.start - 1
    steps = measured_steps(rng, truth, 0.1 * NAVIGATION_SIGMA, np.zeros(3), STEP_S, STEP_SIGMA)
    translation, covariance = steps.translation.copy(), steps.covariance.copy()
    translation[gap] += off_m
    covariance[gap, :3, :3] += OUTAGE_SIGMA_M**2 * np.eye(3) * (np.linalg.norm(off_m) > 0)
    steps = replace(steps, translation=translation, covariance=covariance)
    attitude = {name: getattr(whole.attitude, name)[keep] for name in ATTITUDE_FIELDS}
    return replace(
        whole,
        global_from_vehicle=truth,
        odometry=steps,
        trajectory=replace(reckoned(truth[0], steps, STEP_S), t_ns=whole.trajectory.t_ns[keep]),
        attitude=replace(whole.attitude, node=np.arange(len(keep)), **attitude),
    )


def paint(dive, repeats_m):
    """By node: features of the cells of hull before the camera, alike after each repetition along
    the hull.
    """
    rng = np.random.default_rng(8)
    cells = root_sift(rng.gamma(0.3, 1.0, (4000, 128)).astype(np.float32))
    across, down = (x.ravel() for x in np.meshgrid(np.arange(-3, 4), np.arange(-2, 3)))
    out = []
    for camera in dive.cameras():
        along, depth = camera[1, 3] + CELL_M * across, camera[2, 3] + CELL_M * down
        along = along if repeats_m is None else np.mod(along, repeats_m)
        number = (
            np.floor(along / CELL_M).astype(int) * 61 + np.floor(depth / CELL_M).astype(int)
        ) % len(cells)
        table = np.ones((len(number), 4), np.float32)
        out.append(Features(table, cells[number], np.zeros((len(number), 3), np.uint8)))
    return out


@dataclass
class LookingMatcher(KnowingMatcher):
    """Matches anywhere what overlaps truly, or after a whole number of repetitions of the paint."""

    repeats_m: float | None = None

    def match(self, pair):
        if pair.expected is not None:
            return super().match(pair)
        camera = self.dive.cameras()
        for step in (0, -1, 1, -2, 2) if self.repeats_m else (0,):
            moved = camera[pair.second].copy()
            moved[1, 3] += step * (self.repeats_m or 0.0)
            motion = np.linalg.inv(moved) @ camera[pair.first]
            if overlap(motion) >= SEEN:
                return self.found(motion, pair)
        return failed_match(3, NONE)


class TrustingMatcher(LookingMatcher):
    """Matches neighbours, too, wherever they may lie."""

    def match(self, pair):
        return super().match(replace(pair, expected=None) if pair.full_search else pair)


class ShiftedMatcher(LookingMatcher):
    """Links far images alike anywhere, all as if the second leg lay 2 m along, and nothing where
    these links have it.
    """

    def match(self, pair):
        if pair.second - pair.first <= 4:
            return super().match(pair)
        if pair.expected is not None:
            return failed_match(3, NONE)
        camera = self.dive.cameras()
        moved = camera[pair.second].copy()
        moved[1, 3] += 2.0
        return self.found(np.linalg.inv(moved) @ camera[pair.first], pair)


def link(dive, *, repeats_m=None, appearance=True, rig_of=2, looking=LookingMatcher):
    rig = camera_rig(
        CAMERA,
        *((CAMERA, TOP_FROM_BOTTOM) if rig_of == 2 else (None, None)),
        TRAY_ORIGIN_M,
        TRAY_FROM_TOP,
    )
    features, asked = paint(dive, repeats_m), []

    def read(node):
        asked.append(node.image)
        return SimpleNamespace(leading=features[node.image[0]])

    worker = SimpleNamespace(
        rig=rig,
        options=MatchOptions(sequential=2),
        saliency=lambda node: 1.0,
        read=read,
        bottom_leads=lambda nodes: np.zeros(len(nodes), bool),
        match_stereo=None,
        match_pairs=None,
    )
    errors = error_model(dive, 1e-4)
    walk = errors.walk.copy()
    walk[BLANK.start :, :3, :3] += OUTAGE_SIGMA_M**2 * np.eye(3)
    navigated = NavigatedDive(
        trajectory=dive.trajectory,
        errors=replace(errors, walk=walk),
        returns=None,
        tray_sigma_rad=1e-3,
    )
    graph = PoseGraph(
        trajectory=dive.trajectory, odometry=dive.odometry, attitude=dive.attitude, rig=dive.rig
    )
    matcher = looking(dive, repeats_m=repeats_m)
    spool = FeatureSpool(BytesIO())
    found, _ = link_images(worker, navigated, graph.solve, matcher, spool, 12, appearance)
    return SimpleNamespace(found=found, error_m=path_error_m(found, dive), asked=asked)


@pytest.fixture(scope="module")
def dive():
    return dive_with_outage()


@pytest.fixture(scope="module")
def closed(dive):
    return link(dive)


def test_legs_that_rounds_cannot_tie_are_tied_by_how_they_look(dive, closed):
    before = link(dive, appearance=False)
    assert before.error_m > 1.0
    assert not (before.found.pairs.joined & before.found.pairs.across).any()
    assert closed.error_m < 0.02
    (asked,) = closed.found.appearance
    assert asked.refusal is None
    assert asked.accepted.sum() >= 10
    assert closed.found.path.part.max() == 0


def test_rounds_go_on_from_straightened_path(closed):
    pairs, asked = closed.found.pairs, closed.found.appearance[0]
    number = int(
        pairs.round[
            np.isin(
                pairs.first * 99 + pairs.second, asked.proposal.first * 99 + asked.proposal.second
            )
        ][0]
    )
    assert (pairs.joined & (pairs.round > number)).any()
    rows = np.column_stack([pairs.first, pairs.second])
    np.testing.assert_array_equal(rows, np.unique(rows, axis=0))


def test_what_was_asked_is_counted(closed):
    facts = closed.found.appearance[0].facts()
    assert facts["offered"] >= facts["matched"] >= facts["within_gate"] >= facts["accepted"] > 0
    assert facts["control_matched"] == 0


def test_drift_within_reach_of_rounds_needs_no_recognition():
    short = dive_with_outage(np.zeros(3))
    with_it, without = (link(short, appearance=appearance) for appearance in (True, False))
    np.testing.assert_array_equal(with_it.found.pairs.first, without.found.pairs.first)
    np.testing.assert_array_equal(with_it.found.path.pose, without.found.path.pose)
    assert (with_it.found.pairs.joined & with_it.found.pairs.across).any()
    assert with_it.found.appearance == ()
    assert with_it.asked == []


def test_on_paint_that_comes_again_nothing_is_taken(dive):
    found = link(dive, repeats_m=3.0)
    (asked,) = found.found.appearance
    assert asked.counts["matched"] > 10
    assert asked.counts["control_matched"] > 2
    assert asked.refusal == "places that the path knows to be two look alike"
    assert not (found.found.pairs.joined & found.found.pairs.across).any()


def test_links_confirming_two_paths_are_refused_as_ambiguous(dive, monkeypatch):
    monkeypatch.setattr("hullrecon.vision.appearance.hypotheses.CONTROLS", 0)
    (asked,) = link(dive, repeats_m=3.0).found.appearance
    assert asked.refusal == "images that look alike confirm more than one path"
    assert not asked.accepted.any()


def test_link_that_nothing_confirms_is_not_taken(dive, monkeypatch):
    monkeypatch.setattr("hullrecon.vision.appearance.hypotheses.MOST_PAIRS", 2)
    found = link(dive).found
    (asked,) = found.appearance
    assert asked.counts["matched"] > 0
    assert asked.refusal == "too few images that look alike confirm each other"
    assert not (found.pairs.joined & found.pairs.across).any()


def test_parts_too_short_for_a_control_are_not_joined(dive, monkeypatch):
    monkeypatch.setattr("hullrecon.vision.appearance.recognition.LEAST_REACH", 10.0)
    (asked,) = link(dive).found.appearance
    assert asked.counts["within_gate"] >= 3
    assert "long enough" in asked.refusal
    assert not asked.accepted.any()


def test_one_thing_that_looks_like_another_is_not_enough(dive, monkeypatch):
    monkeypatch.setattr("hullrecon.vision.appearance.recognition.LEAST_EXTENT", 20.0)
    (asked,) = link(dive).found.appearance
    assert asked.refusal == "too few images that look alike confirm each other"


def test_links_are_undone_where_images_put_together_do_not_match(dive, monkeypatch):
    """One thing seen from several sides that looks like another: all links agree, and what lies
    around it does not match.
    """
    monkeypatch.setattr("hullrecon.vision.appearance.hypotheses.CONTROLS", 0)
    found = link(dive, looking=ShiftedMatcher)
    before = link(dive, looking=ShiftedMatcher, appearance=False)
    (asked,) = found.found.appearance
    assert asked.counts["within_gate"] > 10
    assert asked.refusal == "the images that it puts beside each other do not match"
    assert not found.found.links.second[
        found.found.links.second - found.found.links.first > 4
    ].any()
    np.testing.assert_array_equal(found.found.path.pose, before.found.path.pose)


def test_place_beyond_sigma_of_path_is_no_hypothesis(dive):
    """The path says that the legs lie 40 m apart, to 3 m."""
    far = dive_with_outage(np.array([0.0, 40.0, 0.0]))
    assert link(far).found.appearance == ()


def across_outage(found):
    pairs = found.pairs
    return (pairs.first < BLANK.start) & (pairs.second >= BLANK.start)


@pytest.mark.parametrize("rig_of", [1, 2])
def test_matches_across_outage_rejected_where_paint_repeats(dive, rig_of):
    """The second leg begins one repetition beyond where the first ended: neighbours match and are 3
    m apart.
    """
    tied = link(dive, repeats_m=3.0, looking=TrustingMatcher, appearance=False, rig_of=rig_of)
    assert tied.found.path.part.max() == 0
    assert tied.error_m > 1.0
    found = link(dive, repeats_m=3.0, looking=TrustingMatcher, rig_of=rig_of).found
    matched = across_outage(found) & (found.pairs.reason == Reason.MATCHED)
    assert matched.any()
    assert found.pairs.rejected[matched].all()
    assert found.look_alikes == (matched & (found.pairs.round == 0)).sum() > 0
    assert found.path.part.max() == 1


@pytest.mark.parametrize("rig_of", [1, 2])
def test_matches_across_outage_tie_path_where_no_paint_repeats(rig_of):
    """The vehicle is where it was when the images end."""
    again = dive_with_outage(blank=range(BLANK.start, 46))
    found = link(again, looking=TrustingMatcher, rig_of=rig_of)
    assert found.found.pairs.joined[across_outage(found.found)].any()
    assert found.found.path.part.max() == 0
    assert found.error_m < 0.03
    assert found.found.appearance == ()


def test_one_look_alike_rejects_matches_without_a_long_part(dive, monkeypatch):
    monkeypatch.setattr("hullrecon.vision.appearance.recognition.MAX_ALIKE", 1000)
    assert link(dive, repeats_m=3.0, looking=TrustingMatcher).found.path.part.max() == 0
    monkeypatch.setattr("hullrecon.vision.appearance.recognition.LEAST_REACH", 10.0)
    assert link(dive, repeats_m=3.0, looking=TrustingMatcher).found.path.part.max() == 1


def test_one_camera_is_not_asked(dive):
    assert link(dive, rig_of=1).found.appearance == ()


def motion():
    return Motion(np.eye(4), np.eye(6))


def compared_pairs(matched, rounds):
    rows = np.arange(3)
    found = tuple(
        PairMatch(
            first=rows,
            second=rows,
            distance=np.zeros(3, np.float32),
            putative=9,
            reason=Reason.MATCHED,
            motion=motion(),
        )
        if good
        else failed_match(3, NONE)
        for good in matched
    )
    count = len(found)
    proposal = Proposal(
        first=np.arange(count),
        second=np.arange(count) + 20,
        across=np.ones(count, bool),
        overlap=np.full(count, 0.5),
    )
    return ComparedPairs(
        proposal=proposal, found=found, round=np.array(rounds), rejected=np.zeros(count, bool)
    )


def test_of_last_pairs_those_that_are_not_accepted_are_rejected():
    pairs = compared_pairs([True, False, True, True, False, True], [0, 0, 0, 1, 1, 1])
    left = pairs.keeping_recognised(np.array([True, False, False]))
    assert left.rejected.tolist() == [False, False, False, False, False, True]
    assert not pairs.keeping_recognised(np.zeros(0, bool)).rejected.any()


@pytest.mark.parametrize(
    ("taken", "after", "right"),
    [
        (3, [True] * 5, True),
        (2, [True] * 5, False),
        (3, [False] * 5, False),
        (3, [False] * 4, True),
        (3, [], True),
    ],
)
def test_links_are_borne_out_by_what_they_put_beside_each_other(taken, after, right):
    pairs = compared_pairs([True] * taken + after, [4] * taken + [5] * len(after))
    assert is_confirmed(pairs, 4) is right


def test_refusal_keeps_first_reason():
    nothing = Proposal(
        first=np.zeros(1, int), second=np.ones(1, int), across=np.ones(1, bool), overlap=np.ones(1)
    )
    found = Recognition(
        proposal=nothing,
        found=(failed_match(0, NONE),),
        accepted=np.ones(1, bool),
        counts={},
        refusal=None,
    )
    refused = found.refused("one").refused("two")
    assert refused.facts() == {"accepted": 0, "refusal": "one"}
