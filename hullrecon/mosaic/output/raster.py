# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""GeoTIFFs on the chart: those of a mosaic, and those of the hull as found."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.mosaic_surface import COUNTS, value_type
from hullrecon.mosaic.output.cog import BLOCK, Picture, write_cog
from hullrecon.mosaic.output.tile_store import CompressedTiles
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class RasterBands:
    """Names, unit and type of a raster's bands."""

    names: tuple[str, ...]  # of the bands. The last may be `alpha`
    unit: str  # of the other bands, "" for grey levels and counts
    dtype: str
    title: str  # description in words
    nodata: float | None = None  # value of texels without data, None with an alpha

    @property
    def creation_options(self) -> dict[str, object]:
        """GDAL's options by which the bands are stored: colours, alpha, order and predictor."""
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
    """Position of a raster on the chart and on the map seen from outside."""

    grid: TexelGrid  # the texels on the chart
    size: int  # px, side of a tile
    outside: OutsideMap  # the map in which it is written

    @property
    def corner(self) -> tuple[float, float]:
        """Map coordinates x and y, m, of the upper left corner for a viewer outside."""
        grid = self.grid
        along = grid.west + (grid.width * grid.step_m if self.outside.x_sign < 0 else 0)
        girth = grid.north - (grid.height * grid.step_m if self.outside.y_sign < 0 else 0)
        return self.outside.x_sign * along, self.outside.y_sign * girth


def write_raster(
    path: Path,
    tiles: CompressedTiles,
    layout: RasterLayout,
    bands: RasterBands,
    scratch: BinaryIO,
) -> list[Picture]:
    """Write the tiles of a raster as a cloud-optimised GeoTIFF with overviews, seen from outside.

    The same tiles give the same bytes.

    Parameters
    ----------
    path
        Where the file is written.
    tiles
        (size, size, bands) or (size, size), in the order of `layout.grid.tiles(layout.size)`.
    layout, bands
        Position of the raster, and what its bands are.
    scratch
        A file for compressed blocks and overviews.

    Returns
    -------
    list of Picture
        The picture and its overviews, to be read as long as the scratch file exists.
    """
    grid, (mirrored, upside_down) = layout.grid, layout.outside.flips
    picture = Picture(
        tiles=tiles,
        size=layout.size,
        width=grid.width,
        height=grid.height,
        mirrored=mirrored,
        upside_down=upside_down,
    )
    return write_cog(path, picture, _template(layout, bands), bands.nodata, scratch)


def _template(layout: RasterLayout, bands: RasterBands) -> bytes:
    """Let GDAL write a TIFF of one empty block with the tags of a raster.

    Its tags are those of the file that is written here: position, map, bands, compression.
    """
    import rasterio
    from rasterio.io import MemoryFile

    (west, north), step_m = layout.corner, layout.grid.step_m
    with rasterio.Env(), MemoryFile() as memory:
        with memory.open(
            driver="GTiff",
            width=BLOCK,
            height=BLOCK,
            count=len(bands.names),
            dtype=bands.dtype,
            crs=rasterio.CRS.from_wkt(layout.outside.wkt),
            transform=rasterio.Affine(step_m, 0, west, 0, -step_m, north),
            nodata=bands.nodata,
            tiled=True,
            blockxsize=BLOCK,
            blockysize=BLOCK,
            compress="DEFLATE",
            sparse_ok=True,
            **bands.creation_options,
        ) as file:
            for k, name in enumerate(bands.names, start=1):
                file.set_band_description(k, name)
                file.set_band_unit(k, "" if name == "alpha" else bands.unit)
            file.update_tags(
                TIFFTAG_IMAGEDESCRIPTION=json.dumps(description(layout, bands), sort_keys=True)
            )
            file.update_tags(TIFFTAG_SOFTWARE="hullrecon")
        return bytes(memory.getbuffer())


def description(layout: RasterLayout, bands: RasterBands) -> dict[str, object]:
    """Make the members of the TIFF tag ImageDescription, a JSON text."""
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


SURFACE_BANDS = {
    "deviation": "signed distance of the hull as found from its CAD model, outward positive",
    "deviation_sigma": "one sigma of the deviation, the hull's position included",
    "form": "deviation without the offset and the tilt of the surveyed patch",
    "form_sigma": "one sigma of the form, which the hull's position hardly enters",
    "support": "images that saw the surface where landmarks measured it",
}
SUPPORT_BY_RETURNS = "DVL returns within reach of the surface"


def surface_values(surface: Surface, split: DeviationSplit | None) -> dict[str, Array]:
    """Collect the values (n,) at the surface's vertices, by name of the raster. NaN where unseen.

    Without a CAD model (`split` is None) there is only the support.
    """
    values = {COUNTS: surface.support.astype(float)}
    if split is not None:
        values |= {
            "deviation": surface.deviation,
            "deviation_sigma": surface.sigma,
            "form": split.form,
            "form_sigma": split.form_sigma,
        }
    return {name: np.where(surface.support > 0, v, np.nan) for name, v in values.items()}


def surface_bands(name: str, *, by_images: bool = True) -> RasterBands:
    """Describe the bands of the surface raster with a given name.

    `by_images`: whether the support counts images. Otherwise it counts DVL returns.
    """
    counts = name == COUNTS
    return RasterBands(
        names=(name,),
        unit="" if counts else "m",
        dtype=value_type(name),
        title=SUPPORT_BY_RETURNS if counts and not by_images else SURFACE_BANDS[name],
        nodata=0 if counts else float("nan"),
    )
