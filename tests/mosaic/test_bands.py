# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.mosaic.blend import STEEPNESS, band_weight, split_bands


def test_the_bands_sum_to_the_picture() -> None:
    picture = np.random.default_rng(1).uniform(0, 255, (61, 83, 3)).astype(np.float32)
    np.testing.assert_allclose(sum(split_bands(picture)), picture, atol=1e-3)


def test_an_even_picture_is_all_in_the_coarsest_band() -> None:
    low, middle, fine = split_bands(np.full((40, 48, 1), 77, np.float32))
    np.testing.assert_allclose(low, 77, atol=1e-3)
    np.testing.assert_allclose(middle, 0, atol=1e-3)
    np.testing.assert_allclose(fine, 0, atol=1e-3)


def test_a_single_bright_pixel_shows_in_the_finest_band() -> None:
    picture = np.zeros((41, 41, 1), np.float32)
    picture[20, 20] = 200
    assert split_bands(picture)[2][20, 20, 0] > 180


def test_the_weight_is_one_half_at_the_best_place() -> None:
    for k in STEEPNESS:
        np.testing.assert_allclose(band_weight(np.array([0.0]), k), 0.5)


def test_the_weight_is_that_of_the_formula() -> None:
    np.testing.assert_allclose(
        band_weight(np.array([0.2]), 5.0), np.exp(-1) / (1 + np.exp(-2)), rtol=1e-6
    )
    np.testing.assert_allclose(
        band_weight(np.array([0.1]), 50.0), np.exp(-5) / (1 + np.exp(-10)), rtol=1e-6
    )


def test_a_texel_that_the_view_does_not_hold_weighs_nothing() -> None:
    assert band_weight(np.array([np.nan]), 10.0)[0] == 0
