# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""GeoTIFFs as other programs read them: seen from outside, local and metric, with bands, units and
overviews.
"""

from __future__ import annotations

import json
import resource
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import rasterio
import tifffile
from numpy.typing import NDArray
from rasterio.enums import ColorInterp

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.output.raster import RasterBands, RasterLayout, write_raster
from hullrecon.mosaic.output.tile_store import CompressedTiles

GRID = TexelGrid(west=30.0, north=6.0, step_m=0.01, height=1000, width=1500)
COLORS = RasterBands(
    names=("red", "green", "blue", "alpha"), unit="", dtype="uint8", title="Optical mosaic"
)
METRES = RasterBands(
    names=("deviation",), unit="m", dtype="float32", title="deviation", nodata=float("nan")
)
SIGNS = ((-1, 1), (1, -1), (1, 1))


def layout(x_sign: int, y_sign: int) -> RasterLayout:
    return RasterLayout(
        grid=GRID, size=512, outside=OutsideMap(x_sign=x_sign, y_sign=y_sign, frame="M")
    )


def write(path: Path, bands: RasterBands, x_sign: int, y_sign: int) -> None:
    scratch = BytesIO()
    shape = (512, 512, len(bands.names)) if len(bands.names) > 1 else (512, 512)
    stored = CompressedTiles(shape, bands.dtype, scratch)
    for tile in tiles(len(bands.names)):
        stored.add(tile)
    write_raster(path, stored, layout(x_sign, y_sign), bands, scratch)


def tiles(bands: int) -> Iterator[NDArray[np.generic]]:
    """A spot 2 cm wide at along 32.005, girth 4.995 on a field without it; all seen but the first
    metre along.
    """
    for window in GRID.tiles(512):
        rows, columns = np.mgrid[window.top : window.bottom, window.left : window.right]
        value = np.where((np.abs(columns - 200) < 2) & (np.abs(rows - 100) < 2), 200.0, 50.0)
        if bands == 1:
            yield np.where(columns < 100, np.nan, value).astype(np.float32)
        else:
            seen = np.where(columns < 100, 0, 255)[..., None]
            yield np.concatenate(
                [np.repeat(value[..., None], 3, axis=2) * (seen > 0), seen], axis=2
            ).astype(np.uint8)


@pytest.mark.parametrize("signs", SIGNS)
def test_a_spot_lies_where_the_map_says(signs: tuple[int, int], tmp_path: Path) -> None:
    write(tmp_path / "ortho.tif", COLORS, *signs)
    with rasterio.open(tmp_path / "ortho.tif") as file:
        picture = file.read()
        x, y = file.xy(*(round(v) for v in np.argwhere(picture[0] == 200).mean(axis=0)))
    assert (x, y) == pytest.approx((signs[0] * 32.005, signs[1] * 4.995), abs=1e-9)
    assert picture.shape == (4, 1000, 1500)
    seen = np.argwhere(picture[3].any(axis=0))[:, 0]
    assert (seen.min(), seen.max()) == ((0, 1399) if signs[0] < 0 else (100, 1499))


def test_crs_is_local_and_not_in_degrees(tmp_path: Path) -> None:
    write(tmp_path / "ortho.tif", COLORS, -1, 1)
    with rasterio.open(tmp_path / "ortho.tif") as file:
        assert file.crs is not None
        assert not file.crs.is_geographic
        wkt = file.crs.to_wkt()
    assert wkt.startswith("LOCAL_CS")
    assert "seen from outside: x = -along, y = girth" in wkt
    assert 'UNIT["metre",1' in wkt


def test_bands_have_names_units_and_overviews(tmp_path: Path) -> None:
    write(tmp_path / "ortho.tif", COLORS, -1, 1)
    write(tmp_path / "deviation.tif", METRES, -1, 1)
    with rasterio.open(tmp_path / "ortho.tif") as file:
        assert file.descriptions == ("red", "green", "blue", "alpha")
        assert file.colorinterp == (
            ColorInterp.red,
            ColorInterp.green,
            ColorInterp.blue,
            ColorInterp.alpha,
        )
        assert file.overviews(1) == [2, 4, 8]
        assert file.tags(ns="IMAGE_STRUCTURE")["LAYOUT"] == "COG"
        small = file.read(1, out_shape=(500, 750))
        mask = file.read(4, out_shape=(500, 750))
    assert (small[mask == 255] >= 50).all()  # what was not seen darkens no overview
    with rasterio.open(tmp_path / "deviation.tif") as file:
        assert (file.descriptions, file.units, file.dtypes) == (
            ("deviation",),
            ("m",),
            ("float32",),
        )
        assert np.isnan(file.nodata)
        values = file.read(1)
    assert np.isnan(values).sum() == 100 * 1000


def test_the_description_gives_the_chart_without_the_map(tmp_path: Path) -> None:
    write(tmp_path / "ortho.tif", COLORS, -1, 1)
    with tifffile.TiffFile(tmp_path / "ortho.tif") as file:
        said = json.loads(file.pages[0].tags["ImageDescription"].value)
    assert said["metres_per_pixel"] == 0.01
    assert (said["along_from_x"], said["girth_from_y"], said["chart_frame"]) == (-1, 1, "M")
    assert (said["origin_along_m"], said["origin_girth_m"]) == pytest.approx((45.0, 6.0))


def test_full_disk_raises_oserror_and_prints_nothing(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (512, before[1]))
    try:
        with pytest.raises(OSError, match="File too large"):
            write(tmp_path / "ortho.tif", METRES, 1, -1)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert capfd.readouterr().err == ""


def test_the_same_tiles_give_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "two"):
        write(tmp_path / name, METRES, 1, -1)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
    assert {p.name for p in tmp_path.iterdir()} == {"one", "two"}
