# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.mosaic_surface import (
    MosaicSurface,
    find_unobstructed,
    find_visible,
    sample_surface,
)

GRID = TexelGrid(west=-1.2, north=1.2, step_m=0.02, height=120, width=120)


def test_texels_lie_on_the_surface_at_their_chart_coordinates(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    patch = sample_surface(flat_surface(), GRID, Window(20, 90, 15, 100))
    want = GRID.centers(np.arange(20.0, 90.0), np.arange(15.0, 100.0))
    np.testing.assert_allclose(patch.point[..., :2], want, atol=1e-6)
    np.testing.assert_allclose(patch.point[..., 2], 0, atol=1e-6)


def test_texels_beyond_the_surface_are_not_known(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    patch = sample_surface(flat_surface(), GRID, GRID.whole)
    known = np.isfinite(patch.point[..., 0])
    assert not known[:9].any()
    assert known[11:109, 11:109].all()


def test_the_top_of_a_block_is_what_is_seen(flat_surface: Callable[..., MosaicSurface]) -> None:
    patch = sample_surface(flat_surface(([-0.2, -0.2, 0.0], [0.2, 0.2, 0.15])), GRID, GRID.whole)
    np.testing.assert_allclose(patch.point[60, 60, 2], 0.15, atol=1e-6)
    np.testing.assert_allclose(patch.point[60, 75, 2], 0.0, atol=1e-6)


def test_without_a_skyline_every_texel_of_every_view_is_checked(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    assert (sample_surface(flat_surface(), GRID, GRID.whole).free_below == 0).all()


def test_block_hides_view_as_far_as_its_shadow(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    surface = flat_surface(([-0.9, -0.2, 0.0], [-0.7, 0.2, 0.15])).with_occlusion_horizon(GRID, 3.0)
    patch = sample_surface(surface, GRID, GRID.whole)
    # over the block's far upper edge the line reaches the plate 0.6 m behind that edge
    sensor = np.array([-1.3, 0.0, 0.3])
    row, columns = 60, np.arange(46, 108)
    free, cosine = find_visible(surface, patch, row * 120 + columns, sensor, 0.05)
    x = GRID.west + (columns + 0.5) * GRID.step_m
    np.testing.assert_allclose(cosine, 0.3 / np.hypot(np.hypot(x + 1.3, 0.01), 0.3), atol=1e-6)
    # rays start 4 mm off the plate, which is 1.6 cm of shadow
    np.testing.assert_array_equal(free, x > -0.1 - 0.02)


def test_a_block_in_the_next_tile_hides_as_well(flat_surface: Callable[..., MosaicSurface]) -> None:
    surface = flat_surface(([-0.9, -0.2, 0.0], [-0.7, 0.2, 0.15])).with_occlusion_horizon(GRID, 3.0)
    tile = Window(40, 80, 40, 80)  # from x = -0.4 on
    patch = sample_surface(surface, GRID, tile)
    # x = -0.29 and 0.21
    free, _ = find_visible(
        surface, patch, 20 * 40 + np.array([5, 30]), np.array([-1.3, 0.0, 0.3]), 0.05
    )
    np.testing.assert_array_equal(free, [False, True])


def test_texels_outside_the_grid_are_not_known(flat_surface: Callable[..., MosaicSurface]) -> None:
    small = TexelGrid(west=-0.5, north=0.5, step_m=0.02, height=30, width=20)
    patch = sample_surface(flat_surface(), small, Window(0, 64, 0, 64))
    known = np.isfinite(patch.point[..., 0])
    assert known[:30, :20].all()
    assert known.sum() == 600


def test_a_texel_that_turns_away_is_not_seen(flat_surface: Callable[..., MosaicSurface]) -> None:
    patch = sample_surface(flat_surface(), GRID, GRID.whole)
    rows = np.array([60 * 120 + 60])
    assert find_visible(flat_surface(), patch, rows, np.array([0.0, 0.0, 1.0]), 0.2)[0][0]
    assert not find_visible(flat_surface(), patch, rows, np.array([0.0, 0.0, -1.0]), 0.2)[0][0]
    assert not find_visible(flat_surface(), patch, rows, np.array([6.0, 0.0, 1.0]), 0.2)[0][0]


def test_a_block_stands_in_the_line_of_a_slanted_view(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    surface = flat_surface(([-0.2, -0.2, 0.0], [0.2, 0.2, 0.15]))
    points = np.array([[0.25, 0.0, 0.0], [0.8, 0.0, 0.0]])
    normals = np.tile([0.0, 0.0, 1.0], (2, 1))
    np.testing.assert_array_equal(
        find_unobstructed(surface, points, normals, np.array([-1.0, 0.0, 1.0])), [False, True]
    )
    np.testing.assert_array_equal(
        find_unobstructed(surface, points, normals, np.array([0.25, 0.0, 1.0])), [True, True]
    )
