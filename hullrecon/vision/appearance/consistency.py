# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find links that confirm each other [Mangelson2018].

The motions around two links and the path on both sides must close.
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

MAX_CHI2 = 22.5  # of a closed loop's six numbers, 99.9 %


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """The consistency of m links, where the path between them is known well enough to judge it."""

    agree: Mask  # (m, m) pairs of links whose loop closes
    contradict: Mask  # (m, m) pairs of links whose loop does not close


def compose(outer: Motion, inner: Motion) -> Motion:
    """Compose c_from_b and b_from_a, which err independently, with covariance to first order."""
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
        The leading cameras.
    first, second
        Nodes (m,) of the links.
    found
        Their matches.
    max_sigma_m
        Largest sigma of the path between their nodes, on either side. Where it is larger, two links
        neither confirm nor contradict each other.
    """
    # Around the cycle first j, first i, second i, second j: along the path, over link i, along the
    # path. It has to be the motion of link j.
    count = len(first)
    i, j = np.triu_indices(count, 1)
    here, there = track.motions(first[j], first[i]), track.motions(second[i], second[j])
    agree, contradict = np.zeros((count, count), bool), np.zeros((count, count), bool)
    for a, b, back, on in zip(i.tolist(), j.tolist(), here, there, strict=True):
        link = found[a].motion
        if link is None or max(_sigma_m(back), _sigma_m(on)) > max_sigma_m:
            continue
        closes = agrees(found[b], compose(compose(on, link), back), MAX_CHI2)
        agree[a, b] = agree[b, a] = closes
        contradict[a, b] = contradict[b, a] = not closes
    return Agreement(agree=agree, contradict=contradict)


def _sigma_m(motion: Motion) -> float:
    return float(np.sqrt(np.trace(motion.covariance[:3, :3]) / 3))


def largest_group(agree: Mask, among: Ints) -> Ints:
    """Find the largest group of links that all agree with each other, sorted.

    Greedy, started from each link in turn, by the number of links that each agrees with.
    """
    best = np.zeros(0, np.int64)
    for start in among:
        members, left = [int(start)], among[agree[start, among]]
        while len(left):
            degree = agree[np.ix_(left, left)].sum(axis=1)
            chosen = int(left[int(degree.argmax())])
            members.append(chosen)
            left = left[agree[chosen, left]]
        if len(members) > len(best):
            best = np.sort(np.array(members, np.int64))
    return best


def independent_links(first: Ints, second: Ints) -> int:
    """Count links (m,) without a common node. Greedy, so that there may be more."""
    used: set[int] = set()
    count = 0
    for a, b in zip(first.tolist(), second.tolist(), strict=True):
        if a not in used and b not in used:
            used |= {a, b}
            count += 1
    return count


def extent_m(points: Array) -> float:
    """Compute the largest distance between any two points (m, 3)."""
    return float(np.linalg.norm(points[:, None] - points[None], axis=2).max(initial=0.0))
