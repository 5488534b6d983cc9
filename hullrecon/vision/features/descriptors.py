# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Descriptors of features and their matching: all with all, or within a list of pairs.

Descriptors are RootSIFT as bytes, unit vectors times 512. Distances are between unit vectors. SIFT
gives a pixel one feature for each dominant orientation [Lowe2004 5]. Each of them may match, but
together they are one measurement. So every feature has a *place*: the number of the first feature
at its pixel, and a match is one of places.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hullrecon import native
from hullrecon.typing import Floats32, Ints, Mask, Pixels

UNIT = 512.0
WIDTH = 128  # numbers of a descriptor
RATIO = 0.8  # largest ratio of the best to the next best distance [Lowe2004 7.1]
MAX_DISTANCE = 0.75  # of two unit descriptors that may match; unrelated ones are sqrt(2) apart


@dataclass(frozen=True, kw_only=True)
class Putative:
    """Matches of two sets of features before geometric verification."""

    first: Ints  # (m,) rows of the first set
    second: Ints  # (m,) rows of the second set
    distance: Floats32  # (m,) of the descriptors, 0 alike to sqrt(2) unrelated

    def __len__(self) -> int:
        return len(self.first)

    def take(self, rows: Ints | Mask | slice) -> Putative:
        """Select some of the matches."""
        return Putative(
            first=self.first[rows], second=self.second[rows], distance=self.distance[rows]
        )


class Described(Protocol):
    """Features as matching needs them."""

    @property
    def descriptor(self) -> Floats32:
        """Unit descriptors (n, 128)."""
        ...

    @property
    def place(self) -> Ints:
        """Number (n,) of the feature that stands for all at its pixel."""
        ...


@dataclass(frozen=True, kw_only=True)
class FeatureSet:
    """Features of one image, or some of them."""

    descriptor: Floats32  # (n, 128) unit vectors
    place: Ints  # (n,) number of the feature that stands for all at its pixel


# Matches two sets of features, of all pairs or only those allowed (rows of first, rows of second).
# Rows of the result are numbers of places. hullrecon/studies has a published variant.
MatchDescriptors = Callable[[Described, Described, tuple[Ints, Ints] | None], Putative]


def match_descriptors(
    first: Described, second: Described, allowed: tuple[Ints, Ints] | None
) -> Putative:
    """Match mutual best descriptors that pass the ratio test, one match a place (pixel).

    Features with two about equally good partners are left out. There may be no match.

    Parameters
    ----------
    first, second
        The two sets of features.
    allowed
        Pairs (rows of first, rows of second) that may match, None for all.
    """
    if allowed is None:
        found = best_of_all(first.descriptor, second.descriptor, RATIO, MAX_DISTANCE)
    else:
        distance = sparse_distance(first.descriptor, second.descriptor, *allowed)
        found = best_of_pairs(*allowed, distance, RATIO, MAX_DISTANCE)
    return match_places(found, first.place, second.place)


def root_sift(descriptors: Floats32) -> Pixels:
    """Take the square root of L1-normalised descriptors, times 512, as bytes."""
    share = descriptors / np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-9)
    return np.asarray(np.minimum(np.rint(np.sqrt(share) * UNIT), 255), np.uint8)


def to_unit(descriptors: NDArray[np.uint8]) -> Floats32:
    """Scale stored descriptors (n, 128) to about unit length."""
    return np.asarray(descriptors, np.float32) / np.float32(UNIT)


def sparse_distance(a: Floats32, b: Floats32, first: Ints, second: Ints) -> Floats32:
    """Compute the distances (m,) of pairs of descriptors, rows `first` of a and `second` of b."""
    return native.descriptor_distances(a, b, first, second)


def best_of_pairs(
    first: Ints, second: Ints, distance: Floats32, ratio: float, most: float
) -> Putative:
    """Select mutual best matches of a list of pairs (m,) by the ratio test on both sides.

    A feature that is in a single pair has no next best. Then only the distance and the mutual
    choice decide.

    Parameters
    ----------
    first, second
        Features (m,) of both sets.
    distance
        (m,) of their descriptors.
    ratio
        Largest ratio of the best to the next best distance.
    most
        Largest distance of a match.
    """
    if len(first) == 0:
        return _no_matches()
    # Rows of the best pair of each feature that has one, and by feature the next best distance.
    forward, forward_next = native.best_and_next(first, distance)
    backward, backward_next = native.best_and_next(second, distance)
    chosen = _in_both(forward, backward, len(first))
    limit = np.minimum(forward_next[first[chosen]], backward_next[second[chosen]]) * ratio
    chosen = np.sort(chosen[(distance[chosen] < limit) & (distance[chosen] < most)])
    return Putative(first=first[chosen], second=second[chosen], distance=distance[chosen])


def best_of_all(a: Floats32, b: Floats32, ratio: float, most: float) -> Putative:
    """Select mutual best matches of all descriptors a (n, 128) with all b (m, 128).

    ratio: largest distance of a match relative to the next best one of either feature. most:
    largest distance. Nothing matches where either set has fewer than two: there is no next best to
    compare with.
    """
    if len(a) < 2 or len(b) < 2:
        return _no_matches()
    # |a - b|^2 of all pairs
    squared = (a * a).sum(1)[:, None] + (b * b).sum(1)[None, :] - 2 * (a @ b.T)
    first = np.arange(len(a))
    second = squared.argmin(axis=1)
    mutual = squared.argmin(axis=0)[second] == first
    best = squared[first, second]
    next_of_a = np.partition(squared, 1, axis=1)[:, 1]
    next_of_b = np.partition(squared, 1, axis=0)[1]
    next_best = np.minimum(next_of_a, next_of_b[second])
    good = mutual & (best < ratio**2 * next_best) & (best < most**2)
    distance = np.sqrt(np.maximum(best[good], 0)).astype(np.float32)
    return Putative(first=first[good], second=second[good], distance=distance)


def first_at_place(keypoints: Floats32) -> Ints:
    """Find for each keypoint (n, 4) the first row (n,) at the same pixel.

    Keypoints of one place lie side by side.
    """
    new = np.ones(len(keypoints), bool)
    new[1:] = (np.diff(keypoints[:, :2], axis=0) != 0).any(axis=1)
    return np.asarray(np.flatnonzero(new)[np.cumsum(new) - 1])


def match_places(found: Putative, place_a: Ints, place_b: Ints) -> Putative:
    """Reduce matches of features to matches of their places, keeping the most alike of each.

    Several features at one pixel are one measurement, and must not count as several. place_a,
    place_b: place of each feature of the two sets.
    """
    first, second = place_a[found.first], place_b[found.second]
    if len(first) == 0:
        return _no_matches()
    forward, backward = (native.best_and_next(key, found.distance)[0] for key in (first, second))
    kept = np.sort(_in_both(forward, backward, len(first)))
    return Putative(first=first[kept], second=second[kept], distance=found.distance[kept])


def _in_both(rows: Ints, others: Ints, count: int) -> Ints:
    """Select those of rows that are among others too, all below count."""
    among = np.zeros(count, bool)
    among[others] = True
    return rows[among[rows]]


def _no_matches() -> Putative:
    return Putative(
        first=np.zeros(0, np.int64), second=np.zeros(0, np.int64), distance=np.zeros(0, np.float32)
    )
