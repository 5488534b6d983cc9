# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""FAB-MAP [CumminsNewman2008] in plain NumPy: how likely an image is from the place of another, by
which words both show, the words as a tree in which each depends on one other [ChowLiu1968], or all
apart (naive Bayes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array, Ints, Mask

SEEN_IF_THERE, SEEN_IF_NOT = 0.39, 0.0  # of a word, as that paper's detector has it
LEAST_SHARE = 1e-3  # of the images that show a word: no probability is 0 or 1


@dataclass(frozen=True, kw_only=True)
class Words:
    """How often images show each of w words, alone and given another word."""

    share: Array  # (w,) of the images that show each
    parent: Ints  # (w,) the word that each depends on, -1 for a root
    given: Array  # (w, 2) probability of each without its parent, and with it


def learn(shown: Mask) -> Words:
    """Grow the tree of greatest mutual information of words (n, w) by Prim's algorithm."""
    n, w = shown.shape
    z = shown.astype(np.float32)
    share = np.clip(z.mean(axis=0, dtype=float), LEAST_SHARE, 1 - LEAST_SHARE)
    best, parent, inside = np.full(w, -np.inf), np.full(w, -1), np.zeros(w, bool)
    new = 0
    for _ in range(w - 1):
        inside[new] = True
        gain = _mutual_information(z.T @ z[:, new], z[:, new].sum(), z.sum(axis=0), n)
        better = ~inside & (gain > best)
        best[better], parent[better] = gain[better], new
        new = int(np.where(inside, -np.inf, best).argmax())
    root = np.maximum(parent, 0)
    both = np.einsum("nw,nw->w", z, z[:, root], dtype=float)
    parents = z[:, root].sum(axis=0, dtype=float)
    alone = z.sum(axis=0, dtype=float) - both
    # One image more that shows both as often as all do: a word never seen with its parent is not
    # impossible.
    given = np.stack([(alone + share) / (n - parents + 1), (both + share) / (parents + 1)], axis=1)
    return Words(share=share, parent=parent, given=np.clip(given, LEAST_SHARE, 1 - LEAST_SHARE))


def _mutual_information(both: Array, one: float, other: Array, n: int) -> Array:
    """Return the mutual information (w,) of one word with each other, from how many of n images
    show them.
    """
    out = np.zeros(len(other))
    for joint, a, b in (
        (both, one, other),
        (one - both, one, n - other),
        (other - both, n - one, other),
        (n - one - other + both, n - one, n - other),
    ):
        with np.errstate(divide="ignore", invalid="ignore"):
            out += np.where(joint > 0, joint / n * np.log(joint * n / (a * b)), 0.0)
    return out


def log_likelihoods(
    words: Words, shown: Mask, queries: Sequence[int] | Ints, tree: bool = True
) -> Array:
    """Return the log likelihood (q, n) of what each query shows, were it taken where each image
    was; in column n that of a new place (mean field). shown (n, w).
    """
    places = shown.astype(np.float32)
    out = np.empty((len(queries), len(shown) + 1))
    for row, query in enumerate(queries):
        z = shown[query].astype(int)
        with_parent = z[np.maximum(words.parent, 0)]
        without, with_word, new = (
            np.log(_observed(words, z, with_parent, there, tree))
            for there in (*_there(words.share), words.share)
        )
        out[row, :-1] = without.sum() + places @ (with_word - without)
        out[row, -1] = new.sum()
    return out


def _there(share: Array) -> tuple[Array, Array]:
    """Compute the probability (w,) that a word is at a place, given whether its image shows it.

    Returns the one for images without the word, and the one for images with it.
    """
    missed, seen = (1 - SEEN_IF_THERE) * share, SEEN_IF_THERE * share
    return missed / (missed + (1 - SEEN_IF_NOT) * (1 - share)), seen / (
        seen + SEEN_IF_NOT * (1 - share)
    )


def _observed(words: Words, z: Ints, z_parent: Ints, there: Array, tree: bool) -> Array:
    """Return the probability (w,) of what is observed of each word, given how probably it is there,
    and its parent.
    """
    out = np.zeros(len(z))
    own = np.where(z, words.share, 1 - words.share)
    given = np.take_along_axis(words.given, z_parent[:, None], axis=1)[:, 0]
    given = np.where(z, given, 1 - given)
    for exists, probability in ((SEEN_IF_THERE, there), (SEEN_IF_NOT, 1 - there)):
        seen = np.where(z, exists, 1 - exists)
        if tree:
            # P(z | e, z_parent) from P(z | e), P(z | z_parent) and P(z), the word's being there
            # apart from its parent
            same, opposite = (1 - own) * seen * given, own * (1 - seen) * (1 - given)
            seen = np.where(words.parent < 0, seen, same / np.maximum(same + opposite, 1e-300))
        out += probability * seen
    return np.maximum(out, 1e-12)
