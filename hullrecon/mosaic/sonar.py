# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make the mosaic of an imaging sonar [Ozog2016 3.2.3, 3.2.4] (docs/methods.md 14).

A ping is an image over beam and range. In the sonar's axes z points ahead, y along the bearings and
x out of the fan. A view's best place is defined on the fan-shaped display of the image, with width
w and height h: it is the pixel u = w/2, v = 3h/4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.blend import ViewLimits
from hullrecon.mosaic.grid import grid_around
from hullrecon.mosaic.imagery.camera_views import (
    Footprints,
    compute_footprints,
    footprint_windows,
)
from hullrecon.mosaic.imagery.radiometry import Part
from hullrecon.mosaic.mosaic_surface import (
    MosaicSurface,
    SurfacePatch,
    find_visible,
    sample_surface,
)
from hullrecon.mosaic.options import SonarOptions
from hullrecon.mosaic.output.tile_store import TileStore, blend_tiles
from hullrecon.mosaic.stream import Stream
from hullrecon.records.sensors import SonarPings
from hullrecon.typing import Array, Floats32, Ints


@dataclass(frozen=True, kw_only=True)
class SonarFan:
    """Beams and ranges of a sonar's image."""

    bearing: Array  # (beams,) rad, ascending
    beam: Array  # (beams,) row in the image of each bearing
    range_m: Array  # (ranges,) ascending
    half_elevation: float  # rad, largest angle out of the fan

    def locate(self, points: Array) -> tuple[Array, Array]:
        """Locate points (n, 3) m, given in the sonar's axes, in the sonar's image.

        The elevation of a point does not show in the image.

        Returns
        -------
        pixel
            (n, 2) range bin and beam number.
        ratio
            (n,) distance from the best place on the display, over the largest that is displayed.
            NaN for points outside the fan.
        """
        x, y, z = points.T
        ahead = np.hypot(y, z)  # distance within the plane of the fan
        distance, bearing, elevation = np.hypot(ahead, x), np.arctan2(y, z), np.arctan2(x, ahead)
        first, last = self.range_m[0], self.range_m[-1]
        range_bin = (distance - first) * (len(self.range_m) - 1) / (last - first)
        beam = np.interp(bearing, self.bearing, self.beam)
        in_fan = (
            (distance >= first) & (distance <= last)
            & (bearing >= self.bearing[0]) & (bearing <= self.bearing[-1])
            & (np.abs(elevation) <= self.half_elevation)
        )  # fmt: skip
        return np.stack([range_bin, beam], axis=1), np.where(
            in_fan, self._from_best_m(distance, bearing) / self._farthest_m(), np.nan
        )

    def rays(self, bearings: int, elevations: int) -> Array:
        """Make unit vectors (bearings * elevations, 3) in the sonar's axes, over the aperture.

        They are cast to find where a ping may meet the hull.
        """
        psi, theta = np.meshgrid(
            np.linspace(self.bearing[0], self.bearing[-1], bearings),
            np.linspace(-self.half_elevation, self.half_elevation, elevations),
        )
        level = np.cos(theta)
        return np.stack([np.sin(theta), level * np.sin(psi), level * np.cos(psi)], axis=-1).reshape(
            -1, 3
        )

    def _best_ahead_m(self) -> float:
        """Compute how far ahead of the sonar the best place, v = 3h/4, lies.

        The display reaches from the largest range down to the nearest point of the fan.
        """
        near = self.range_m[0] * float(np.cos(np.abs(self.bearing).max()))
        return float(self.range_m[-1] - 0.75 * (self.range_m[-1] - near))

    def _from_best_m(self, distance: Array, bearing: Array) -> Array:
        """Compute the distance on the display from the best place, m."""
        return np.hypot(
            distance * np.sin(bearing), distance * np.cos(bearing) - self._best_ahead_m()
        )

    def _farthest_m(self) -> float:
        """Compute the largest distance from the best place on the display, at a corner."""
        corners = [
            (r, b) for r in self.range_m[[0, -1]] for b in (self.bearing[0], 0.0, self.bearing[-1])
        ]
        return max(float(self._from_best_m(np.float64(r), np.float64(b))) for r, b in corners)  # type: ignore[arg-type]


