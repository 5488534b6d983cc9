# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.objects.regions import (
    TOP_M2,
    find_regions,
    height_sigma,
    p_value,
    roughness,
    unresolved_relief,
)
from hullrecon.detection.options import DetectOptions


def test_one_place_gives_the_two_sided_normal_probability() -> None:
    assert p_value(1.96, 1.0, 0.0, 1) == pytest.approx(0.05, rel=1e-3)
    assert p_value(-1.96, 0.6, 0.8, 1) == pytest.approx(0.05, rel=1e-3)


def test_p_value_grows_with_places_looked_at() -> None:
    assert p_value(3.0, 1.0, 0.0, 1000) == pytest.approx(1 - (1 - 0.0026998) ** 1000, rel=1e-3)
    assert p_value(20.0, 1.0, 0.0, 1e6) < 1e-80


def test_no_height_is_no_surprise() -> None:
    assert p_value(0.0, 1.0, 0.0, 5) == pytest.approx(1.0)


def test_the_roughness_is_that_of_the_hull_not_of_its_structures(found) -> None:
    assert 0.0003 < roughness(found) < 0.003


def test_a_height_is_as_certain_as_its_landmarks(found) -> None:
    for region in find_regions(found, DetectOptions())[:2]:
        assert 0.0005 < height_sigma(found, region) < 0.006
        assert np.abs(abs(region.height) - (0.10 if region.sign > 0 else 0.05)) < 3 * height_sigma(
            found, region
        )


def test_relief_is_scatter_beyond_landmark_noise() -> None:
    random = np.random.default_rng(2)
    noise, relief = random.normal(0, 0.003, 4000), random.normal(0, 0.004, 4000)
    sigma = np.full(4000, 0.003)
    assert unresolved_relief(noise, sigma) < 0.001
    assert unresolved_relief(noise + relief, sigma) == pytest.approx(0.004, rel=0.1)
    assert unresolved_relief(np.zeros(0), np.zeros(0)) == 0.0


def test_places_do_not_depend_on_object_size() -> None:
    """The places are those that the survey holds: every top of 8 cm2 of 8 m2."""
    assert p_value(5.0, 1.0, 0.0, 8 / TOP_M2) == pytest.approx(10_000 * 5.733e-7, rel=1e-2)
    assert p_value(5.0, 1.0, 0.0, 800 / TOP_M2) > 0.4


def test_false_alarm_rate_of_bare_hull_equals_p_value() -> None:
    """Of a thousand surveys of bare hull with 200 places each as many exceed a height as its
    probability says.
    """
    highest = np.abs(np.random.default_rng(4).normal(0, 0.003, (1000, 200))).max(axis=1)
    for height in (0.009, 0.0105):
        assert np.mean(highest > height) == pytest.approx(
            p_value(height, 0.0, 0.003, 200), abs=0.04
        )
