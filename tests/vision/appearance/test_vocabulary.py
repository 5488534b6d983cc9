# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Words of descriptors that lie in known heaps."""

from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon.vision.appearance.recognition import learn_words
from hullrecon.vision.appearance.vocabulary import learn_vocabulary
from hullrecon.vision.features.extraction import no_features, root_sift
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import NodeFeatures


def heaps(count, each, seed=3):
    """count heaps of `each` descriptors; and the heap of each."""
    rng = np.random.default_rng(seed)
    middle = root_sift(rng.gamma(0.4, 1.0, (count, 128)).astype(np.float32)).astype(int)
    heap = rng.permutation(np.repeat(np.arange(count), each))
    noisy = middle[heap] + rng.integers(-3, 4, (count * each, 128))
    return np.clip(noisy, 0, 255).astype(np.uint8), heap


def test_each_cluster_of_descriptors_is_one_word():
    descriptors, heap = heaps(6, 50)
    vocabulary = learn_vocabulary(descriptors, seed=1, branches=24)
    coarse_of = (
        np.abs(vocabulary.coarse[:, None].astype(int) - descriptors.astype(int)).sum(2).argmin(0)
    )
    words = vocabulary.words(descriptors)
    assert all(len(set(heap[words == w])) == 1 for w in np.unique(words))
    assert len(set(coarse_of)) >= 6


def test_word_is_nearest_of_its_branch():
    descriptors, _ = heaps(40, 30)
    vocabulary = learn_vocabulary(descriptors, seed=1, branches=6)
    words = vocabulary.words(descriptors)
    squared = ((descriptors[:, None].astype(int) - vocabulary.coarse[None].astype(int)) ** 2).sum(2)
    for row in range(0, len(descriptors), 37):
        first, last = vocabulary.start[squared[row].argmin() :][:2]
        gap = ((descriptors[row].astype(int) - vocabulary.fine[first:last].astype(int)) ** 2).sum(1)
        assert words[row] == first + gap.argmin()


def test_words_are_same_for_same_sample_and_seed_in_any_blocks(monkeypatch):
    descriptors, _ = heaps(20, 40)
    one = learn_vocabulary(descriptors, seed=5, branches=8)
    monkeypatch.setattr("hullrecon.vision.appearance.vocabulary.BLOCK", 7)
    other = learn_vocabulary(descriptors, seed=5, branches=8)
    np.testing.assert_array_equal(one.fine, other.fine)
    np.testing.assert_array_equal(one.words(descriptors), other.words(descriptors))
    assert not np.array_equal(one.fine, learn_vocabulary(descriptors, seed=6, branches=8).fine)


def test_centres_are_rounded_means_of_their_members():
    descriptors, _ = heaps(5, 60)
    vocabulary = learn_vocabulary(descriptors, seed=2, branches=5)
    squared = ((descriptors[:, None].astype(int) - vocabulary.coarse[None].astype(int)) ** 2).sum(2)
    label = squared.argmin(1)
    for k, centre in enumerate(vocabulary.coarse):
        np.testing.assert_allclose(centre, descriptors[label == k].mean(0), atol=0.51)


def test_few_descriptors_make_few_words_and_none_are_refused():
    descriptors, _ = heaps(3, 1)
    assert len(learn_vocabulary(descriptors, seed=1)) == 3
    alike = np.full((9, 128), 40, np.uint8)
    assert set(learn_vocabulary(alike, seed=1).words(alike)) == {0}
    with pytest.raises(ValueError, match="descriptors"):
        learn_vocabulary(descriptors[:0], seed=1)


def test_products_are_whole_numbers_that_float32_holds():
    brightest = np.zeros((2, 128), np.uint8)
    brightest[:, :4] = 255  # the longest that a descriptor of 512 can be
    words = learn_vocabulary(brightest, seed=1)
    assert int((words.fine.astype(int) ** 2).sum(1).max()) * 2 < 2**24


def test_words_of_images_depend_on_the_seed(look):
    node = look([0] * 6)

    def words(seed):
        worker = SimpleNamespace(
            read=lambda at: NodeFeatures(top=node.top, bottom=no_features()),
            options=MatchOptions(seed=seed),
        )
        return learn_words(worker, [SimpleNamespace(image=0, stereo=no_matches())])[0].fine

    np.testing.assert_array_equal(words(1), words(1))
    assert not np.array_equal(words(1), words(2))
