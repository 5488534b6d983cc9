# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.mosaic.grid import TexelGrid, Window, grid_around


def test_first_texel_is_at_least_along_greatest_girth() -> None:
    grid = TexelGrid(west=10.0, north=5.0, step_m=0.5, height=4, width=6)
    centers = grid.centers(np.arange(4.0), np.arange(6.0))
    np.testing.assert_allclose(centers[0, 0], [10.25, 4.75])
    np.testing.assert_allclose(centers[3, 5], [12.75, 3.25])


def test_a_grid_around_points_starts_on_a_multiple_of_its_step() -> None:
    grid = grid_around(np.array([[1.03, 2.0], [1.97, 2.91], [np.nan, 0.0]]), 0.1)
    assert (grid.width, grid.height) == (10, 10)
    np.testing.assert_allclose([grid.west, grid.north], [1.0, 3.0])


def test_a_grid_around_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="no point"):
        grid_around(np.full((3, 2), np.nan), 0.1)


def test_a_grid_beyond_memory_is_coarser() -> None:
    grid = grid_around(np.array([[0.0, 0.0], [100.0, 50.0]]), 0.001, max_texels=2e6)
    assert grid.step_m == pytest.approx(0.05)
    assert grid.height * grid.width <= 2.02e6
    assert grid.width * grid.step_m == pytest.approx(100.0)


def test_tiles_cover_every_texel_once() -> None:
    grid = TexelGrid(0.0, 0.0, 1.0, height=70, width=130)
    count = np.zeros((70, 130), int)
    for tile in grid.tiles(64):
        inside = tile.meet(grid.whole)
        count[inside.within(grid.whole)] += 1
    assert (count == 1).all()


def test_footprint_window_has_margin_and_ends_at_raster() -> None:
    grid = TexelGrid(west=0.0, north=10.0, step_m=1.0, height=10, width=10)
    window = grid.window_of(np.array([[2.5, 8.5], [4.5, 7.5]]), margin_m=1.0)
    assert window == Window(top=0, bottom=4, left=1, right=6)


def test_a_window_that_misses_the_other_is_empty() -> None:
    assert Window(0, 5, 0, 5).meet(Window(7, 9, 0, 5)).empty
    assert TexelGrid(0.0, 1.0, 0.1, 10, 10).window_of(np.full((2, 2), np.nan), 0.1).empty