def build_fan(directions: Array, range_m: Array, elevation_rad: float) -> SonarFan:
    """Build a fan from the unit vectors of the beams.

    Parameters
    ----------
    directions
        Unit vectors (beams, 3) in the sonar's axes, in any order.
    range_m
        (ranges,) m, ascending and evenly spaced.
    elevation_rad
        Full aperture out of the fan.
    """
    bearing = np.arctan2(directions[:, 1], directions[:, 2])
    order = np.argsort(bearing, kind="stable")
    return SonarFan(
        bearing=bearing[order],
        beam=order.astype(float),
        range_m=range_m,
        half_elevation=0.5 * elevation_rad,
    )


APERTURE_SHARE = 0.9  # share of the elevation aperture that is used: at its edge returns are weak
# Views more oblique than 82 degrees are not used; an imaging sonar grazes the hull
LIMITS = ViewLimits(min_cosine=float(np.cos(np.radians(82.0))), slant=0.0)
# Ratio of mean gray levels. Where the hull lies in the middle of the window, both ways meet some
CLEARLY_BRIGHTER = 1.5
# Likewise: 1 where hull fills the whole picture, and less by what its far part is darker
CLEARLY_DARKER = 0.7
LEVEL = 90.0  # gray level of the mean return after the correction
LEVEL_STEP_M = 0.05  # side of the texels from which the levels are estimated
BLOCK = 256  # side of a block of those texels
MIN_SAMPLES = 200  # texels on the hull, below which no level or gain is estimated


@dataclass(frozen=True, kw_only=True)
class SonarView:
    """A ping as a view of the hull. An `ImageView`."""

    pose: Poses  # one result_from_sonar
    fan: SonarFan
    image: NDArray[np.uint8]  # (beams, ranges)
    # (beams, ranges) mean gray level that hull has there. None: the image is not corrected.
    level: Array | None = None
    gain: float = 1.0  # ratio of this ping's brightness to the mean

    @property
    def center(self) -> Array:
        return np.asarray(self.pose.translation[0])

    def project(self, points: Array) -> tuple[Array, Array]:
        """Project points (n, 3) to pixels (range bin, beam), with r / R on the display."""
        inside = (points - self.center) @ self.pose.rotation.as_matrix()[0]
        return self.fan.locate(inside)

    def least_ratio(self, center: Array, radius: Array) -> Array:
        """Bound r / R by zero, as any ball may hold the best place."""
        return np.zeros(len(radius))

    def outline(self, surface: MosaicSurface) -> Array:
        """Cast rays all over the aperture onto the surface: hits (n, 3) m, NaN where they miss.

        Farther hits are taken at the largest range.
        """
        rays = self.fan.rays(bearings=9, elevations=13) @ self.pose.rotation.as_matrix()[0].T
        hit_m = surface.scene.cast(np.tile(self.center, (len(rays), 1)), rays)
        end_m = np.where(np.isfinite(hit_m), np.minimum(hit_m, self.fan.range_m[-1]), np.nan)
        return np.asarray(self.center + end_m[:, None] * rays)

    @property
    def size(self) -> tuple[int, int]:
        return self.image.shape[1], self.image.shape[0]

    def picture(self, part: Part) -> Floats32 | None:
        """Take a part of the ping as a picture of one channel, with its level evened if known."""
        raw = self.image[part].astype(np.float32)
        if self.level is not None:
            raw *= (LEVEL / np.maximum(self.level[part] * self.gain, 1.0)).astype(np.float32)
        return np.ascontiguousarray(np.minimum(raw, 255)[..., None])


@dataclass(frozen=True, kw_only=True)
class Contrast:
    """Mean gray level of the pixels that show hull over that of all, which show water too."""

    logged: float
    turned: float  # with each beam's samples taken from far to near

    @property
    def words(self) -> str:
        """What contradicts what, "" where the returns are where the hull is."""
        if self.turned > max(1.0, CLEARLY_BRIGHTER * self.logged):
            return (
                "the sonar's samples seem to run from far to near: taken so, its pings are "
                f"{self.turned / self.logged:.1f} times as bright where the hull lies; write each "
                "beam's samples from near to far"
            )
        if self.logged < CLEARLY_DARKER:
            return (
                f"where the hull lies in the sonar's pings they are {self.logged:.2f} times as "
                "bright as on average: its ranges, its mount or its servo's angle contradict the "
                "hull, or noise is brighter than the hull"
            )
        return ""


