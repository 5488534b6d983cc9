# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""An address says no more than is known."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.charts.address import AddressSigma, address, frame_words, side_of
from hullrecon.geometry.charts.plane_chart import PlaneChart

PLANE = PlaneChart(np.zeros(3), np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, -1]]))


@pytest.mark.parametrize(
    ("sigma", "words"),
    [
        (None, "frame 62.5"),
        (0.01, "frame 62.5"),
        (0.14, "frame 62"),
        (0.33, "frames 62 to 63"),
        (1.2, "frames 60 to 64"),
    ],
)
def test_a_frame_is_a_number_or_the_range_that_one_sigma_leaves(
    sigma: float | None, words: str
) -> None:
    assert frame_words(37.47, 0.6, sigma) == words


def test_a_side_that_is_not_told_from_the_keel_is_the_keel() -> None:
    assert [side_of(0.2, 0.1), side_of(-0.2, 0.1), side_of(0.2, 0.3), side_of(0.001)] == [
        "port",
        "starboard",
        "keel",
        "keel",
    ]


def test_digits_stop_where_the_sigma_begins() -> None:
    (words,) = address(
        PLANE,
        [1.2345, 2.3456, 0.0],
        None,
        [1.234],
        AddressSigma(along=0.04, girth=0.3, depth=0.001),
    )
    assert words == "1.23 ± 0.04 m along, 2.3 ± 0.3 m across, 1.2 m below waterline"


def test_an_unknown_sigma_adds_no_words() -> None:
    lost = AddressSigma(along=float("nan"), girth=float("nan"), depth=float("nan"))
    assert (
        address(PLANE, [1.0, 2.0, 0.0], sigma=lost)
        == address(PLANE, [1.0, 2.0, 0.0])
        == ["1.00 m along, 2.00 m across"]
    )
