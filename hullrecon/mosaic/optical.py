# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The optical mosaic [Ozog2016 3.2.4] (docs/methods.md 13), from posed images and a surface to tiles."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hullrecon.mosaic.blend import Limits, blend_tile
from hullrecon.mosaic.grid import grid_around
from hullrecon.mosaic.ground import Ground
from hullrecon.mosaic.imagery.camera_views import (
    Footprint,
    Station,
    footprint_of,
    light_of,
    lit_sights,
    plain_sights,
    windows_of,
)
from hullrecon.mosaic.options import OpticalOptions
from hullrecon.mosaic.output.store import TileStore, lay

Progress = Callable[[Sequence[Any], str], Iterable[Any]]


@dataclass(frozen=True)
class Mosaicked:
    """The tiles; gsd_m: a pixel on the hull, in the median; lit: whether the light was evened out."""

    store: TileStore
    gsd_m: float
    lit: bool


def optical_mosaic(ground: Ground, stations: Sequence[Station], options: OpticalOptions, progress: Progress) -> Mosaicked:
    """Footprints, light, then tile by tile. ValueError when no image meets the surface or the raster would be too large."""
    sights = plain_sights(stations)
    footprint = footprint_of(ground, sights)
    gsd = ground_sample_distance(stations, footprint)
    grid = grid_around(footprint.at.reshape(-1, 2), texel_of(gsd, options))
    ground = ground.with_skyline(grid, footprint.span_m)
    light = light_of(ground, stations, sights, footprint, lambda rows: progress(rows, "light")) if options.even_light else None
    lit = lit_sights(stations, light)
    windows = windows_of(grid, footprint)
    limits = Limits(least_cosine=float(np.cos(np.radians(options.most_incidence_deg))))
    store = lay(
        grid, 3, options.tile_px, options.texture_px,
        lambda window: blend_tile(ground, grid, window, lit, windows, limits, 3),
        lambda tiles: progress(tiles, "tiles"),
    )  # fmt: skip
    return Mosaicked(store, gsd, light is not None)


def ground_sample_distance(stations: Sequence[Station], footprint: Footprint) -> float:
    """Median distance over focal length, metres. ValueError when no image meets the surface."""
    focal = np.concatenate([np.full(len(s.rows), 0.5 * (s.camera.fx + s.camera.fy)) for s in stations])
    gsd = footprint.distance / focal
    if not np.isfinite(gsd).any():
        raise ValueError("no image meets the surface")
    return float(np.nanmedian(gsd))


def texel_of(gsd_m: float, options: OpticalOptions) -> float:
    """The side of a texel: as asked, else some pixels wide within bounds, in whole tenths of a millimetre."""
    if options.resolution_m is not None:
        return options.resolution_m
    wanted = float(np.clip(options.samples_per_texel * gsd_m, options.least_resolution_m, options.most_resolution_m))
    return round(wanted, 4)