@dataclass(frozen=True, kw_only=True)
class SonarMosaic:
    """The mosaic of a sonar."""

    store: TileStore
    light_corrected: bool  # whether levels of returns were estimated and corrected
    footprints: Footprints  # where the pings met the surface
    contrast: Contrast | None  # None where levels were not estimated


@dataclass(frozen=True, kw_only=True)
class ReturnLevels:
    """Gray levels of returns from the hull: by range and beam, and for each ping."""

    mean: Array  # (beams, ranges) mean over the dive
    gain: Array  # (pings,) ratio of each ping's brightness to the mean
    contrast: Contrast


def sonar_mosaic(
    surface: MosaicSurface,
    pings: SonarPings,
    poses: Poses,
    elevation_rad: float,
    options: SonarOptions,
    stream: Stream,
    scratch: BinaryIO,
) -> SonarMosaic:
    """Make the mosaic: find footprints, estimate levels of returns, then blend tile by tile.

    Parameters
    ----------
    surface
        The surface on which the pings are laid.
    pings
        Images of the sonar, with its beams and ranges.
    poses
        result_from_sonar at the pings.
    elevation_rad
        The full aperture out of the fan, of which APERTURE_SHARE is used.
    options
        Side of a texel, size of a tile, and whether levels are corrected.
    stream
        Maps work over threads.
    scratch
        An empty file for the tiles and other data that grow with the dive.

    Raises
    ------
    ValueError
        When no ping meets the surface.
    """
    # Where the pings meet the surface, which gives the raster
    fan = build_fan(pings.directions, pings.range_m, APERTURE_SHARE * elevation_rad)
    image_views = [
        SonarView(pose=poses[i], fan=fan, image=image) for i, image in enumerate(pings.image)
    ]
    footprints = compute_footprints(surface, image_views)
    step = options.resolution_m or round(float(np.median(np.diff(pings.range_m))), 4)
    grid = grid_around(footprints.at.reshape(-1, 2), step)
    surface = surface.with_occlusion_horizon(grid, footprints.span_m)
    # The levels of returns, then the tiles
    levels = (
        learn_levels(surface, image_views, footprints, LIMITS.min_cosine, scratch)
        if options.even_light
        else None
    )
    if levels is not None:
        image_views = [
            replace(s, level=levels.mean, gain=float(gain))
            for s, gain in zip(image_views, levels.gain, strict=True)
        ]
    store = blend_tiles(
        surface, grid, footprints, image_views, LIMITS, 1, options.tile_px, stream, scratch
    )
    return SonarMosaic(
        store=store,
        light_corrected=levels is not None,
        footprints=footprints,
        contrast=None if levels is None else levels.contrast,
    )


def learn_levels(
    surface: MosaicSurface,
    image_views: Sequence[SonarView],
    footprints: Footprints,
    min_cosine: float,
    scratch: BinaryIO,
) -> ReturnLevels | None:
    """Estimate the mean gray level of hull at each range and beam, and the gain of each ping.

    With these a mosaic is made that shows the hull, not how the sonar looked at it. The mean
    contains beam pattern, spreading loss and grazing angle. Only pixels that show visible
    surface count, so that neither the water before the first return nor shadows darken the mean.

    Parameters
    ----------
    surface
        The hull.
    image_views, footprints
        All pings, and where they met the surface.
    min_cosine
        Cosine of the flattest incidence at which a texel counts.
    scratch
        A file to which data are appended.

    Returns
    -------
    ReturnLevels or None
        None with fewer than MIN_SAMPLES texels.
    """
    grid = grid_around(footprints.at.reshape(-1, 2), LEVEL_STEP_M)
    shape = image_views[0].image.shape
    # For each pixel of the sonar's image, how often it showed hull, and the sum of its gray levels
    total, count = np.zeros(shape), np.zeros(shape)
    # Number of pixels that show hull, and the sums of their gray levels as logged and turned
    shown = np.zeros(3)
    cells = _HullCells(scratch, len(image_views))
    windows = footprint_windows(grid, footprints)
    for tile in grid.parts(BLOCK):
        patch = sample_surface(surface, grid, tile)
        for k, image_view in enumerate(image_views):
            window = windows[k].meet(tile)
            if window.empty:
                continue
            part = patch.part(window.within(tile))
            cell = _hull_cells(surface, image_view, part, min_cosine)
            cells.append(k, cell)
            flat = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape)
            total += flat * image_view.image
            count += flat
            image, hull = image_view.image, flat > 0
            shown += hull.sum(), image[hull].sum(), image[:, ::-1][hull].sum()
    if count.sum() < MIN_SAMPLES:
        return None
    # The gain of a ping: its own gray levels against the mean at the same pixels
    mean = _smooth(total, count)
    gain = [
        _gain(s.image.ravel()[cell], mean.ravel()[cell])
        for s, cell in zip(image_views, cells.by_ping(), strict=True)
    ]
    whole = max(float(np.mean([s.image.mean() for s in image_views])), 1e-9)
    logged, turned = (shown[1:] / shown[0] / whole).tolist()
    contrast = Contrast(logged=logged, turned=turned)
    return ReturnLevels(mean=mean, gain=np.array(gain), contrast=contrast)


