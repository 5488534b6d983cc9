# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The structure of cloud-optimised GeoTIFFs, and their values as GDAL reads them."""

from __future__ import annotations

import tracemalloc
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import rasterio
import tifffile
from numpy.typing import NDArray

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.output import cog
from hullrecon.mosaic.output.cog import halve
from hullrecon.mosaic.output.raster import RasterBands, RasterLayout, write_raster
from hullrecon.mosaic.output.tile_store import CompressedTiles

GRAY = RasterBands(names=("intensity", "alpha"), unit="", dtype="uint8", title="sonar")
COLOR = RasterBands(names=("red", "green", "blue", "alpha"), unit="", dtype="uint8", title="seen")
COUNT = RasterBands(names=("support",), unit="", dtype="uint16", title="support", nodata=0)
METRE = RasterBands(names=("form",), unit="m", dtype="float32", title="form", nodata=float("nan"))


def whole(bands: RasterBands, height: int, width: int) -> NDArray[np.generic]:
    """Make a picture of noise, whose last band, alpha, is 0 or 255, and metres have NaN."""
    rng = np.random.default_rng(4)
    picture = rng.integers(0, 60_000, (height, width, len(bands.names))).astype(bands.dtype)
    if bands.names[-1] == "alpha":
        picture[..., -1] = np.where(rng.random((height, width)) < 0.3, 0, 255)
    if bands is METRE:
        picture[: height // 3] = np.nan
        picture[height // 3 :] *= 1e-3
    return picture


def write(
    path: Path, picture: NDArray[np.generic], bands: RasterBands, size: int, signs: tuple[int, int]
) -> None:
    height, width = picture.shape[:2]
    grid = TexelGrid(30.0, 6.0, 0.01, height, width)
    scratch = BytesIO()
    tiles = CompressedTiles((size, size, picture.shape[2]), bands.dtype, scratch)
    padded = np.pad(picture, ((0, size), (0, size), (0, 0)))
    for window in grid.tiles(size):
        tiles.add(padded[window.top : window.bottom, window.left : window.right])
    outside = OutsideMap(x_sign=signs[0], y_sign=signs[1], frame="M")
    write_raster(path, tiles, RasterLayout(grid=grid, size=size, outside=outside), bands, scratch)


@pytest.mark.parametrize("bands", [GRAY, COLOR, COUNT, METRE], ids=lambda bands: bands.names[0])
@pytest.mark.parametrize(("size", "signs"), [(512, (1, 1)), (96, (-1, -1))])
def test_gdal_reads_what_was_written(
    bands: RasterBands, size: int, signs: tuple[int, int], tmp_path: Path
) -> None:
    picture = whole(bands, 700, 1100)
    write(tmp_path / "a.tif", picture, bands, size, signs)
    with rasterio.open(tmp_path / "a.tif") as file:
        read = np.moveaxis(file.read(), 0, 2)
    np.testing.assert_array_equal(read, picture[:: signs[1], :: signs[0]])


@pytest.mark.parametrize("classic_bytes", [cog.CLASSIC_BYTES, 0], ids=["classic", "big"])
def test_directories_come_first_then_overviews(
    classic_bytes: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cog, "CLASSIC_BYTES", classic_bytes)
    write(tmp_path / "a.tif", whole(COLOR, 700, 1100), COLOR, 512, (1, 1))
    data = (tmp_path / "a.tif").read_bytes()
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert file.is_bigtiff == (classic_bytes == 0)
        shapes = [page.shape[:2] for page in file.pages]
        assert shapes == [(700, 1100), (350, 550), (175, 275), (88, 138)]
        assert [page.tags["NewSubfileType"].value for page in file.pages] == [0, 1, 1, 1]
        directories = [page.offset for page in file.pages]
        assert directories == sorted(directories)
        blocks = [offset for page in reversed(file.pages) for offset in page.dataoffsets]
        assert blocks == sorted(blocks)
        assert directories[-1] < blocks[0]
        for page in file.pages:
            assert page.is_tiled
            for offset, count in zip(page.dataoffsets, page.databytecounts, strict=True):
                assert int.from_bytes(data[offset - 4 : offset], "little") == count
                last = data[offset + count - 4 : offset + count]
                assert data[offset + count : offset + count + 4] == last
    head = data[8:] if classic_bytes else data[16:]
    assert head.startswith(b"GDAL_STRUCTURAL_METADATA_SIZE=")
    length = int(head[30:36])
    assert head[43 : 43 + length].endswith(b"KNOWN_INCOMPATIBLE_EDITION=NO\n ")


def test_a_raster_smaller_than_a_block_has_an_overview(tmp_path: Path) -> None:
    write(tmp_path / "a.tif", whole(GRAY, 285, 463), GRAY, 512, (-1, 1))
    with rasterio.open(tmp_path / "a.tif") as file:
        assert file.overviews(1) == [2]


def test_what_was_not_seen_is_left_out_of_averages() -> None:
    color = np.zeros((2, 2, 2), np.uint8)
    color[0] = [[100, 255], [200, 255]]
    np.testing.assert_array_equal(halve(color, None), [[[150, 128]]])
    np.testing.assert_array_equal(halve(np.array([[[3], [0]], [[0], [0]]], np.uint8), 0), [[[3]]])
    metres = np.array([[[np.nan], [1.0]], [[2.0], [np.nan]]], np.float32)
    np.testing.assert_array_equal(halve(metres, float("nan")), [[[1.5]]])
    assert np.isnan(halve(np.full((2, 2, 1), np.nan, np.float32), float("nan"))).all()


def test_memory_does_not_grow_with_the_raster(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # of two threads one may be at its peak while the other is, or not
    monkeypatch.setattr("hullrecon.threads.MAX_AT_A_TIME", 1)
    peaks = []
    for rows in (1024, 6 * 1024):
        grid = TexelGrid(0.0, 0.0, 0.01, rows, 1024)
        layout = RasterLayout(
            grid=grid, size=512, outside=OutsideMap(x_sign=1, y_sign=-1, frame="M")
        )
        with (tmp_path / "scratch").open("w+b") as scratch:
            tiles = CompressedTiles((512, 512, 4), "uint8", scratch)
            noise = np.random.default_rng(1).integers(0, 255, (512, 512, 4)).astype(np.uint8)
            for _ in grid.tiles(512):
                tiles.add(noise)
            write_raster(tmp_path / "warm.tif", tiles, layout, COLOR, scratch)  # imports
            tracemalloc.start()
            write_raster(tmp_path / "a.tif", tiles, layout, COLOR, scratch)
            peaks.append(tracemalloc.get_traced_memory()[1])
            tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0]
