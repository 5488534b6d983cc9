# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""SIFT features and corners side by side: like is compared with like, and of what matches corners
are a share at most.

The share is steered as in [KimEustice2009 III-A], by the distance that the Zernike vectors of two
corners may have: here it is chosen for each set of matches, as the one at which the share is
reached.
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Floats32, Ints, Mask
from hullrecon.vision.features.descriptors import Putative, best_of_all


def like_pairs(first: Ints, second: Ints, corner_a: Mask, corner_b: Mask) -> tuple[Ints, Ints]:
    """Return those pairs (first into a, second into b) that are two SIFT features or two corners."""
    if not corner_a.any() and not corner_b.any():
        return first, second
    like = corner_a[first] == corner_b[second]
    return first[like], second[like]


def best_of_each_kind(
    a: Floats32, b: Floats32, corner_a: Mask, corner_b: Mask, ratio: float, most: float
) -> Putative:
    """Return the mutual best of all a (n, 128) and b (m, 128) within each kind: the SIFT features',
    then the corners'.
    """
    if not corner_a.any() and not corner_b.any():
        return best_of_all(a, b, ratio, most)
    parts = []
    for kind_a, kind_b in ((~corner_a, ~corner_b), (corner_a, corner_b)):
        rows_a, rows_b = np.flatnonzero(kind_a), np.flatnonzero(kind_b)
        found = best_of_all(a[rows_a], b[rows_b], ratio, most)
        parts.append((rows_a[found.first], rows_b[found.second], found.distance))
    first, second, distance = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Putative(first=first, second=second, distance=distance)


def limit_corners(found: Putative, corner: Mask, share: float) -> Putative:
    """Return the matches with no more corners than that share of them, the most alike; corner (m,):
    which are of corners.

    SIFT features are all kept: where few match, few corners are.
    """
    if not corner.any():
        return found
    room = int(share / (1 - share) * (~corner).sum() + 1e-9)
    rows = np.flatnonzero(corner)
    alike = rows[np.argsort(found.distance[rows], kind="stable")[:room]]
    kept = np.sort(np.concatenate([np.flatnonzero(~corner), alike]))
    return Putative(
        first=found.first[kept], second=found.second[kept], distance=found.distance[kept]
    )
