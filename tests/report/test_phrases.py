# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.report.content.phrases import (
    count,
    duration,
    error_with_sigma,
    join,
    length,
    lengths,
    probability,
    signed_range,
    with_sigma,
)


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [
        (0.1402, 0.004, "0.140 ± 0.004 m"),
        (0.1402, 0.0012, "0.1402 ± 0.0012 m"),
        (12.3, 0.53, "12.3 ± 0.5 m"),
        (1.0, None, "1.000 m"),
        (float("nan"), 0.1, "–"),
        (-0.04, 0.02, "−0.04 ± 0.02 m"),
    ],
)
def test_a_number_has_no_more_digits_than_its_sigma_deserves(
    value: float, sigma: float | None, text: str
) -> None:
    assert with_sigma(value, sigma, "m") == text


def test_lengths_are_in_the_unit_that_reads_best() -> None:
    assert [length(x) for x in (0.0044, 0.021, 0.53, 12.0, 4661.0, np.nan)] == [
        "4.4 mm",
        "21 mm",
        "0.53 m",
        "12.00 m",
        "4,661 m",
        "–",
    ]


def test_durations_read_as_people_say_them() -> None:
    assert [duration(x) for x in (117.0, 725.0, 10_920.0)] == ["117 s", "12 min 05 s", "3 h 02 min"]


def test_a_tiny_probability_is_a_bound() -> None:
    assert [probability(p) for p in (1e-9, 0.03, None)] == ["< 0.0001", "0.0300", "–"]


def test_one_is_singular_and_more_are_plural() -> None:
    assert [count(1, "object"), count(1200, "object"), count(2, "recess", "recesses")] == [
        "1 object",
        "1,200 objects",
        "2 recesses",
    ]


def test_a_list_ends_with_and() -> None:
    assert [join([]), join(["a"]), join(["a", "b", "c"])] == ["", "a", "a, b and c"]


@pytest.mark.parametrize(
    ("metres", "text"),
    [
        ([0.35, 0.041, 0.098], "0.350 / 0.041 / 0.098 m"),
        ([0.35, 0.41], "0.35 / 0.41 m"),
        ([0.012, 0.035], "12 / 35 mm"),
        ([0.0044, 0.035], "4.4 / 35.0 mm"),
        ([float("nan"), 0.5], "– / 0.50 m"),
    ],
)
def test_a_row_of_lengths_has_one_unit(metres: list[float], text: str) -> None:
    assert lengths(metres) == text


def test_a_range_with_signs_has_minus_signs_and_no_hyphens() -> None:
    assert signed_range(-10.4, 16.0) == "−10 to +16"
    assert signed_range(-0.26, -0.14, 1) == "−0.3 to −0.1"


@pytest.mark.parametrize(
    ("error", "sigma", "text"),
    [(-0.124, 0.03, "−0.12 ± 0.03°"), (0.124, 0.012, "+0.124 ± 0.012°"), (-0.124, 0.0, "−0.12°")],
)
def test_an_error_has_its_sign_and_a_sigma_where_that_is_known(
    error: float, sigma: float, text: str
) -> None:
    assert error_with_sigma(error, sigma, "°") == text
