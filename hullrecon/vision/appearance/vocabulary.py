# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Visual words, and a ranking of images by shared rare words [SivicZisserman2003].

Words are cells of descriptor space, learnt from a dive's own images in two levels
[NisterStewenius2006]. An inverted file weights them by term frequency and inverse document
frequency. Centres are rounded to bytes: every product and sum of the words is a whole number under
2^24, exact in float32, so that a word depends neither on the order of a sum nor on threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from hullrecon.typing import Array, Ints

BRANCHES = 64  # of either level: at most 4096 words
ITERATIONS = 10  # of Lloyd's algorithm (k-means) at most
BLOCK = 4096  # descriptors compared with the centres at once

Descriptors = NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True)
class Vocabulary:
    """Visual words in two levels."""

    coarse: Descriptors  # (b, 128) centres of the first level
    fine: Descriptors  # (w, 128) centres of the words
    start: Ints  # (b + 1,) first word of each coarse centre

    def __len__(self) -> int:
        return len(self.fine)

    def words(self, descriptors: Descriptors) -> Ints:
        """Assign a word (n,) to each descriptor (n, 128).

        It is the nearest of those words that belong to the nearest coarse centre.
        """
        branch = _nearest(descriptors, self.coarse)
        out = np.zeros(len(descriptors), np.int64)
        for k in np.unique(branch):
            rows = np.flatnonzero(branch == k)
            first, last = self.start[k : k + 2]
            out[rows] = first + _nearest(descriptors[rows], self.fine[first:last])
        return out


@dataclass(frozen=True, kw_only=True)
class InvertedFile:
    """The weighted words of n images, for a fast comparison of one image with all."""

    images: csr_array  # (n, w) weights of each image's words, of unit length
    by_word: csr_array  # (w, n) images of each word

    def __len__(self) -> int:
        return int(self.images.shape[0])

    def scores(self, images: Ints) -> Array:
        """Compute the cosine (m, n) between the words of some images (m,) and those of all."""
        return np.asarray((self.images[images] @ self.by_word).toarray())


def learn_vocabulary(descriptors: Descriptors, seed: int, branches: int = BRANCHES) -> Vocabulary:
    """Learn at most branches^2 words from descriptors (n, 128), by k-means in two levels.

    seed: of the first centres, which are drawn from the descriptors.

    Raises
    ------
    ValueError
        Without descriptors.
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


def invert(words: Sequence[Ints], vocabulary: int) -> InvertedFile:
    """Build the inverted file of n images from their words, of a vocabulary of that size.

    words: of each image, one for each feature. A word's weight is its share of the image's features
    times log(n / images with that word): words that all images show have no weight. The weights of
    an image are scaled to unit length, so that the product of two images is their likeness.
    """
    size = np.array([len(w) for w in words], np.int64)
    image = np.repeat(np.arange(len(words)), size)
    word = np.concatenate([np.zeros(0, np.int64), *words])
    counts = coo_array((np.ones(len(word)), (image, word)), shape=(len(words), vocabulary)).tocsr()
    counts.sum_duplicates()
    holding = np.bincount(counts.indices, minlength=vocabulary)
    weight = np.log(len(words) / np.maximum(holding, 1))
    counts.data *= weight[counts.indices]
    length = np.sqrt(np.asarray(counts.multiply(counts).sum(axis=1)).ravel())
    counts.data /= np.repeat(np.maximum(length, 1e-12), np.diff(counts.indptr))
    return InvertedFile(images=counts, by_word=counts.T.tocsr())


def _cluster(descriptors: Descriptors, count: int, rng: np.random.Generator) -> Descriptors:
    """Find at most `count` centres of descriptors by Lloyd's algorithm.

    A centre without members stays where it is.
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
        # The mean of each centre's members, rounded to a byte in whole numbers.
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
    """Find the nearest centre (n,) of each descriptor, the first where several are equal."""
    # |d - c|^2 without |d|^2, which is the same for all centres.
    turned = centres.astype(np.float32).T
    square = (turned * turned).sum(axis=0)
    out = np.zeros(len(descriptors), np.int64)
    for first in range(0, len(descriptors), BLOCK):
        rows = slice(first, first + BLOCK)
        out[rows] = (square - 2 * (descriptors[rows].astype(np.float32) @ turned)).argmin(axis=1)
    return out
