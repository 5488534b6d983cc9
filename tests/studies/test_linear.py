# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.studies.surfaces.linear import interpolate, scatter_sigma

CORNERS = np.array([[0.0, 0], [1, 0], [0, 1], [1, 1], [0.4, 0.6]])


def test_a_plane_is_reproduced_inside() -> None:
    values = 2 + 3 * CORNERS[:, 0] - CORNERS[:, 1]
    wanted = np.array([[0.2, 0.3], [0.9, 0.95]])
    assert np.allclose(interpolate(CORNERS, values, wanted), 2 + 3 * wanted[:, 0] - wanted[:, 1])


def test_outside_the_nearest_value_holds() -> None:
    assert interpolate(CORNERS, np.arange(5.0), np.array([[5.0, 0.1]])).tolist() == [1.0]


def test_returns_on_one_line_still_give_a_value() -> None:
    line = np.array([[0.0, 0], [1, 0], [2, 0], [3, 0], [4, 0]])
    assert interpolate(line, np.arange(5.0), np.array([[2.2, 0.3]])).tolist() == [2.0]


def test_the_scatter_is_that_of_the_noise(rng: np.random.Generator) -> None:
    at = rng.uniform(0, 5, (2000, 2))
    values = 0.02 * at[:, 0] + rng.normal(0, 0.01, 2000)
    assert abs(scatter_sigma(at, values) / 0.01 - 1) < 0.1
    assert scatter_sigma(at[:1], values[:1]) == 0.0
