# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from hullrecon.vision.features.extraction import local_saliency, root_sift


def varied(n, seed=0):
    return root_sift(np.random.default_rng(seed).gamma(0.4, 1.0, (n, 128)).astype(np.float32))


def test_image_without_or_with_repeated_features_is_not_salient():
    assert local_saliency(np.zeros((0, 128), np.uint8)) == 0.0
    assert local_saliency(np.repeat(varied(1), 300, axis=0)) == 0.0


def test_two_words_in_equal_parts_are_one_bit_of_eight():
    first, second = varied(2, seed=3)
    pair = np.vstack([np.repeat([first], 50, axis=0), np.repeat([second], 50, axis=0)])
    assert local_saliency(pair) == 1 / 8


def test_varied_texture_scores_high_and_few_features_low():
    assert local_saliency(varied(3000)) > 0.9
    assert local_saliency(varied(8)) < 0.4


def test_score_does_not_depend_on_order():
    some = varied(200)
    assert local_saliency(some) == local_saliency(some[::-1])
