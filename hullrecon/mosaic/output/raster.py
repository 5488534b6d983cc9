# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write tiles as a cloud-optimised GeoTIFF in map coordinates, the hull seen from outside."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.mosaic.grid import TexelGrid


@dataclass(frozen=True, kw_only=True)
class RasterBands:
    """What a raster holds."""

    names: tuple[str, ...]  # of its bands, of which the last may be `alpha`
    unit: str  # of the others, "" for grey levels and counts
    dtype: str
    title: str  # what it is, in words
    nodata: float | None = None  # value of texels without one, None with an alpha

    @property
    def creation_options(self) -> dict[str, object]:
        """Choose how GDAL stores the bands."""
        if self.names[-1] != "alpha":
            return {"predictor": 3 if self.dtype.startswith("float") else 2}
        photometric = "RGB" if len(self.names) == 4 else "MINISBLACK"
        return {
            "photometric": photometric,
            "alpha": "NON-PREMULTIPLIED",
            "interleave": "pixel",
            "predictor": 2,
        }


@dataclass(frozen=True, kw_only=True)
class RasterLayout:
    """Where a raster lies."""

    grid: TexelGrid  # the texels of the chart
    size: int  # of its tiles
    outside: OutsideMap  # the map that they are written in

    @property
    def corner(self) -> tuple[float, float]:
        """Return x and y of the upper left corner for a viewer outside."""
        grid = self.grid
        along = grid.west + (grid.width * grid.step_m if self.outside.x_sign < 0 else 0)
        girth = grid.north - (grid.height * grid.step_m if self.outside.y_sign < 0 else 0)
        return self.outside.x_sign * along, self.outside.y_sign * girth


def write_raster(
    path: Path, tiles: Iterable[NDArray[np.generic]], layout: RasterLayout, bands: RasterBands
) -> None:
    """Write tiles in the order of grid.tiles(size), as the same bytes for the same tiles.

    GDAL's driver for cloud-optimised files copies a whole file with its overviews. Both, deflated,
    stay in memory: on a full disk GDAL raises errors of its own and prints on standard error, a
    write of ours raises OSError. `tiles`: (size, size, bands), or (size, size).
    """
    import rasterio
    from rasterio.io import MemoryFile
    from rasterio.shutil import copy

    grid, (west, north) = layout.grid, layout.corner
    options = bands.creation_options
    with (
        rasterio.Env(GDAL_NUM_THREADS=1),
        MemoryFile() as memory,
        MemoryFile(ext=".tif") as finished,
    ):
        with memory.open(
            driver="GTiff",
            width=grid.width,
            height=grid.height,
            count=len(bands.names),
            dtype=bands.dtype,
            crs=rasterio.CRS.from_wkt(layout.outside.wkt),
            transform=rasterio.Affine(grid.step_m, 0, west, 0, -grid.step_m, north),
            nodata=bands.nodata,
            tiled=True,
            blockxsize=512,
            blockysize=512,
            compress="DEFLATE",
            zlevel=1,
            bigtiff="IF_SAFER",
            **options,
        ) as file:
            for window, values in _windows(tiles, layout):
                file.write(values, window=rasterio.windows.Window(*window))
            for k, name in enumerate(bands.names, start=1):
                file.set_band_description(k, name)
                file.set_band_unit(k, "" if name == "alpha" else bands.unit)
            file.update_tags(
                TIFFTAG_IMAGEDESCRIPTION=json.dumps(description(layout, bands), sort_keys=True)
            )
            file.update_tags(TIFFTAG_SOFTWARE="hullrecon")
        copy(
            memory.name,
            finished.name,
            driver="COG",
            compress="DEFLATE",
            blocksize=512,
            bigtiff="IF_SAFER",
            predictor="YES",
            overview_resampling="average",
        )
        path.write_bytes(finished.getbuffer())


def description(layout: RasterLayout, bands: RasterBands) -> dict[str, object]:
    """Write the text of ImageDescription."""
    x, y = layout.corner
    return {
        "title": bands.title,
        "metres_per_pixel": layout.grid.step_m,
        "origin_along_m": layout.outside.x_sign * x,
        "origin_girth_m": layout.outside.y_sign * y,
        "origin": "outer corner of the first pixel, upper left for a viewer outside the hull",
        "along_from_x": layout.outside.x_sign,
        "girth_from_y": layout.outside.y_sign,
        "chart_frame": layout.outside.frame,
    }


def _windows(
    tiles: Iterable[NDArray[np.generic]], layout: RasterLayout
) -> Iterable[tuple[tuple[int, int, int, int], NDArray[np.generic]]]:
    """Yield column, row, width, height of each tile, and its values (bands, height, width)."""
    grid, (mirrored, upset) = layout.grid, layout.outside.flips
    for window, tile in zip(grid.tiles(layout.size), tiles, strict=True):
        held = window.meet(grid.whole)
        height, width = held.shape
        values = np.atleast_3d(tile)[:height, :width]
        values = values[:: -1 if upset else 1, :: -1 if mirrored else 1]
        column = grid.width - held.right if mirrored else held.left
        row = grid.height - held.bottom if upset else held.top
        yield (column, row, width, height), np.ascontiguousarray(np.moveaxis(values, 2, 0))
