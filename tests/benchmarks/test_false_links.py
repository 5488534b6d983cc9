# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from benchmarks.false_links import (
    APART_M,
    SIGMA,
    Offer,
    apart,
    chosen,
    look_alikes,
    motions,
    row_of,
)
from benchmarks.links_in_graph import joined, links_of, select
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses, from_rpy
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.pair_match import PairMatch, Reason, failed_match

CAMERA = CameraModel(640, 512, 620.0, 620.0, 320.0, 256.0)
EVERY_M = 4.5


def cameras(along_m: np.ndarray) -> Poses:
    """Cameras at y = 0 that look along y at a wall a metre off, upright."""
    turn = from_rpy(np.zeros(3), [-np.pi / 2, 0.0, 0.0]).quaternion
    return Poses(
        np.tile(turn, (len(along_m), 1)), np.column_stack([along_m, np.zeros((len(along_m), 2))])
    )


def matched(motion: Motion | None) -> PairMatch:
    none = np.zeros(0, np.int64)
    return PairMatch(
        first=none,
        second=none,
        distance=np.zeros(0, np.float32),
        putative=20,
        reason=Reason.MATCHED,
        motion=motion,
    )


def test_pairs_without_overlap_are_ordered_and_listed_once() -> None:
    centres = np.column_stack([np.linspace(0, 20, 60), np.zeros((60, 2))])
    first, second = apart(centres, 200, np.random.default_rng(1))
    assert len(first) == 200
    assert len(np.unique(np.column_stack([first, second]), axis=0)) == 200
    assert (first < second).all()
    assert (np.linalg.norm(centres[first] - centres[second], axis=1) > APART_M).all()
    assert (np.diff(first) >= 0).all()


def test_no_more_pairs_are_chosen_than_there_are() -> None:
    first, second = chosen(np.array([[3, 1], [1, 3], [2, 5]]), 10, np.random.default_rng(0))
    assert list(zip(first.tolist(), second.tolist(), strict=True)) == [(1, 3), (2, 5)]


def test_pairs_look_alike_where_a_repetition_lies_between_them() -> None:
    at = cameras(np.array([0.0, 0.1, 2.0, EVERY_M, EVERY_M + 0.2, 2 * EVERY_M, 2 * EVERY_M + 2.0]))
    first, second, shift = look_alikes(at, np.ones(len(at)), CAMERA, EVERY_M)
    found = {
        (a, b): s
        for a, b, s in zip(first.tolist(), second.tolist(), shift[:, 0].tolist(), strict=True)
    }
    assert {(0, 3), (1, 4), (0, 5), (3, 5), (2, 6)} <= set(found)
    assert not {(0, 1), (0, 2), (2, 3), (5, 6), (2, 5)} & set(found)
    assert found[0, 3] == -EVERY_M
    assert found[0, 5] == -2 * EVERY_M


def test_alike_pair_is_placed_where_it_seems_to_lie() -> None:
    at = cameras(np.array([0.0, EVERY_M + 0.2]))
    (motion,) = motions(at, np.array([0]), np.array([1]), np.array([[-EVERY_M, 0.0, 0.0]]))
    np.testing.assert_allclose(motion.second_from_first[:3, 3], [-0.2, 0, 0], atol=1e-12)
    np.testing.assert_array_equal(motion.covariance, SIGMA)


def test_the_row_counts_what_was_linked_and_why_the_rest_was_not() -> None:
    row = row_of(
        [matched(None), failed_match(3, Reason.FEW_PUTATIVE), failed_match(3, Reason.FEW_PUTATIVE)]
    )
    assert (row["offered"], row["linked"]) == (3, 1)
    assert row["reasons"] == {
        name: {"MATCHED": 1, "FEW_PUTATIVE": 2}.get(name, 0) for name in Reason.__members__
    }


def test_only_matched_pairs_become_links() -> None:
    at = cameras(np.arange(4.0))
    offer = Offer(first=np.array([0, 1, 2]), second=np.array([1, 2, 3]), expected=())
    found = motions(at, offer.first, offer.second, np.zeros(3))
    links = links_of(
        offer.first,
        offer.second,
        [matched(found[0]), failed_match(0, Reason.NO_FEATURES), matched(found[2])],
    )
    assert links.first.tolist() == [0, 2]
    np.testing.assert_allclose(links.translation, [[-1, 0, 0], [-1, 0, 0]], atol=1e-12)
    both = joined(select(links, np.array([False, True])), links)
    assert both.second.tolist() == [3, 1, 3]
    assert both.covariance.shape == (3, 6, 6)
