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
    squared_lengths,
)
from hullrecon.typing import Array, Ints, Mask

CONFIDENCE = 0.95
DRAWN, MAY_FAIL = 4, 0.05  # points of a draw, and probability that no draw is all good
MOST_TESTS = 200_000  # a search by joint compatibility is cut short after these


def nearest_neighbours(sets: PointSets, confidence: float = CONFIDENCE) -> Association:
    """Pair each point of the second set with the nearest of the first by Mahalanobis distance.

    A point of the first set that several would take goes to the nearest of them. confidence: of the
    gate of a pair.
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
        """Prepare a search.

        Parameters
        ----------
        sets
            The points.
        confidence
            Of all pairs together.
        candidates
            Each point of the second set to pair, with the points of the first that it may be.
        most_tests
            Joint tests after which the search stops.
        """
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
        """Tell whether a branch can still beat the best hypothesis, by the pairs left to make.

        with_pair: whether the point at this depth is paired in the branch.
        """
        left = len(self._candidates) - depth - (0 if with_pair else 1)
        most = len(self._hypothesis.pairs) + left
        nearer = self._hypothesis.squared_distance < self.best_distance
        return most > len(self.best) or (with_pair and most == len(self.best) and nearer)

    def _keep_if_better(self) -> None:
        """Keep the hypothesis if it has more pairs than the best, or as many that lie nearer."""
        now = self._hypothesis
        more = len(now.pairs) > len(self.best)
        as_many = len(now.pairs) == len(self.best)
        if more or (as_many and now.squared_distance < self.best_distance):
            self.best, self.best_distance = tuple(now.pairs), now.squared_distance


def randomised_compatibility(
    sets: PointSets,
    rng: np.random.Generator,
    confidence: float = CONFIDENCE,
    good_share: float = 0.7,
) -> Association:
    """Pair a few points at random by joint compatibility, the others by nearest neighbour (RJC).

    Draws end once one of good points has probably been among them, as those of RANSAC do
    [HartleyZisserman2004 Algorithm 4.5]: the more points a draw has led to, the fewer are needed.

    Parameters
    ----------
    sets
        The points.
    rng
        Source of the draws.
    confidence
        As for `joint_compatibility`.
    good_share
        Share of the points in the overlap that have a true mate, at least.

    Returns
    -------
    Association
        The largest hypothesis of all draws.
    """
    compatible = sets.compatible(confidence)
    overlap = np.asarray(np.flatnonzero(compatible.any(axis=0)), dtype=np.int64)
    if len(overlap) <= DRAWN:
        return joint_compatibility(sets, confidence, seconds=overlap)
    best, tests, draws = Association(pairs=(), squared_distance=0.0, tests=0), 0, 0
    while draws < _draws_needed(max(good_share, len(best.pairs) / len(overlap))):
        chosen = np.asarray(rng.choice(overlap, DRAWN, replace=False), dtype=np.int64)
        seed = joint_compatibility(sets, confidence, seconds=chosen)
        found = _extend(sets, seed, compatible, confidence)
        draws, tests = draws + 1, tests + seed.tests + found.tests
        if _order(found) > _order(best):
            best = found
    return Association(pairs=best.pairs, squared_distance=best.squared_distance, tests=tests)


def _draws_needed(good_share: float) -> float:
    """Count the draws among which one is all good, but for the probability MAY_FAIL."""
    all_good = good_share**DRAWN
    return 1.0 if all_good >= 1.0 else np.log(MAY_FAIL) / np.log(1.0 - all_good)


def _order(found: Association) -> tuple[int, float]:
    """Rank associations: more pairs are better, then a smaller joint distance."""
    return len(found.pairs), -found.squared_distance


def _extend(sets: PointSets, seed: Association, compatible: Mask, confidence: float) -> Association:
    """Pair the points outside the seed by nearest neighbour, given the seed's pairs.

    Every pair must pass its own gate, `compatible` (n, m), and the joint one of `confidence`, as in
    `joint_compatibility`.
    """
    if not seed.pairs:
        return seed
    hypothesis = Hypothesis(sets)
    for pair in seed.pairs:
        hypothesis.add(pair)
    tests, taken = 0, [set(side) for side in zip(*seed.pairs, strict=True)]
    free = compatible.copy()
    free[list(taken[0])] = free[:, list(taken[1])] = False
    pairs = np.argwhere(free)
    distance = distances_given(sets, seed.pairs, pairs)
    for first, second in pairs[np.argsort(distance, kind="stable")].tolist():
        if first in taken[0] or second in taken[1]:
            continue
        tests += 1
        hypothesis.add((first, second))
        taken[1].add(second)  # tried with its nearest alone, whether that holds or not
        if hypothesis.holds(confidence):
            taken[0].add(first)
        else:
            hypothesis.drop()
    return Association(
        pairs=tuple(sorted(hypothesis.pairs, key=lambda pair: pair[1])),
        squared_distance=hypothesis.squared_distance,
        tests=tests,
    )


def distances_given(sets: PointSets, known: tuple[Pair, ...], pairs: Ints) -> Array:
    """Compute squared Mahalanobis distances (k,) of pairs (k, 2), given that known pairs are true.

    What the known pairs tell of an error that all share, such as an offset, is taken off first.
    """
    d = sets.dimension
    rows = [rows_of(list(side), d) for side in zip(*known, strict=True)]
    wanted = [rows_of(side.tolist(), d) for side in pairs.T]
    across = sets.first_covariance[np.ix_(wanted[0], rows[0])]
    across = across + sets.second_covariance[np.ix_(wanted[1], rows[1])]
    if sets.cross_covariance is not None:
        across = across - sets.cross_covariance[np.ix_(wanted[0], rows[1])]
        across = across - sets.cross_covariance[np.ix_(rows[0], wanted[1])].T
    spread, off = sets.spread_of(*rows), sets.second.ravel()[rows[1]] - sets.first.ravel()[rows[0]]
    gain = np.linalg.solve(spread, across.T).T
    rest = sets.differences[pairs[:, 0], pairs[:, 1]] - (gain @ off).reshape(-1, d)
    shape = (len(pairs), d, -1)
    known_part = gain.reshape(shape) @ across.reshape(shape).swapaxes(1, 2)
    return squared_lengths(rest, sets.spreads[pairs[:, 0], pairs[:, 1]] - known_part)
