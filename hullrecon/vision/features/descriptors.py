# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Comparing descriptors: everything against everything, or only a sparse list of pairs.

Descriptors are RootSIFT as uint8: unit vectors times 512, so that distances below are between unit
vectors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon import native
from hullrecon.typing import Floats32, Ints, Pixels

UNIT = 512.0
WIDTH = 128  # numbers of a descriptor


@dataclass(frozen=True, kw_only=True)
class Putative:
    """Rows of either side that are each other's best, with the distance (0 same, sqrt 2 unrelated)."""

    first: Ints
    second: Ints
    distance: Floats32

    def __len__(self) -> int:
        return len(self.first)


def root_sift(descriptors: Floats32) -> Pixels:
    """Return the Hellinger form: square root of the L1-normalised vector (unit length), times 512,
    as bytes.
    """
    share = descriptors / np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-9)
    return np.asarray(np.minimum(np.rint(np.sqrt(share) * UNIT), 255), np.uint8)


def to_unit(descriptors: NDArray[np.uint8]) -> Floats32:
    """Return (n, 128) float32 of about unit length."""
    return np.asarray(descriptors, np.float32) / np.float32(UNIT)


def sparse_distance(a: Floats32, b: Floats32, first: Ints, second: Ints) -> Floats32:
    """Return distances (m,) of the pairs (first into a, second into b)."""
    return native.descriptor_distances(a, b, first, second)


def best_of_pairs(
    first: Ints, second: Ints, distance: Floats32, ratio: float, most: float
) -> Putative:
    """Return mutual best within a list of pairs, closer than `most`, and than `ratio` times the
    next of either side.

    A feature in a single pair has no next one; then only `most` and the mutual choice count.
    """
    if len(first) == 0:
        return _no_matches()
    forward, forward_next = native.best_and_next(first, distance)
    backward, backward_next = native.best_and_next(second, distance)
    chosen = forward[np.isin(forward, backward)]
    limit = np.minimum(forward_next[first[chosen]], backward_next[second[chosen]]) * ratio
    chosen = np.sort(chosen[(distance[chosen] < limit) & (distance[chosen] < most)])
    return Putative(first=first[chosen], second=second[chosen], distance=distance[chosen])


def mutual_best(first: Ints, second: Ints, distance: Floats32) -> Ints:
    """Return the rows, ascending, of pairs (m,) that are the best of both of their features."""
    if len(first) == 0:
        return np.zeros(0, np.int64)
    forward, backward = (native.best_and_next(key, distance)[0] for key in (first, second))
    return np.sort(forward[np.isin(forward, backward)])


def best_of_all(a: Floats32, b: Floats32, ratio: float, most: float) -> Putative:
    """Return the mutual best of all a (n, 128) and b (m, 128) with the ratio test on both sides."""
    if len(a) < 2 or len(b) < 2:
        return _no_matches()
    product = a @ b.T
    squared = (a * a).sum(1)[:, None] + (b * b).sum(1)[None, :] - 2 * product
    first = np.arange(len(a))
    second = squared.argmin(axis=1)
    mutual = squared.argmin(axis=0)[second] == first
    two_a = np.partition(squared, 1, axis=1)[:, 1]
    two_b = np.partition(squared, 1, axis=0)[1]
    best = squared[first, second]
    good = mutual & (best < ratio**2 * np.minimum(two_a, two_b[second])) & (best < most**2)
    distance = np.sqrt(np.maximum(best[good], 0)).astype(np.float32)
    return Putative(first=first[good], second=second[good], distance=distance)


def _no_matches() -> Putative:
    return Putative(
        first=np.zeros(0, np.int64), second=np.zeros(0, np.int64), distance=np.zeros(0, np.float32)
    )
