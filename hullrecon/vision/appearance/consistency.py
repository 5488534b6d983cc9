# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find links that confirm each other [Mangelson2018].

Two links and the pieces of the path that connect their ends form a loop. If both links are right,
the product of the four motions is the identity within its covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.pair_match import PairMatch, agrees

MAX_CHI2 = 22.5  # of a loop's misclosure: 99.9 % of chi-square with six degrees of freedom


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """The consistency of m links.

    Two of them neither agree nor contradict where the path between them is too uncertain to tell.
    """

    agree: Mask  # (m, m) pairs of links whose loop closes
    contradict: Mask  # (m, m) pairs of links whose loop does not close


def compose(outer: Motion, inner: Motion) -> Motion:
    """Compose c_from_b (outer) and b_from_a (inner) to c_from_a, with covariance to first order.

    The errors of both are taken as independent.
    """
    # The composed motion is R_o R_i, R_o t_i + t_o. Its derivative by the errors of `outer`: the
    # rotation moves R_o t_i, and is carried through R_i. By those of `inner`: R_o turns t_i.
    turn = outer.second_from_first[:3, :3]
    by_outer, by_inner = np.eye(6), np.eye(6)
    by_outer[:3, 3:] = -turn @ cross_matrix(inner.second_from_first[:3, 3])
    by_outer[3:, 3:] = inner.second_from_first[:3, :3].T
    by_inner[:3, :3] = turn
    covariance = by_outer @ outer.covariance @ by_outer.T + by_inner @ inner.covariance @ by_inner.T
    return Motion(outer.second_from_first @ inner.second_from_first, covariance)


def agreement(
    track: CameraTrack, first: Ints, second: Ints, found: Sequence[PairMatch], max_sigma_m: float
) -> Agreement:
    """Test which links (m,), all matched, confirm or contradict each other.

    Parameters
    ----------
    track
        The leading cameras, whose relative motions close the loops.
    first, second
        Nodes (m,) of the links.
    found
        The links themselves: the result of each pair, with its motion.
    max_sigma_m
        Largest sigma of the path between the first nodes of two links, and between their second
        ones. Where it is larger, two links neither confirm nor contradict each other.
    """
    # From first[j] along the path to first[i], over link i to second[i], and along the path to
    # second[j]. This has to agree with the motion of link j.
    count = len(first)
    i, j = np.triu_indices(count, 1)
    along_first = track.motions(first[j], first[i])
    along_second = track.motions(second[i], second[j])
    agree, contradict = np.zeros((count, count), bool), np.zeros((count, count), bool)
    for a, b, before, after in zip(i.tolist(), j.tolist(), along_first, along_second, strict=True):
        link = found[a].motion
        if link is None or max(_sigma_m(before), _sigma_m(after)) > max_sigma_m:
            continue
        closes = agrees(found[b], compose(compose(after, link), before), MAX_CHI2)
        agree[a, b] = agree[b, a] = closes
        contradict[a, b] = contradict[b, a] = not closes
    return Agreement(agree=agree, contradict=contradict)


def _sigma_m(motion: Motion) -> float:
    """Compute the sigma of a motion's translation, the mean over the axes."""
    return float(np.sqrt(np.trace(motion.covariance[:3, :3]) / 3))


def largest_group(agree: Mask, among: Ints) -> Ints:
    """Find a large group of links that all agree with each other: a clique, by a greedy search.

    Wrong links hardly agree by chance, so the largest group is likely to hold the right ones. From
    each link in turn, the candidate that agrees with most other candidates is added, until none
    agrees with all members. The largest group found is returned, sorted.

    agree: (m, m) pairs of links that agree. among: the links (k,) to choose from.
    """
    best = np.zeros(0, np.int64)
    for start in among:
        members, candidates = [int(start)], among[agree[start, among]]
        while len(candidates):
            degree = agree[np.ix_(candidates, candidates)].sum(axis=1)
            chosen = int(candidates[int(degree.argmax())])
            members.append(chosen)
            candidates = candidates[agree[chosen, candidates]]
        if len(members) > len(best):
            best = np.sort(np.array(members, np.int64))
    return best


def independent_links(first: Ints, second: Ints) -> int:
    """Count links of which no two share a node, chosen greedily from links (m,).

    Links that share an image may be wrong by the same cause, so they count once. There may be a
    larger choice: the count is a lower bound. first, second: (m,) nodes of the links.
    """
    used: set[int] = set()
    count = 0
    for a, b in zip(first.tolist(), second.tolist(), strict=True):
        if a not in used and b not in used:
            used |= {a, b}
            count += 1
    return count


def extent_m(points: Array) -> float:
    """Compute the largest distance between any two points (m, 3), 0 with less than two."""
    return float(np.linalg.norm(points[:, None] - points[None], axis=2).max(initial=0.0))
