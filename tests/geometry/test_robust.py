# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hullrecon.geometry.robust import (
    median_of_known,
    robust_sigma,
    robust_sigma_of_blocks,
    weighted_quantile,
)

NORMAL = np.random.default_rng(1).normal(5.0, 0.2, 20_000)


def test_of_normal_values_it_is_their_sigma() -> None:
    assert robust_sigma(NORMAL) == pytest.approx(0.2, rel=0.03)


def test_a_few_wild_values_hardly_move_it() -> None:
    wild = np.where(np.arange(len(NORMAL)) % 10 == 0, 1e6, NORMAL)
    assert robust_sigma(wild) == pytest.approx(0.2, rel=0.2)


def test_about_a_middle_that_is_known_a_common_offset_counts() -> None:
    assert robust_sigma(np.array([3.0, 3.0, 3.0])) == 0.0
    assert robust_sigma(np.array([3.0, -3.0, 3.0]), about=0.0) == pytest.approx(3 * 1.4826)


def test_of_nothing_it_is_unknown() -> None:
    assert np.isnan(robust_sigma(np.zeros(0)))


VALUES = st.lists(st.integers(-(10**6), 10**6), min_size=1, max_size=40)


@given(VALUES, st.integers(-1000, 1000), st.integers(1, 50))
def test_it_scales_with_the_values_and_does_not_see_their_level(
    values: list[int], shift: int, factor: int
) -> None:
    plain = robust_sigma(np.array(values, float))
    assert robust_sigma(factor * np.array(values, float) + shift) == pytest.approx(factor * plain)
    assert robust_sigma(-np.array(values, float)) == pytest.approx(plain)


@given(st.integers(0, 10**6), st.integers(0, 24), st.floats(1e3, 1e12))
def test_nearly_half_of_the_values_may_be_as_wild_as_they_like(
    seed: int, wild: int, size: float
) -> None:
    values = np.random.default_rng(seed).uniform(-1, 1, 50)
    values[:wild] = size
    assert robust_sigma(values) <= 2 * 1.4826  # two tame values are never farther apart


@given(VALUES)
def test_about_their_median_is_what_it_does_by_itself(values: list[int]) -> None:
    array = np.array(values, float)
    assert robust_sigma(array, about=float(np.median(array))) == robust_sigma(array)


@given(st.lists(VALUES, min_size=1, max_size=6))
def test_of_blocks_it_is_that_of_all_values_together(values: list[list[int]]) -> None:
    blocks = [np.array(block, float) for block in values]
    assert robust_sigma_of_blocks(lambda: blocks) == robust_sigma(np.concatenate(blocks))


@pytest.mark.parametrize("width", [1, 4, 5, 700])
def test_medians_of_known_values_are_those_of_numpy(width: int) -> None:
    rng = np.random.default_rng(4)
    values = rng.standard_normal((6, 50, width))
    values[rng.random(values.shape) < 0.4] = np.nan
    values[0, 0] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # numpy's of a row without a value
        expected = np.nanmedian(values, axis=-1)
    np.testing.assert_array_equal(median_of_known(values), expected)


def test_the_quantile_counts_area() -> None:
    values, weight = np.array([3.0, 1.0, 2.0]), np.array([1.0, 8.0, 1.0])
    assert weighted_quantile(values, weight, 0.5) == 1.0
    assert weighted_quantile(values, weight, 0.85) == 2.0
    assert weighted_quantile(values, weight, 1.0) == 3.0
