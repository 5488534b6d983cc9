# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Ranks of known scores, and FAB-MAP on words of which the answer is known."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.appearance import at_random, false_links, ranked
from benchmarks.fabmap import SEEN_IF_THERE, learn, log_likelihoods
from hullrecon.geometry.poses import Poses
from hullrecon.vision.appearance.recognition import Recognition
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.pair_match import PairMatch, Reason, failed_match
from hullrecon.vision.pairs.selection import Proposal


def places(n=12, w=60, seed=4):
    """n places, each with words of its own, and seen twice: a third of what is there is missed."""
    rng = np.random.default_rng(seed)
    there = rng.random((n, w)) < 0.3
    return np.vstack([there & (rng.random((n, w)) < 0.7), there & (rng.random((n, w)) < 0.7)])


def test_recall_and_precision_are_those_of_the_ranks():
    scores = np.array([np.arange(30.0), np.arange(30.0)[::-1]])
    true = np.zeros((2, 30), bool)
    true[0, 29] = true[1, 3] = true[1, 10] = True  # ranks 1; 4 and 11
    found = ranked(scores, np.ones((2, 30), bool), true)
    assert [found[f"recall_at_{k}"] for k in (1, 5, 20)] == [0.5, 1.0, 1.0]
    assert [found[f"precision_at_{k}"] for k in (1, 5, 20)] == pytest.approx(
        [1 / 2, 2 / 10, 3 / 40]
    )


def test_what_is_no_candidate_is_not_ranked():
    scores, true = np.array([[9.0, 1.0, 0.5]]), np.array([[True, True, False]])
    candidate = np.array([[False, True, True]])
    assert ranked(scores, candidate, true)["recall_at_1"] == 1.0
    assert ranked(scores, np.array([[False, False, True]]), true)["recall_at_1"] == 0.0


def test_a_random_rank_is_the_mean_of_drawn_ones():
    rng = np.random.default_rng(2)
    candidate = np.ones((3, 25), bool)
    true = np.zeros((3, 25), bool)
    true[0, :2] = true[1, :5] = true[2, :24] = True
    drawn = [ranked(rng.random((3, 25)), candidate, true) for _ in range(2000)]
    found = at_random(candidate, true)
    for name, value in found.items():
        assert value == pytest.approx(np.mean([d[name] for d in drawn]), abs=0.02), name


@pytest.mark.parametrize("tree", [True, False])
def test_an_image_is_likeliest_at_its_own_place(tree):
    shown = places()
    found = log_likelihoods(learn(shown), shown, np.arange(12), tree)
    assert found.shape == (12, 25)
    own = found[:, :-1].copy()
    own[np.arange(12), np.arange(12)] = -np.inf
    assert (own.argmax(axis=1) == np.arange(12) + 12).mean() >= 0.9


def test_naive_bayes_is_the_product_over_words_written_out():
    shown = np.array([[1, 0, 1], [1, 1, 0], [0, 0, 1], [1, 0, 0]], bool)
    words, expected = learn(shown), 0.0
    for word, share in enumerate(words.share):
        seen, there = shown[1, word], shown[0, word]  # the query is 0, the place 1
        exists = 1.0 if seen else 0.61 * share / (0.61 * share + 1 - share)
        observed = exists * SEEN_IF_THERE
        expected += np.log(observed if there else 1 - observed)
    assert log_likelihoods(words, shown, [0], tree=False)[0, 1] == pytest.approx(expected)


def test_the_tree_joins_the_words_that_come_together():
    rng = np.random.default_rng(1)
    a, b = rng.random((2, 400)) < 0.4
    noisy = np.where(rng.random(400) < 0.05, ~a, a)
    words = learn(np.stack([a, b, noisy], axis=1))
    edges = {frozenset((k, int(p))) for k, p in enumerate(words.parent) if p >= 0}
    assert frozenset((0, 2)) in edges
    assert len(edges) == 2
    child = 2 if words.parent[2] == 0 else 0
    assert words.given[child, 1] > 0.9 > 0.1 > words.given[child, 0]


def test_a_place_like_no_other_is_called_new():
    shown = np.zeros((9, 40), bool)
    shown[:8, :20] = np.random.default_rng(3).random((8, 20)) < 0.9
    shown[8, 20:] = True
    found = log_likelihoods(learn(shown), shown, [8])[0]
    assert found[-1] > found[:8].max()


def test_link_that_misplaces_the_second_camera_is_false():
    cameras = Poses(np.tile([0, 0, 0, 1.0], (3, 1)), np.array([[0, 0, 0], [1, 0, 0], [5, 0, 0.0]]))
    dive = SimpleNamespace(cameras=cameras)
    rows, found = np.arange(2), []
    for shift in (-1.1, -2.0):
        matrix = np.eye(4)
        matrix[0, 3] = shift
        found.append(
            PairMatch(
                first=rows,
                second=rows,
                distance=np.zeros(2, np.float32),
                putative=9,
                reason=Reason.MATCHED,
                motion=Motion(matrix, np.eye(6)),
            )
        )
    found.append(failed_match(1, Reason.FEW_INLIERS))
    pairs = Proposal(
        first=np.zeros(3, int),
        second=np.array([1, 2, 1]),
        across=np.ones(3, bool),
        overlap=np.ones(3),
    )
    asked = Recognition(
        proposal=pairs, found=tuple(found), accepted=np.zeros(3, bool), counts={}, refusal=None
    )
    assert false_links(dive, asked).tolist() == [False, True, False]
