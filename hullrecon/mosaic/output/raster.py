# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""GeoTIFFs on the chart: the mosaic's, and those of the hull as found."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.meshes.mesh import corner_shares
from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.mosaic_surface import MosaicSurface, sample_surface
from hullrecon.mosaic.output.cog import BLOCK, Picture, write_cog
from hullrecon.mosaic.output.tile_store import CompressedTiles
from hullrecon.mosaic.stream import Stream
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.threads import in_threads
from hullrecon.typing import Array


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
    path: Path,
    tiles: CompressedTiles,
    layout: RasterLayout,
    bands: RasterBands,
    scratch: BinaryIO,
) -> list[Picture]:
    """Write tiles in the order of grid.tiles(size), as the same bytes for the same tiles.

    `tiles`: (size, size, bands), or (size, size). `scratch`: a file for what is in work.
    Returns the picture and its overviews, as long as the scratch file lives.
    """
    grid, (mirrored, upset) = layout.grid, layout.outside.flips
    picture = Picture(
        tiles=tiles,
        size=layout.size,
        width=grid.width,
        height=grid.height,
        mirrored=mirrored,
        upset=upset,
    )
    return write_cog(path, picture, _template(layout, bands), bands.nodata, scratch)


def _template(layout: RasterLayout, bands: RasterBands) -> bytes:
    """Let GDAL write the tags of a raster, with a block that holds nothing."""
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


QUANTUM_M = 0.0001  # metres are written in steps of it: finer is noise, and compresses badly

SURFACE_BANDS = {
    "deviation": "signed distance of the hull as found from its CAD model, outward positive",
    "deviation_sigma": "one sigma of the deviation, the hull's position included",
    "form": "deviation without the offset and the tilt of the surveyed patch",
    "form_sigma": "one sigma of the form, which the hull's position hardly enters",
    "support": "images that saw the surface where landmarks measured it",
}
SUPPORT_BY_RETURNS = "DVL returns within reach of the surface"


def surface_values(surface: Surface, split: DeviationSplit | None) -> dict[str, Array]:
    """Collect the values (n,) at the vertices by raster, NaN where unseen.

    Without a CAD model there is the support alone.
    """
    values = {"support": surface.support.astype(float)}
    if split is not None:
        values |= {
            "deviation": surface.deviation,
            "deviation_sigma": surface.sigma,
            "form": split.form,
            "form_sigma": split.form_sigma,
        }
    return {name: np.where(surface.support > 0, v, np.nan) for name, v in values.items()}


def surface_tiles(
    surface: MosaicSurface,
    values: Mapping[str, Array],
    layout: RasterLayout,
    scratch: BinaryIO,
    stream: Stream = in_threads,
) -> dict[str, CompressedTiles]:
    """Interpolate values (n,) of the vertices at the texels.

    Metres are linear on each face, counts those of the nearest corner; NaN, and 0 for counts, where
    there is none. The surface's horizon is not needed here. `scratch`: a file that keeps the tiles.
    """
    shape = (layout.size, layout.size)
    tiles = {name: CompressedTiles(shape, surface_bands(name).dtype, scratch) for name in values}

    def make(window: Window) -> Mapping[str, bytes]:
        made = _interpolate(surface, values, layout, window)
        return {name: tiles[name].pack(tile) for name, tile in made.items()}

    for made in stream(make, list(layout.grid.tiles(layout.size)), "rasters of the surface"):
        for name, packed in made.items():
            tiles[name].add_packed(packed)
    return tiles


def _interpolate(
    surface: MosaicSurface, values: Mapping[str, Array], layout: RasterLayout, window: Window
) -> dict[str, Array]:
    """Interpolate values (n,) of the vertices at the texels of one tile."""
    part = window.meet(layout.grid.whole)
    patch = sample_surface(surface, layout.grid, part)
    held = patch.face >= 0
    corners = surface.mesh.faces[patch.face[held]]
    share = corner_shares(surface.mesh.vertices[corners], patch.point[held])
    nearest = np.take_along_axis(corners, share.argmax(axis=1)[:, None], axis=1)[:, 0]
    tiles = {}
    for name, value in values.items():
        counts = name == "support"
        tiles[name] = tile = np.full(window.shape, 0.0 if counts else np.nan)
        tile[: part.shape[0], : part.shape[1]][held] = (
            np.nan_to_num(value[nearest])
            if counts
            else np.rint((value[corners] * share).sum(axis=1) / QUANTUM_M) * QUANTUM_M
        )
    return tiles


def surface_bands(name: str, *, by_images: bool = True) -> RasterBands:
    """Describe the raster of that name.

    `by_images`: whether the support counts images, else returns of the DVL.
    """
    counts = name == "support"
    return RasterBands(
        names=(name,),
        unit="" if counts else "m",
        dtype="uint16" if counts else "float32",
        title=SUPPORT_BY_RETURNS if counts and not by_images else SURFACE_BANDS[name],
        nodata=0 if counts else float("nan"),
    )
