# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Scores of images whose words are written out by hand."""

import numpy as np

from hullrecon.vision.appearance.vocabulary import invert


def scores(*words, size=8):
    file = invert([np.array(w, np.int64) for w in words], size)
    return file.scores(np.arange(len(words)))


def test_weights_are_term_times_inverse_document_frequency():
    """Word 0 in all images says nothing; word 1 in two of three, word 2 in one."""
    found = scores([0, 1, 1], [0, 1, 2], [0, 0])
    one, both = np.log(3), np.log(1.5)
    expected = both / np.hypot(both, one)  # (1) against (1, 2), each of unit length
    np.testing.assert_allclose(found[0, 1], expected)
    np.testing.assert_allclose(found[[0, 1], [0, 1]], 1.0)
    np.testing.assert_allclose(found[2], 0.0)


def test_scores_are_symmetric_and_not_negative():
    rng = np.random.default_rng(2)
    found = scores(*(rng.integers(0, 50, 80) for _ in range(12)), size=50)
    np.testing.assert_allclose(found, found.T, atol=1e-12)
    assert (found >= 0).all()


def test_shared_rare_word_scores_above_shared_frequent_word():
    found = scores([1, 5], [2, 5], [1, 6], [1, 7], [3, 4])
    assert found[0, 1] > found[0, 2] > found[0, 4] == 0


def test_image_without_features_is_like_none():
    found = scores([], [1, 2], [1, 3], [4])
    np.testing.assert_array_equal(found[0], 0.0)
    assert found[1, 2] > 0


def test_only_images_asked_for_are_scored():
    file = invert([np.array([k, k + 1]) for k in range(6)], 7)
    assert len(file) == 6
    np.testing.assert_allclose(file.scores(np.array([4, 1])), file.scores(np.arange(6))[[4, 1]])
