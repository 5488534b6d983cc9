# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The mosaic of an imaging sonar [Ozog2016 3.2.3, 3.2.4] (docs/methods.md 14), from posed pings and a surface to tiles."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.blend import Limits, blend_tile
from hullrecon.mosaic.grid import grid_around
from hullrecon.mosaic.ground import Ground, Patch, patch_of, seen
from hullrecon.mosaic.imagery.camera_views import Footprint, footprint_of, windows_of
from hullrecon.mosaic.imagery.sonar_fan import Fan, fan_of
from hullrecon.mosaic.options import SonarOptions
from hullrecon.mosaic.output.store import TileStore, lay
from hullrecon.records.sensors import SonarPings
from hullrecon.typing import Array, Floats32, Ints

Progress = Callable[[Sequence[Any], str], Iterable[Any]]
LEVEL = 90.0  # gray level that the mean return is brought to
LEAST_SAMPLES = 200  # of the hull, for a ping or a place in the fan to have a level of its own


@dataclass(frozen=True)
class SonarSight:
    """A ping. pose: one T_M_o (T_g_o without a CAD model); image (beams, ranges) uint8; level (beams, ranges): what a mean piece
    of hull returns there in that ping, None to leave the image as it is."""

    pose: Poses
    fan: Fan
    image: NDArray[np.uint8]
    level: Array | None = None

    @property
    def center(self) -> Array:
        return np.asarray(self.pose.translation[0])

    def project(self, points: Array) -> tuple[Array, Array]:
        """Pixel: range bin, beam. r/R on the fan as displayed, from u = w/2, v = 3h/4."""
        inside = (points - self.center) @ self.pose.rotation.as_matrix()[0]
        return self.fan.locate(inside)

    def outline(self, ground: Ground) -> Array:
        """Rays all over the aperture; where the surface is met beyond the last range, the point at that range."""
        rays = self.fan.rays(bearings=9, elevations=13) @ self.pose.rotation.as_matrix()[0].T
        gone = ground.scene.cast(np.tile(self.center, (len(rays), 1)), rays)
        gone = np.where(np.isfinite(gone), np.minimum(gone, self.fan.range_m[-1]), np.nan)
        return np.asarray(self.center + gone[:, None] * rays)

    def picture(self) -> Floats32 | None:
        raw = self.image.astype(np.float32)
        even = raw if self.level is None else raw * (LEVEL / np.maximum(self.level, 1.0)).astype(np.float32)
        return np.ascontiguousarray(np.minimum(even, 255)[..., None])


@dataclass(frozen=True)
class SonarMosaicked:
    """The tiles; whether the level of the returns was learnt from the dive; where the pings met the surface."""

    store: TileStore
    lit: bool
    footprint: Footprint


def sonar_mosaic(
    ground: Ground, pings: SonarPings, poses: Poses, elevation_rad: float, options: SonarOptions, progress: Progress
) -> SonarMosaicked:
    """poses: T_M_o at the pings; elevation_rad: the full aperture out of the fan. ValueError when no ping meets the surface."""
    fan = fan_of(pings.directions, pings.range_m, options.aperture_share * elevation_rad)
    sights = [SonarSight(poses[i], fan, image) for i, image in enumerate(pings.image)]
    footprint = footprint_of(ground, sights)
    step = options.resolution_m or round(float(np.median(np.diff(pings.range_m))), 4)
    grid = grid_around(footprint.at.reshape(-1, 2), step)
    ground = ground.with_skyline(grid, footprint.span_m)
    limits = Limits(least_cosine=float(np.cos(np.radians(options.most_incidence_deg))), slant=0.0)
    levels = learn_levels(ground, sights, footprint, limits.least_cosine) if options.even_light else None
    if levels is not None:
        sights = [replace(s, level=level) for s, level in zip(sights, levels, strict=True)]
    windows = windows_of(grid, footprint)
    store = lay(
        grid, 1, options.tile_px, options.texture_px,
        lambda window: blend_tile(ground, grid, window, sights, windows, limits, 1),
        lambda tiles: progress(tiles, "tiles"),
    )  # fmt: skip
    return SonarMosaicked(store, levels is not None, footprint)


def learn_levels(ground: Ground, sights: Sequence[SonarSight], footprint: Footprint, least_cosine: float) -> list[Array] | None:
    """What the hull returns on average at each range and beam, times each ping's gain: beam pattern, spreading, grazing angle.

    Only pixels on which the surface lies and is seen are counted, so that neither water before the first return nor shadows
    darken the mean. None when too little of the hull was seen.
    """
    grid = grid_around(footprint.at.reshape(-1, 2), 0.05)
    shape = sights[0].image.shape
    total, count = np.zeros(shape), np.zeros(shape)
    cells: list[Ints] = [np.zeros(0, np.int64) for _ in sights]
    windows = windows_of(grid, footprint)
    for tile in grid.tiles(1024):
        patch = patch_of(ground, grid, tile)
        for k, sight in enumerate(sights):
            part = windows[k].meet(tile).within(tile)
            cells[k] = np.concatenate([cells[k], _hull_cells(ground, sight, patch.part(part), least_cosine)])
    for sight, cell in zip(sights, cells, strict=True):
        flat = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape)
        total += flat * sight.image
        count += flat
    if count.sum() < LEAST_SAMPLES:
        return None
    mean = _smooth(total, count)
    return [mean * _gain(sight.image.ravel()[cell], mean.ravel()[cell]) for sight, cell in zip(sights, cells, strict=True)]


def _hull_cells(ground: Ground, sight: SonarSight, patch: Patch, least_cosine: float) -> Ints:
    """Flat indices into the image of the pixels that hold these pieces of hull."""
    point = patch.point.reshape(-1, 3)
    rows = np.flatnonzero(np.isfinite(point[:, 0]))
    pixel, ratio = sight.project(point[rows])
    held = np.isfinite(ratio)
    free, _ = seen(ground, patch, rows[held], sight.center, least_cosine)
    near = np.rint(pixel[held][free]).astype(np.int64)
    return np.asarray(near[:, 1] * sight.image.shape[1] + near[:, 0])


def _gain(values: NDArray[np.uint8], means: Array) -> float:
    """A ping's brightness over the dive's, held to a factor of two."""
    if len(values) < LEAST_SAMPLES:
        return 1.0
    return float(np.clip(values.astype(float).sum() / max(means.sum(), 1e-9), 0.5, 2.0))


def _smooth(total: Array, count: Array) -> Array:
    """Local mean over 2 beams and 3 range bins (sigma); wider where nothing was counted."""
    from scipy.ndimage import gaussian_filter

    wide = gaussian_filter(total, (8, 12), mode="nearest") / np.maximum(gaussian_filter(count, (8, 12), mode="nearest"), 1e-9)
    fine_count = gaussian_filter(count, (2, 3), mode="nearest")
    fine = gaussian_filter(total, (2, 3), mode="nearest") / np.maximum(fine_count, 1e-9)
    share = np.minimum(fine_count, 1.0)
    return np.asarray(np.maximum(share * fine + (1 - share) * wide, 1.0))
