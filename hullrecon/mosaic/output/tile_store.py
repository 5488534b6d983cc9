# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tiles of a mosaic, compressed in a file, and a small copy of the whole for pictures."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from threading import Lock
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.mosaic.blend import Tile, ViewLimits, blend_tile
from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.imagery.camera_views import Footprints, ImageView, footprint_windows
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.stream import Stream
from hullrecon.typing import Floats32

TEXTURE_PX = 4096  # longer side of the small copy, which is the GLB's texture
VARIANCE_STEP = 0.25  # squared gray levels; finer is noise, and compresses badly
_at_one_place = Lock()  # held while a scratch file is read or written: it has one position


def append(file: BinaryIO, data: bytes) -> int:
    """Write at the end of a scratch file, from any thread. Returns the byte where it begins."""
    with _at_one_place:
        at = file.seek(0, 2)
        file.write(data)
    return at


def read_at(file: BinaryIO, at: int, length: int) -> bytes:
    """Read from a byte of a scratch file on, from any thread."""
    with _at_one_place:
        file.seek(at)
        return file.read(length)


def mean_of_squares(picture: Floats32, side: int) -> Floats32:
    """Average each square of so many pixels a side of a picture (h, w, bands)."""
    import cv2

    height, width, bands = picture.shape
    size = (width // side, height // side)
    mean = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return np.asarray(mean, np.float32).reshape(size[1], size[0], bands)


@dataclass
class CompressedTiles:
    """Arrays of one shape and type in the order in which they were added."""

    shape: tuple[int, ...]
    dtype: str
    file: BinaryIO  # that holds them, perhaps beside others
    _parts: list[tuple[int, int]] = field(default_factory=list)  # byte and length of each

    def add(self, tile: NDArray[np.generic]) -> None:
        """Keep a tile. Raises ValueError for one of another shape."""
        self.add_packed(self.pack(tile))

    def pack(self, tile: NDArray[np.generic]) -> bytes:
        """Compress a tile, which threads may do at once. Raises ValueError as `add`."""
        if tile.shape != self.shape:
            raise ValueError(f"a tile of shape {tile.shape} among those of {self.shape}")
        return zlib.compress(np.ascontiguousarray(tile, self.dtype).tobytes(), 1)

    def add_packed(self, data: bytes) -> None:
        """Keep a compressed tile."""
        self._parts.append((append(self.file, data), len(data)))

    def __getitem__(self, k: int) -> NDArray[np.generic]:
        data = zlib.decompress(read_at(self.file, *self._parts[k]))
        return np.frombuffer(data, self.dtype).reshape(self.shape)

    def __iter__(self) -> Iterator[NDArray[np.generic]]:
        return (self[k] for k in range(len(self)))

    def __len__(self) -> int:
        return len(self._parts)


@dataclass(frozen=True, kw_only=True)
class PackedTile:
    """A tile as it is kept."""

    color: bytes  # compressed, as the variance and the counts
    variance: bytes
    counts: bytes
    small: NDArray[np.uint8]  # its part of the small copy
    histogram: NDArray[np.int64]  # what it adds to those of the store
    views: NDArray[np.int64]


@dataclass(kw_only=True)
class TileStore:
    """Tiles in the order of grid.tiles(size)."""

    grid: TexelGrid
    size: int
    channels: int
    reduction: int
    small: NDArray[np.uint8]  # RGBA (or LA) of the whole, reduced by `reduction`
    histogram: NDArray[np.int64]  # of the variance, by VARIANCE_STEP up to 1024
    views: NDArray[np.int64]  # texels by number of views blended, 0 to 4
    color: CompressedTiles  # (size, size, channels + 1) uint8, the last is alpha
    variance: CompressedTiles  # (size, size) float32, NaN where nothing was seen
    counts: CompressedTiles  # (size, size) uint8, views blended

    def pack(self, window: Window, tile: Tile) -> PackedTile:
        """Round and compress a tile, which threads may do at once."""
        seen = tile.views > 0
        alpha = np.where(seen, 255, 0).astype(np.uint8)[..., None]
        color = np.concatenate([np.rint(tile.value).astype(np.uint8) * (alpha > 0), alpha], axis=2)
        variance = np.where(
            seen, np.rint(tile.variance / VARIANCE_STEP) * VARIANCE_STEP, np.nan
        ).astype(np.float32)
        rows = np.minimum(variance[seen] / VARIANCE_STEP, len(self.histogram) - 1).astype(int)
        inside = tile.views[: self.grid.height - window.top, : self.grid.width - window.left]
        return PackedTile(
            color=self.color.pack(color),
            variance=self.variance.pack(variance),
            counts=self.counts.pack(tile.views),
            small=self._reduce(color),
            histogram=np.bincount(rows, minlength=len(self.histogram)),
            views=np.bincount(inside.ravel(), minlength=len(self.views)),
        )

    def add(self, window: Window, tile: PackedTile) -> None:
        """Keep a tile."""
        self.color.add_packed(tile.color)
        self.variance.add_packed(tile.variance)
        self.counts.add_packed(tile.counts)
        self.histogram += tile.histogram
        self.views += tile.views
        top, left = window.top // self.reduction, window.left // self.reduction
        side = self.size // self.reduction
        target = self.small[top : top + side, left : left + side]
        target[...] = tile.small[: target.shape[0], : target.shape[1]]

    def _reduce(self, color: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Average seen texels in each block, for the small copy.

        A block is opaque where half of it or more is seen, so that holes of single texels do not
        show through.
        """
        seen = (color[..., -1:] > 0).astype(np.float32)
        share = mean_of_squares(seen, self.reduction)
        mean = mean_of_squares(color[..., :-1] * seen, self.reduction)
        mean /= np.maximum(share, self.reduction**-2)
        small = np.concatenate([mean, 255 * np.minimum(1, 2 * share)], axis=2)
        return np.asarray(np.rint(small).astype(np.uint8))

    def variance_percentiles(self, percent: Sequence[float]) -> list[float]:
        """Read percentiles from the histogram, as upper ends of its bins."""
        share = np.cumsum(self.histogram) / max(1, self.histogram.sum())
        return [float((np.searchsorted(share, p / 100) + 1) * VARIANCE_STEP) for p in percent]


def make_tiles(
    grid: TexelGrid,
    channels: int,
    size: int,
    max_pixels: int,
    make: Callable[[Window], Tile],
    stream: Stream,
    scratch: BinaryIO,
) -> TileStore:
    """Make every tile.

    The small copy is reduced to max_pixels a side, or as often as `size` can be halved. `make`:
    called from several threads where `stream` has them. `scratch`: a file that keeps the tiles.
    """
    reduction = 1
    while max(grid.width, grid.height) / reduction > max_pixels and size % (2 * reduction) == 0:
        reduction *= 2
    small = np.zeros(
        (-(-grid.height // reduction), -(-grid.width // reduction), channels + 1), np.uint8
    )
    store = TileStore(
        grid=grid,
        size=size,
        channels=channels,
        reduction=reduction,
        small=small,
        histogram=np.zeros(4096, np.int64),
        views=np.zeros(5, np.int64),
        color=CompressedTiles((size, size, channels + 1), "uint8", scratch),
        variance=CompressedTiles((size, size), "float32", scratch),
        counts=CompressedTiles((size, size), "uint8", scratch),
    )
    windows = list(grid.tiles(size))
    packed = stream(lambda window: store.pack(window, make(window)), windows, "tiles")
    for window, tile in zip(windows, packed, strict=True):
        store.add(window, tile)
    return store


def blend_tiles(
    surface: MosaicSurface,
    grid: TexelGrid,
    footprints: Footprints,
    image_views: Sequence[ImageView],
    limits: ViewLimits,
    channels: int,
    tile_px: int,
    stream: Stream,
    scratch: BinaryIO,
) -> TileStore:
    """Blend all views on every tile of the grid, into a scratch file."""
    windows = footprint_windows(grid, footprints)
    return make_tiles(
        grid,
        channels,
        tile_px,
        TEXTURE_PX,
        lambda window: blend_tile(surface, grid, window, image_views, windows, limits, channels),
        stream,
        scratch,
    )
