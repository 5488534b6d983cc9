# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.as_found.landmarks import FieldBackground, median_background
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.records.solution import DeviationField

CHART = PlaneChart(np.array([0.0, 2.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))


def _field(value: np.ndarray) -> FieldBackground:
    origin, step = np.array([1.0, 0.0]), np.array([0.5, 0.25])
    field = DeviationField(origin=origin, step=step, value=value, sigma=0.1 * np.abs(value) + 0.01)
    return FieldBackground(chart=CHART, field=field)


def test_the_field_is_bilinear_between_its_nodes() -> None:
    along, girth = np.meshgrid(np.arange(4), np.arange(3), indexing="ij")
    background = _field(0.01 * along + 0.1 * girth)
    value, _ = background.at(np.array([[1.75, 2.3, 0.3], [1.0, 2, 0], [2.5, 2, 0.5]]))
    assert np.allclose(value, [0.01 * 1.5 + 0.1 * 1.2, 0, 0.03 + 0.2])


def test_outside_the_grid_nothing_is_known() -> None:
    value, sigma = _field(np.array([[0.3, 0.3], [0.3, 0.3]])).at(
        np.array([[9.0, 2, 0], [1.2, 2, 0.1]])
    )
    assert np.allclose(value, [0, 0.3])
    assert np.allclose(sigma, 0.04)


def _wall(rng: np.random.Generator, n: int = 8000) -> np.ndarray:
    return np.column_stack([rng.uniform(0, 4, n), np.zeros(n), rng.uniform(0, 3, n)])


def test_a_structure_smaller_than_half_a_disc_is_not_hull() -> None:
    rng = np.random.default_rng(3)
    feet = _wall(rng)
    offset = 0.02 + rng.normal(0, 0.002, len(feet))
    bump = np.hypot(feet[:, 0] - 2, feet[:, 2] - 1.5) < 0.35
    offset[bump] += 0.1
    value, sigma = median_background(feet, offset, 1.5).at(np.array([[2.0, 0, 1.5], [0.5, 0, 0.5]]))
    assert np.allclose(value, 0.02, atol=0.002)
    assert (sigma < 0.005).all()


def test_a_richly_textured_structure_does_not_outvote_the_hull() -> None:
    rng = np.random.default_rng(4)
    feet = np.vstack(
        [
            _wall(rng, 2000),
            np.column_stack(
                [rng.normal(2, 0.1, 20000), np.zeros(20000), rng.normal(1.5, 0.1, 20000)]
            ),
        ]
    )
    offset = np.where(np.hypot(feet[:, 0] - 2, feet[:, 2] - 1.5) < 0.4, 0.1, 0.0)
    value, _ = median_background(feet, offset, 1.5).at(np.array([[2.0, 0, 1.5]]))
    assert value[0] == pytest.approx(0, abs=0.005)


def test_slow_changes_of_the_hull_are_followed() -> None:
    feet = _wall(np.random.default_rng(5))
    value, _ = median_background(feet, 0.01 * feet[:, 0], 1.0).at(
        np.array([[1.0, 0, 1.5], [3.0, 0, 1.5]])
    )
    assert np.allclose(value, [0.01, 0.03], atol=0.002)
