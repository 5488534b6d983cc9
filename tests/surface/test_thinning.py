# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.surface.tiles import cell_means


def test_points_of_one_cell_become_their_weighted_mean() -> None:
    at = np.array([[0.01, 0.01], [0.05, 0.03], [0.15, 0.01]])
    seen = cell_means(at, np.array([1.0, 2.0, 7.0]), np.array([0.1, 0.2, 0.1]), 0.1)
    assert seen.count.tolist() == [2, 1]
    assert np.allclose(seen.offset, [(4 * 1 + 2) / 5, 7])
    assert np.allclose(seen.at[0], [(4 * 0.01 + 0.05) / 5, (4 * 0.01 + 0.03) / 5])
    assert np.allclose(seen.noise, [1 / np.sqrt(125), 0.1])


def test_cells_on_either_side_of_zero_stay_apart() -> None:
    seen = cell_means(np.array([[-0.01, 0.0], [0.01, 0.0]]), np.array([0.0, 1.0]), np.ones(2), 0.1)
    assert seen.offset.tolist() == [0, 1]


def test_the_information_of_all_returns_is_kept() -> None:
    rng = np.random.default_rng(0)
    noise = rng.uniform(0.01, 0.1, 300)
    seen = cell_means(rng.uniform(-2, 2, (300, 2)), rng.normal(size=300), noise, 0.5)
    assert seen.count.sum() == 300
    assert np.isclose(np.sum(seen.noise**-2), np.sum(noise**-2))