class _HullCells:
    """Flat indices of each ping's pixels that show hull, kept in a file: a ping has thousands."""

    def __init__(self, file: BinaryIO, pings: int) -> None:
        self._file = file
        # For each ping, the byte at which each part begins, and its number of indices
        self._parts: list[list[tuple[int, int]]] = [[] for _ in range(pings)]

    def append(self, ping: int, cells: Ints) -> None:
        """Add indices to those of a ping."""
        if len(cells):
            self._parts[ping].append((self._file.seek(0, 2), len(cells)))
            self._file.write(cells.astype(np.uint32).tobytes())

    def by_ping(self) -> Iterator[Ints]:
        """Yield the indices of each ping."""
        for parts in self._parts:
            yield np.concatenate(
                [np.zeros(0, np.int64), *(self._read(at, length) for at, length in parts)]
            )

    def _read(self, at: int, length: int) -> Ints:
        self._file.seek(at)
        return np.frombuffer(self._file.read(4 * length), np.uint32).astype(np.int64)


def _hull_cells(
    surface: MosaicSurface, image_view: SonarView, patch: SurfacePatch, min_cosine: float
) -> Ints:
    """Find the pixels of a ping that show hull: the flat index of each visible texel's pixel.

    min_cosine: least cosine of the incidence at which a texel is seen. A pixel that shows several
    texels occurs several times, and so has the weight of their area.
    """
    point = patch.point.reshape(-1, 3)
    rows = np.flatnonzero(np.isfinite(point[:, 0]))
    pixel, ratio = image_view.project(point[rows])
    in_fan = np.isfinite(ratio)
    is_visible, _ = find_visible(surface, patch, rows[in_fan], image_view.center, min_cosine)
    near = np.rint(pixel[in_fan][is_visible]).astype(np.int64)
    return np.asarray(near[:, 1] * image_view.image.shape[1] + near[:, 0])


def _gain(values: NDArray[np.uint8], means: Array) -> float:
    """Estimate the ratio of a ping's brightness to the mean, limited to a factor of two.

    1 with fewer than MIN_SAMPLES pixels. values, means (n,): gray levels of the ping's hull pixels,
    and the mean levels there.
    """
    if len(values) < MIN_SAMPLES:
        return 1.0
    return float(np.clip(values.astype(float).sum() / max(means.sum(), 1e-9), 0.5, 2.0))


def _smooth(total: Array, count: Array) -> Array:
    """Compute the smoothed mean of pixels from their `total` and `count`, both (beams, ranges).

    The Gaussian's sigma is 2 beams and 3 range bins, and four times as much where few samples are
    near.
    """
    from scipy.ndimage import gaussian_filter

    wide = gaussian_filter(total, (8, 12), mode="nearest") / np.maximum(
        gaussian_filter(count, (8, 12), mode="nearest"), 1e-9
    )
    fine_count = gaussian_filter(count, (2, 3), mode="nearest")
    fine = gaussian_filter(total, (2, 3), mode="nearest") / np.maximum(fine_count, 1e-9)
    share = np.minimum(fine_count, 1.0)
    return np.asarray(np.maximum(share * fine + (1 - share) * wide, 1.0))
