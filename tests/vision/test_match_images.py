# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the matches of a dive say of themselves; that they are found, tests/steps/test_matches.py
shows.
"""

import numpy as np
import pytest

from hullrecon.errors import StageError
from hullrecon.findings.package import DVL_ALONE
from hullrecon.records.links import NodePairs
from hullrecon.records.tracks import Tracks
from hullrecon.vision.match_images import MatchedImages, join_images
from hullrecon.vision.pairs.pair_match import REASON_TEXTS, Reason


def matched(nodes, reasons, across=None, rejected=None):
    """Matched images of pairs `nodes` [(first, second)] with those reasons, 15 features each; two
    landmarks in three observations.
    """
    first, second = (
        np.array(side, np.int64) for side in (zip(*nodes, strict=True) if nodes else ((), ()))
    )
    nan = np.full(2, np.nan)
    none = np.zeros(len(first), bool)
    pairs = NodePairs(
        first=first,
        second=second,
        across=none if across is None else np.array(across),
        overlap=np.ones(len(first)),
        round=np.zeros(len(first), np.int64),
        putative=np.full(len(first), 20),
        reason=np.array(reasons, np.int64),
        rejected=none if rejected is None else np.array(rejected),
    )
    return MatchedImages(
        tracks=Tracks(
            landmark=np.array([0, 0, 1]),
            node=np.array([0, 1, 1]),
            top=np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]),
            bottom=np.stack([nan, nan, np.array([7.0, 8.0])]),
            response=np.array([0.02, 0.03, 0.04]),
            color=np.zeros((2, 3), np.uint8),
        ),
        pairs=pairs,
        inliers=np.where(pairs.joined, 15, 0),
        keyframes=4,
        nodes=6,
    )


def test_counts_are_of_pairs_landmarks_and_observations():
    found = matched(
        [(0, 1), (1, 2), (0, 2)],
        [Reason.MATCHED, Reason.FEW_INLIERS, Reason.MATCHED],
        [False, False, True],
    )
    assert found.counts() == {
        "keyframes": 4,
        "nodes": 6,
        "pairs": 3,
        "matched": 2,
        "matched_across_legs": 1,
        "rejected": 0,
        "landmarks": 2,
        "observations": 3,
        "stereo_observations": 1,
        "landmarks_of_several_nodes": 1,
    }


def test_failures_are_counted_by_their_reason():
    found = matched(
        [(0, 1), (1, 2), (2, 3)], [Reason.FEW_INLIERS, Reason.MATCHED, Reason.FEW_INLIERS]
    )
    assert found.failures() == {REASON_TEXTS[Reason.FEW_INLIERS]: 2}


@pytest.mark.parametrize(
    ("reasons", "sizes"),
    [((0, 0, 0), [4]), ((0, 3, 0), [2, 2]), ((3, 0, 0), [3, 1]), ((3, 3, 3), [1, 1, 1, 1])],
)
def test_pair_that_failed_parts_two_chains(reasons, sizes):
    assert matched([(0, 1), (1, 2), (2, 3)], [Reason(code) for code in reasons]).chains() == sizes


def test_pair_contradicted_by_path_joins_nothing_is_counted():
    found = matched(
        [(0, 1), (1, 2), (0, 3)],
        [Reason.MATCHED] * 3,
        [False, False, True],
        rejected=[False, False, True],
    )
    assert found.chains() == [3, 1]
    assert (
        found.counts()["matched"],
        found.counts()["rejected"],
        found.counts()["matched_across_legs"],
    ) == (2, 1, 0)
    assert found.failures() == {}


def test_no_match_raises_error_with_reason_and_remedy():
    pairs = matched([(0, 1), (1, 2)], [Reason.FEW_PUTATIVE, Reason.FEW_PUTATIVE]).pairs
    with pytest.raises(StageError, match="no two images could be matched") as raised:
        join_images(None, None, pairs, None, None, None, 3)
    assert f"of 2 pairs most failed by: {REASON_TEXTS[Reason.FEW_PUTATIVE]}" in str(
        raised.value.where
    )
    assert str(raised.value.remedy) == DVL_ALONE


def test_without_pairs_there_is_no_chain():
    assert matched([], []).chains() == []
