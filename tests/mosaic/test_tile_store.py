# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import tifffile

from hullrecon.mosaic.blend import Tile
from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.output.raster import write_raster
from hullrecon.mosaic.output.tile_store import TileStore, make_tiles

GRID = TexelGrid(west=30.0, north=6.0, step_m=0.01, height=100, width=150)


def ramp(window: Window) -> Tile:
    """Gray grows along; the left third was not seen; the variance is the row."""
    rows, columns = np.mgrid[window.top : window.bottom, window.left : window.right]
    value = np.repeat(columns[..., None] % 250, 3, axis=2).astype(np.float32)
    views = np.where(columns < 50, 0, 2).astype(np.uint8)
    return Tile(value=value, variance=rows.astype(np.float32), views=views)


@pytest.fixture
def store() -> TileStore:
    return make_tiles(GRID, 3, 64, 80, ramp, lambda tiles: tiles)


def test_the_small_copy_is_reduced_until_it_fits_and_keeps_the_mean(store: TileStore) -> None:
    assert store.reduction == 2
    assert store.small.shape == (50, 75, 4)
    np.testing.assert_array_equal(store.small[10, 40, :3], 80)  # columns 80 and 81 mean 80.5, rounded to even
    assert store.small[10, 20, 3] == 0
    assert store.small[10, 30, 3] == 255


def test_the_small_copy_is_reduced_by_what_divides_a_tile() -> None:
    store = make_tiles(GRID, 3, 80, 4, ramp, lambda tiles: tiles)
    assert store.reduction == 16
    assert store.small.shape == (7, 10, 4)


def test_views_are_counted_inside_the_raster_only(store: TileStore) -> None:
    np.testing.assert_array_equal(store.views, [5000, 0, 10000, 0, 0])


def test_variance_percentiles_are_those_of_the_texels(store: TileStore) -> None:
    low, high = store.variance_percentiles((50, 99))
    assert low == pytest.approx(63.5, abs=1)  # tiles stick out to row 127, rows are even
    assert high == pytest.approx(126, abs=2)


def test_the_raster_carries_colours_alpha_metres_and_origin(store: TileStore, tmp_path: Path) -> None:
    path = tmp_path / "ortho.tif"
    write_raster(path, store.color_tiles(), GRID, 64, 4, "uint8", "M")
    with tifffile.TiffFile(path) as file:
        page = file.pages[0]
        picture = page.asarray()
        said = json.loads(page.tags["ImageDescription"].value)
        assert page.tags[33550].value == pytest.approx((0.01, 0.01, 0.0))
        assert page.tags[33922].value == pytest.approx((0, 0, 0, 30.0, 6.0, 0))
        assert page.tags["XResolution"].value == (1, 1)  # one pixel a centimetre
    assert picture.shape == (100, 150, 4)
    np.testing.assert_array_equal(picture[7, 120], [120, 120, 120, 255])
    np.testing.assert_array_equal(picture[7, 20], [0, 0, 0, 0])
    assert said["chart_frame"] == "M"
    assert said["metres_per_pixel"] == 0.01


def test_the_variance_raster_is_nan_where_nothing_was_seen(store: TileStore, tmp_path: Path) -> None:
    path = tmp_path / "variance.tif"
    write_raster(path, store.variance_tiles(), GRID, 64, 1, "float32", "g")
    picture = tifffile.imread(path)
    assert np.isnan(picture[3, 10])
    assert picture[33, 100] == 33


def test_the_same_tiles_give_the_same_bytes(store: TileStore, tmp_path: Path) -> None:
    for name in ("one", "two"):
        write_raster(tmp_path / name, store.color_tiles(), GRID, 64, 4, "uint8", "M")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
