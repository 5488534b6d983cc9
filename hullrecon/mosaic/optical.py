# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The optical mosaic [Ozog2016 3.2.4] (docs/methods.md 13), from posed images and a surface to
tiles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hullrecon.mosaic.blend import ViewLimits, blend_tile
from hullrecon.mosaic.grid import grid_around
from hullrecon.mosaic.imagery.camera_views import (
    CameraImages,
    Footprints,
    camera_views,
    compute_footprints,
    estimate_light,
    footprint_windows,
    plain_views,
)
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.options import OpticalOptions
from hullrecon.mosaic.output.tile_store import TileStore, make_tiles

Progress = Callable[[Sequence[Any], str], Iterable[Any]]
# of an image's distance: past a bilge, or through a gap of the model, a ray may meet it tens of
# metres away
MOST_MEDIANS = 3.0


@dataclass(frozen=True, kw_only=True)
class OpticalMosaic:
    """The tiles; gsd_m: a pixel on the hull, in the median; light_corrected: whether the light was
    evened out.
    """

    store: TileStore
    gsd_m: float
    light_corrected: bool


def optical_mosaic(
    surface: MosaicSurface,
    cameras: Sequence[CameraImages],
    options: OpticalOptions,
    progress: Progress,
) -> OpticalMosaic:
    """Return the mosaic: footprints, light, then tile by tile.

    Raises ValueError when no image meets the surface or the raster would be too large.
    """
    image_views = plain_views(cameras)
    footprints = compute_footprints(surface, image_views, MOST_MEDIANS)
    gsd = ground_sample_distance(cameras, footprints)
    grid = grid_around(footprints.at.reshape(-1, 2), texel_size(gsd, options))
    surface = surface.with_occlusion_horizon(grid, footprints.span_m)
    light = (
        estimate_light(
            surface, cameras, image_views, footprints, lambda rows: progress(rows, "light")
        )
        if options.even_light
        else None
    )
    light_corrected = camera_views(cameras, light)
    windows = footprint_windows(grid, footprints)
    limits = ViewLimits(min_cosine=float(np.cos(np.radians(options.max_incidence_deg))))
    store = make_tiles(
        grid, 3, options.tile_px, options.texture_px,
        lambda window: blend_tile(surface, grid, window, light_corrected, windows, limits, 3),
        lambda tiles: progress(tiles, "tiles"),
    )  # fmt: skip
    return OpticalMosaic(store=store, gsd_m=gsd, light_corrected=light is not None)


def ground_sample_distance(cameras: Sequence[CameraImages], footprints: Footprints) -> float:
    """Return the median distance over focal length, metres. Raises ValueError when no image meets
    the surface.
    """
    focal = np.concatenate(
        [np.full(len(s.rows), 0.5 * (s.camera.fx + s.camera.fy)) for s in cameras]
    )
    gsd = footprints.distance / focal
    if not np.isfinite(gsd).any():
        raise ValueError("no image meets the surface")
    return float(np.nanmedian(gsd))


def texel_size(gsd_m: float, options: OpticalOptions) -> float:
    """Return the side of a texel: as asked, else some pixels wide within bounds, in whole tenths of
    a millimetre.
    """
    if options.resolution_m is not None:
        return options.resolution_m
    wanted = float(
        np.clip(
            options.samples_per_texel * gsd_m, options.min_resolution_m, options.max_resolution_m
        )
    )
    return round(wanted, 4)
