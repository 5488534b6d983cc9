# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import threading
from io import BytesIO

import numpy as np
import pytest

from hullrecon.mosaic.blend import Tile
from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.output.tile_store import CompressedTiles, TileStore, make_tiles
from hullrecon.threads import in_threads

GRID = TexelGrid(west=30.0, north=6.0, step_m=0.01, height=100, width=150)


def ramp(window: Window) -> Tile:
    """Gray grows along; the left third was not seen; the variance is the row."""
    rows, columns = np.mgrid[window.top : window.bottom, window.left : window.right]
    value = np.repeat(columns[..., None] % 250, 3, axis=2).astype(np.float32)
    views = np.where(columns < 50, 0, 2).astype(np.uint8)
    return Tile(value=value, variance=rows.astype(np.float32), views=views)


@pytest.fixture
def store() -> TileStore:
    return make_tiles(GRID, 3, 64, 80, ramp, in_threads, BytesIO())


def test_small_copy_fits_and_keeps_the_mean(store: TileStore) -> None:
    assert store.reduction == 2
    assert store.small.shape == (50, 75, 4)
    # columns 80 and 81 mean 80.5, rounded to even
    np.testing.assert_array_equal(store.small[10, 40, :3], 80)
    assert store.small[10, 20, 3] == 0
    assert store.small[10, 30, 3] == 255


def test_the_small_copy_is_reduced_by_what_divides_a_tile() -> None:
    store = make_tiles(GRID, 3, 80, 4, ramp, in_threads, BytesIO())
    assert store.reduction == 16
    assert store.small.shape == (7, 10, 4)


def test_views_are_counted_inside_the_raster_only(store: TileStore) -> None:
    np.testing.assert_array_equal(store.views, [5000, 0, 10000, 0, 0])


def test_variance_percentiles_are_those_of_the_texels(store: TileStore) -> None:
    low, high = store.variance_percentiles((50, 99))
    assert low == pytest.approx(63.5, abs=1)  # tiles stick out to row 127, rows are even
    assert high == pytest.approx(126, abs=2)


def test_tiles_come_back_as_they_were_made(store: TileStore) -> None:
    windows = list(GRID.tiles(64))
    made = [ramp(window) for window in windows]
    assert len(store.color) == len(store.variance) == len(store.counts) == len(windows)
    for color, variance, views, tile in zip(
        store.color, store.variance, store.counts, made, strict=True
    ):
        np.testing.assert_array_equal(color[..., 3] > 0, tile.views > 0)
        np.testing.assert_array_equal(variance[tile.views > 0], tile.variance[tile.views > 0])
        assert np.isnan(variance[tile.views == 0]).all()
        np.testing.assert_array_equal(views, tile.views)


def test_a_tile_of_another_shape_is_refused() -> None:
    tiles = CompressedTiles((4, 4), "uint8", BytesIO())
    with pytest.raises(ValueError, match="shape"):
        tiles.add(np.zeros((4, 5), np.uint8))


def test_tiles_are_made_by_all_cores_in_order(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda process: {0, 1, 2})
    together = threading.Barrier(3)

    def make(window: Window) -> Tile:
        together.wait(timeout=30)  # no tile ends before three have begun
        return ramp(window)

    windows = list(GRID.tiles(64))
    made = list(in_threads(make, windows))
    assert len(windows) == 6
    for tile, window in zip(made, windows, strict=True):
        np.testing.assert_array_equal(tile.value, ramp(window).value)


def test_a_tile_that_fails_ends_the_making(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda process: {0})
    begun = []

    def make(window: Window) -> Tile:
        begun.append(window)
        raise ValueError("no picture")

    with pytest.raises(ValueError, match="no picture"):
        list(in_threads(make, list(GRID.tiles(64))))
    assert len(begun) == 1
