# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which images share rare words [SivicZisserman2003]: an inverted file, weighted by term frequency
and inverse document frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class InvertedFile:
    """images (n, w): the weights of each image's words, of unit length; by_word (w, n): the images
    of each word.
    """

    images: csr_array
    by_word: csr_array

    def __len__(self) -> int:
        return int(self.images.shape[0])

    def scores(self, images: Ints) -> Array:
        """Return the cosine (m, n) between the words of some images (m,) and those of all."""
        return np.asarray((self.images[images] @ self.by_word).toarray())


def invert(words: Sequence[Ints], vocabulary: int) -> InvertedFile:
    """Return the inverted file of n images from their words, of a vocabulary of that size.

    A word counts by the share of the image's features that show it times log(n / images with that
    word): what all images show says nothing.
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
