# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make the optical mosaic from images and a surface [Ozog2016 3.2.4] (docs/methods.md 13)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from hullrecon.mosaic.blend import ViewLimits
from hullrecon.mosaic.grid import grid_around
from hullrecon.mosaic.imagery.camera_views import (
    CameraImages,
    Footprints,
    camera_views,
    compute_footprints,
    estimate_light,
    plain_views,
)
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.options import OpticalOptions
from hullrecon.mosaic.output.tile_store import TileStore, blend_tiles
from hullrecon.mosaic.stream import Stream

# Hits of an image's rays that are farther than this multiple of their median distance do not count:
# past a bilge, or through a gap of the model, a ray may meet it tens of metres away
MOST_MEDIANS = 3.0
MIN_TEXEL_M, MAX_TEXEL_M = 0.001, 0.02  # limits of the chosen side of a texel
# Views more oblique than 70 degrees are not used
LIMITS = ViewLimits(min_cosine=float(np.cos(np.radians(70.0))))


@dataclass(frozen=True, kw_only=True)
class OpticalMosaic:
    """The optical mosaic."""

    store: TileStore
    gsd_m: float  # median ground sample distance: side of a pixel on the hull
    light_corrected: bool  # whether lamp, vignetting and brightness were corrected


def optical_mosaic(
    surface: MosaicSurface,
    cameras: Sequence[CameraImages],
    options: OpticalOptions,
    stream: Stream,
    scratch: BinaryIO,
) -> OpticalMosaic:
    """Make the mosaic: find footprints, estimate the light, then blend tile by tile.

    Parameters
    ----------
    surface
        The surface on which the images are laid.
    cameras
        For each camera its images and their poses.
    options
        Side of a texel, size of a tile, and whether the light is corrected.
    stream
        Maps work over threads.
    scratch
        An empty file that keeps the tiles.

    Raises
    ------
    ValueError
        When no image meets the surface.
    """
    # Where the images meet the surface, which gives the raster
    image_views = plain_views(cameras)
    footprints = compute_footprints(surface, image_views, MOST_MEDIANS)
    gsd = ground_sample_distance(cameras, footprints)
    grid = grid_around(footprints.at.reshape(-1, 2), texel_size(gsd, options))
    surface = surface.with_occlusion_horizon(grid, footprints.span_m)
    # The light, then the tiles
    light = (
        estimate_light(surface, cameras, image_views, footprints, stream)
        if options.even_light
        else None
    )
    store = blend_tiles(
        surface,
        grid,
        footprints,
        camera_views(cameras, light),
        LIMITS,
        3,
        options.tile_px,
        stream,
        scratch,
    )
    return OpticalMosaic(store=store, gsd_m=gsd, light_corrected=light is not None)


def ground_sample_distance(cameras: Sequence[CameraImages], footprints: Footprints) -> float:
    """Compute the median ground sample distance, m: an image's distance over its focal length.

    Raises ValueError when no image meets the surface.
    """
    focal = np.concatenate(
        [np.full(len(s.rows), 0.5 * (s.camera.fx + s.camera.fy)) for s in cameras]
    )
    gsd = footprints.distance / focal
    if not np.isfinite(gsd).any():
        raise ValueError("no image meets the surface")
    return float(np.nanmedian(gsd))


def texel_size(gsd_m: float, options: OpticalOptions) -> float:
    """Choose the side of a texel, m: from the options, else the ground sample distance.

    The latter is limited to MIN_TEXEL_M and MAX_TEXEL_M, and rounded to tenths of a millimetre.
    """
    if options.resolution_m is not None:
        return options.resolution_m
    return round(float(np.clip(gsd_m, MIN_TEXEL_M, MAX_TEXEL_M)), 4)
