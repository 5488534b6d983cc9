# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Visual words [SivicZisserman2003]: cells of descriptor space, learnt from a dive's own images, in
two levels [NisterStewenius2006].

Centres are rounded to bytes: every product and sum below is a whole number under 2^24, exact in
float32, so that a word depends neither on the order of a sum nor on the number of threads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Ints

BRANCHES = 64  # of either level: at most 4096 words
ITERATIONS = 10  # of Lloyd's algorithm
BLOCK = 4096  # descriptors compared with the centres at once

Descriptors = NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True)
class Vocabulary:
    """coarse (b, 128): centres of the first level; fine (w, 128): those of the words, start (b +
    1,): where the words of each coarse centre begin.
    """

    coarse: Descriptors
    fine: Descriptors
    start: Ints

    def __len__(self) -> int:
        return len(self.fine)

    def words(self, descriptors: Descriptors) -> Ints:
        """Return the word (n,) of each descriptor (n, 128)."""
        branch = _nearest(descriptors, self.coarse)
        out = np.zeros(len(descriptors), np.int64)
        for k in np.unique(branch):
            rows = np.flatnonzero(branch == k)
            first, last = self.start[k : k + 2]
            out[rows] = first + _nearest(descriptors[rows], self.fine[first:last])
        return out


def learn_vocabulary(descriptors: Descriptors, seed: int, branches: int = BRANCHES) -> Vocabulary:
    """Return at most branches^2 words of a sample of descriptors (n, 128). Raises ValueError where
    there are none.
    """
    if len(descriptors) == 0:
        raise ValueError("a vocabulary needs descriptors")
    rng = np.random.default_rng(seed)
    coarse = _cluster(descriptors, branches, rng)
    branch = _nearest(descriptors, coarse)
    coarse = coarse[np.unique(branch)]  # a centre without members has no words
    branch = _nearest(descriptors, coarse)
    fine = [_cluster(descriptors[branch == k], branches, rng) for k in range(len(coarse))]
    start = np.concatenate([[0], np.cumsum([len(centres) for centres in fine])])
    return Vocabulary(coarse=coarse, fine=np.concatenate(fine), start=start)


def _cluster(descriptors: Descriptors, count: int, rng: np.random.Generator) -> Descriptors:
    """Return at most that many centres by Lloyd's algorithm; one that loses its members stays where
    it is.
    """
    centres = descriptors[
        np.sort(rng.choice(len(descriptors), min(count, len(descriptors)), replace=False))
    ]
    for _ in range(ITERATIONS):
        label = _nearest(descriptors, centres)
        size = np.bincount(label, minlength=len(centres))
        total = np.zeros(centres.shape, np.int64)
        order = np.argsort(label, kind="stable")
        begin = np.concatenate([[0], np.cumsum(size)[:-1]])[size > 0]
        total[size > 0] = np.add.reduceat(descriptors[order], begin, axis=0, dtype=np.int64)
        moved = np.where(
            size[:, None] > 0,
            (2 * total + size[:, None]) // np.maximum(2 * size, 1)[:, None],
            centres,
        )
        if (moved == centres).all():
            break
        centres = moved.astype(np.uint8)
    return centres


def _nearest(descriptors: Descriptors, centres: Descriptors) -> Ints:
    """Return the number (n,) of the centre nearest to each descriptor, the first of several."""
    turned = centres.astype(np.float32).T
    square = (turned * turned).sum(axis=0)
    out = np.zeros(len(descriptors), np.int64)
    for first in range(0, len(descriptors), BLOCK):
        rows = slice(first, first + BLOCK)
        out[rows] = (square - 2 * (descriptors[rows].astype(np.float32) @ turned)).argmin(axis=1)
    return out
