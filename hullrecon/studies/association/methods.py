# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Nearest neighbour, joint compatibility, and joint compatibility at random [Aulinas2011 4.2.2].

Confidences, the size of a random set and the number of draws are not printed in the thesis. The
confidence is of [NeiraTardos2001]; the draws follow from the chance that a random set is good.
"""

from __future__ import annotations

import numpy as np

from hullrecon.studies.association.point_sets import (
    Association,
    Hypothesis,
    Pair,
    PointSets,
    rows_of,
)
from hullrecon.typing import Ints

CONFIDENCE = 0.95
MOST_TESTS = 200_000  # a search by joint compatibility is cut short after these


def nearest_neighbours(sets: PointSets, confidence: float = CONFIDENCE) -> Association:
    """Pair every second point with the first point nearest to it by Mahalanobis distance.

    A first point that several would take goes to the nearest of them.
    """
    distance = np.where(sets.compatible(confidence), sets.squared_distances, np.inf)
    pairs = []
    for second in np.argsort(distance.min(axis=0, initial=np.inf)):
        first = int(np.argmin(distance[:, second])) if len(distance) else 0
        if len(distance) and np.isfinite(distance[first, second]):
            pairs.append((first, int(second)))
            distance[first] = np.inf
    found = tuple(sorted(pairs, key=lambda pair: pair[1]))
    return Association(pairs=found, squared_distance=sets.joint_distance(found), tests=1)


def joint_compatibility(
    sets: PointSets,
    confidence: float = CONFIDENCE,
    seconds: Ints | None = None,
    most_tests: int = MOST_TESTS,
) -> Association:
    """Find the most pairs that can all be true at once, by branch and bound (JCBB).

    Parameters
    ----------
    sets
        The points.
    confidence
        Of the gate of each pair, and of all pairs together.
    seconds
        Numbers of the second points to pair, all of them by default.
    most_tests
        Joint tests after which the best found so far is taken.

    Returns
    -------
    Association
        Of the largest sets of pairs, that with the smallest joint distance.
    """
    compatible = sets.compatible(confidence)
    wanted = range(len(sets.second)) if seconds is None else (int(second) for second in seconds)
    candidates = {
        second: [
            int(first)
            for first in np.argsort(sets.squared_distances[:, second], kind="stable")
            if compatible[first, second]
        ]
        for second in wanted
    }
    # points with few candidates first: a wrong pair then shows early
    order = sorted((s for s in candidates if candidates[s]), key=lambda s: (len(candidates[s]), s))
    search = _Search(sets, confidence, [(s, candidates[s]) for s in order], most_tests)
    search.branch(0)
    return Association(
        pairs=tuple(sorted(search.best, key=lambda pair: pair[1])),
        squared_distance=search.best_distance,
        tests=search.tests,
        complete=search.tests < most_tests,
    )


class _Search:
    """Depth-first search through all hypotheses, bounded by the best one so far."""

    def __init__(
        self,
        sets: PointSets,
        confidence: float,
        candidates: list[tuple[int, list[int]]],
        most_tests: int,
    ) -> None:
        self._candidates, self._most_tests = candidates, most_tests
        self._confidence = confidence
        self._hypothesis = Hypothesis(sets)
        self._used: set[int] = set()
        self.best: tuple[Pair, ...] = ()
        self.best_distance = 0.0
        self.tests = 0

    def branch(self, depth: int) -> None:
        """Try all candidates of the point at this depth, then none."""
        now = self._hypothesis
        if depth == len(self._candidates):
            self._keep_if_better()
            return
        second, firsts = self._candidates[depth]
        for first in firsts:
            if first in self._used or self.tests >= self._most_tests:
                continue
            if not self._may_win(depth, with_pair=True):
                return
            self.tests += 1
            now.add((first, second))
            if now.holds(self._confidence):
                self._used.add(first)
                self.branch(depth + 1)
                self._used.remove(first)
            now.drop()
        if self._may_win(depth, with_pair=False):
            self.branch(depth + 1)

    def _may_win(self, depth: int, with_pair: bool) -> bool:
        """Bound a branch by the most pairs that it can still hold."""
        left = len(self._candidates) - depth - (0 if with_pair else 1)
        most = len(self._hypothesis.pairs) + left
        nearer = self._hypothesis.squared_distance < self.best_distance
        return most > len(self.best) or (with_pair and most == len(self.best) and nearer)

    def _keep_if_better(self) -> None:
        now = self._hypothesis
        more = len(now.pairs) > len(self.best)
        as_many = len(now.pairs) == len(self.best)
        if more or (as_many and now.squared_distance < self.best_distance):
            self.best, self.best_distance = tuple(now.pairs), now.squared_distance


def randomised_compatibility(
    sets: PointSets,
    rng: np.random.Generator,
    confidence: float = CONFIDENCE,
    drawn: int = 4,
    good_share: float = 0.7,
    may_fail: float = 0.05,
) -> Association:
    """Pair a few points at random by joint compatibility, the others by nearest neighbour (RJC).

    Parameters
    ----------
    sets
        The points.
    rng
        Source of the draws.
    confidence
        As for `joint_compatibility`.
    drawn
        Points of a draw.
    good_share
        Share of the points in the overlap that have a true mate.
    may_fail
        Probability that no draw is all good.

    Returns
    -------
    Association
        The largest hypothesis of all draws.
    """
    compatible = sets.compatible(confidence)
    overlap = np.asarray(np.flatnonzero(compatible.any(axis=0)), dtype=np.int64)
    if len(overlap) <= drawn:
        return joint_compatibility(sets, confidence, seconds=overlap)
    draws = int(np.ceil(np.log(may_fail) / np.log(1.0 - good_share**drawn)))
    best, tests = Association(pairs=(), squared_distance=0.0, tests=0), 0
    for _ in range(draws):
        chosen = np.asarray(rng.choice(overlap, drawn, replace=False), dtype=np.int64)
        seed = joint_compatibility(sets, confidence, seconds=chosen)
        found = _extend(sets, seed, overlap, confidence)
        tests += seed.tests + found.tests
        if _order(found) > _order(best):
            best = found
    return Association(pairs=best.pairs, squared_distance=best.squared_distance, tests=tests)


def _order(found: Association) -> tuple[int, float]:
    return len(found.pairs), -found.squared_distance


def _extend(sets: PointSets, seed: Association, overlap: Ints, confidence: float) -> Association:
    """Pair what the seed left by nearest neighbour, given the seed's pairs."""
    if not seed.pairs:
        return seed
    hypothesis = Hypothesis(sets)
    for pair in seed.pairs:
        hypothesis.add(pair)
    tests = 0
    rest = [int(s) for s in overlap if s not in {pair[1] for pair in seed.pairs}]
    for first, second in _nearest_given(sets, seed.pairs, rest, confidence):
        tests += 1
        hypothesis.add((first, second))
        if not hypothesis.holds(confidence):
            hypothesis.drop()
    return Association(
        pairs=tuple(sorted(hypothesis.pairs, key=lambda pair: pair[1])),
        squared_distance=hypothesis.squared_distance,
        tests=tests,
    )


