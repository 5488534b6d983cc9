# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the matches of a dive say of themselves; that they are found, tests/steps/test_matches.py shows."""

import numpy as np
import pytest

from hullrecon.records.tracks import Tracks
from hullrecon.vision.match_images import MatchedImages
from hullrecon.vision.pairs.matching import REASON_TEXTS, PairMatch, Reason
from hullrecon.vision.pairs.selection import Proposal


def pair(reason, count=0):
    rows = np.arange(count)
    return PairMatch(first=rows, second=rows, distance=np.zeros(count, np.float32), putative=20, reason=reason)


def matched(nodes, reasons, across=None):
    """Matched images of pairs `nodes` [(first, second)] with those reasons; two landmarks in three observations."""
    first, second = (np.array(side, np.int64) for side in (zip(*nodes, strict=True) if nodes else ((), ())))
    nan = np.full(2, np.nan)
    return MatchedImages(
        tracks=Tracks(
            landmark=np.array([0, 0, 1]),
            node=np.array([0, 1, 1]),
            top=np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]),
            bottom=np.stack([nan, nan, np.array([7.0, 8.0])]),
            color=np.zeros((2, 3), np.uint8),
        ),
        proposal=Proposal(
            first=first,
            second=second,
            across=np.zeros(len(first), bool) if across is None else np.array(across),
            overlap=np.ones(len(first)),
        ),
        pairs=[pair(reason, 15 if reason is Reason.MATCHED else 0) for reason in reasons],
        keyframes=4,
        nodes=6,
    )


def test_counts_are_of_pairs_landmarks_and_observations():
    found = matched([(0, 1), (1, 2), (0, 2)], [Reason.MATCHED, Reason.FEW_INLIERS, Reason.MATCHED], [False, False, True])
    assert found.counts() == {
        "keyframes": 4,
        "nodes": 6,
        "pairs": 3,
        "matched": 2,
        "matched_across_legs": 1,
        "landmarks": 2,
        "observations": 3,
        "stereo_observations": 1,
        "landmarks_of_several_nodes": 1,
    }
    assert found.inliers.tolist() == [15, 0, 15]


def test_failures_are_counted_by_their_reason():
    found = matched([(0, 1), (1, 2), (2, 3)], [Reason.FEW_INLIERS, Reason.MATCHED, Reason.FEW_INLIERS])
    assert found.failures() == {REASON_TEXTS[Reason.FEW_INLIERS]: 2}


@pytest.mark.parametrize(
    ("reasons", "sizes"),
    [((0, 0, 0), [4]), ((0, 3, 0), [2, 2]), ((3, 0, 0), [3, 1]), ((3, 3, 3), [1, 1, 1, 1])],
)
def test_a_pair_that_failed_parts_two_chains(reasons, sizes):
    assert matched([(0, 1), (1, 2), (2, 3)], [Reason(code) for code in reasons]).chains() == sizes


def test_without_pairs_there_is_no_chain():
    assert matched([], []).chains() == []