def _nearest_given(
    sets: PointSets, known: tuple[Pair, ...], rest: list[int], confidence: float
) -> list[Pair]:
    """Pair points by nearest neighbour after the known pairs were taken for true."""
    free = [i for i in range(len(sets.first)) if i not in {pair[0] for pair in known}]
    if not free or not rest:
        return []
    updated = given_pairs(sets, known, free, rest)
    found = nearest_neighbours(updated, confidence)
    return [(free[i], rest[j]) for i, j in found.pairs]


def given_pairs(
    sets: PointSets, known: tuple[Pair, ...], firsts: list[int], seconds: list[int]
) -> PointSets:
    """Update the points `firsts` and `seconds` by the fact that the known pairs are the same."""
    n, d = len(sets.first), sets.dimension
    cross = sets.cross_covariance
    cross = np.zeros((n * d, len(sets.second) * d)) if cross is None else cross
    joint = np.block([[sets.first_covariance, cross], [cross.T, sets.second_covariance]])
    rows = rows_of([i for i, _ in known], d), rows_of([n + j for _, j in known], d)
    wanted = rows_of(firsts + [n + j for j in seconds], d)
    by_difference = joint[np.ix_(wanted, rows[1])] - joint[np.ix_(wanted, rows[0])]
    spread = joint[np.ix_(rows[1], rows[1])] + joint[np.ix_(rows[0], rows[0])]
    across = joint[np.ix_(rows[1], rows[0])]
    gain = np.linalg.solve(spread - across - across.T, by_difference.T).T
    off = np.concatenate([sets.difference(pair) for pair in known])
    points = np.concatenate([sets.first[firsts].ravel(), sets.second[seconds].ravel()])
    points = points - gain @ off
    covariance = joint[np.ix_(wanted, wanted)] - gain @ by_difference.T
    cut = len(firsts) * d
    return PointSets(
        first=points[:cut].reshape(-1, d),
        second=points[cut:].reshape(-1, d),
        first_covariance=covariance[:cut, :cut],
        second_covariance=covariance[cut:, cut:],
        cross_covariance=covariance[:cut, cut:],
    )
