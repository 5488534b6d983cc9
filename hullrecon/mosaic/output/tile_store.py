# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Keep the tiles of a mosaic compressed in a file, with a small copy of the whole for pictures."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from threading import Lock
from typing import BinaryIO

import numpy as np
import zstandard
from numpy.typing import NDArray

from hullrecon.mosaic.blend import Tile, ViewLimits, blend_tile
from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.imagery.camera_views import Footprints, ImageView, footprint_windows
from hullrecon.mosaic.mosaic_surface import MosaicSurface, value_type
from hullrecon.mosaic.stream import Stream
from hullrecon.typing import Floats32

TEXTURE_PX = 4096  # longer side of the small copy, which is the GLB's texture
VARIANCE_STEP = 0.25  # step of variances, squared gray levels: finer is noise, compresses badly
PACKING = 1  # zstd's level: a quarter of the time of zlib's lowest level, for as many bytes
_file_position = Lock()  # held while a scratch file is read or written, as it has one position


def append(file: BinaryIO, data: bytes) -> int:
    """Write data at the end of a scratch file, from any thread. Returns the byte of its start."""
    with _file_position:
        at = file.seek(0, 2)
        file.write(data)
    return at


def read_at(file: BinaryIO, at: int, length: int) -> bytes:
    """Read `length` bytes of a scratch file from byte `at` on, from any thread."""
    with _file_position:
        file.seek(at)
        return file.read(length)


def block_means(picture: Floats32, side: int) -> Floats32:
    """Reduce a picture (h, w, bands) by the mean of each square of `side` pixels a side.

    Height and width must be multiples of `side`.
    """
    import cv2

    height, width, bands = picture.shape
    size = (width // side, height // side)
    mean = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return np.asarray(mean, np.float32).reshape(size[1], size[0], bands)


@dataclass
class CompressedTiles:
    """A sequence of arrays of one shape and type, compressed in a file."""

    shape: tuple[int, ...]
    dtype: str
    file: BinaryIO  # scratch file, which may hold other data too
    # Byte of its start in the file, and length, of each array
    _parts: list[tuple[int, int]] = field(default_factory=list)

    def add(self, tile: NDArray[np.generic]) -> None:
        """Compress and keep a tile. Raises ValueError for one of another shape."""
        self.add_packed(self.pack(tile))

    def pack(self, tile: NDArray[np.generic]) -> bytes:
        """Compress a tile. Several threads may do it at once. Raises ValueError as `add`."""
        if tile.shape != self.shape:
            raise ValueError(f"a tile of shape {tile.shape} among those of {self.shape}")
        return zstandard.compress(np.ascontiguousarray(tile, self.dtype).tobytes(), PACKING)

    def add_packed(self, data: bytes) -> None:
        """Keep a compressed tile."""
        self._parts.append((append(self.file, data), len(data)))

    def __getitem__(self, k: int) -> NDArray[np.generic]:
        data = zstandard.decompress(read_at(self.file, *self._parts[k]))
        return np.frombuffer(data, self.dtype).reshape(self.shape)

    def __iter__(self) -> Iterator[NDArray[np.generic]]:
        return (self[k] for k in range(len(self)))

    def __len__(self) -> int:
        return len(self._parts)


@dataclass(frozen=True, kw_only=True)
class PackedTile:
    """A compressed tile, and its contributions to the sums of the store."""

    color: bytes  # compressed, as are variance and counts
    variance: bytes
    counts: bytes
    of_surface: dict[str, bytes]  # compressed values of the surface, by name
    small: NDArray[np.uint8]  # its part of the small copy
    histogram: NDArray[np.int64]  # of its variances
    views: NDArray[np.int64]  # its texels by number of views blended


@dataclass(kw_only=True)
class TileStore:
    """The tiles of a mosaic in the order of grid.tiles(size), with sums over all of them."""

    grid: TexelGrid
    size: int  # px, side of a tile
    channels: int  # of the images, without alpha
    reduction: int  # texels along a pixel of the small copy
    small: NDArray[np.uint8]  # RGBA (or LA) of the whole, reduced by `reduction`
    histogram: NDArray[np.int64]  # of the variance, by VARIANCE_STEP up to 1024
    views: NDArray[np.int64]  # texels by number of views blended, 0 to 4
    color: CompressedTiles  # (size, size, channels + 1) uint8, the last is alpha
    variance: CompressedTiles  # (size, size) float32, NaN where nothing was seen
    counts: CompressedTiles  # (size, size) uint8, views blended
    of_surface: dict[str, CompressedTiles]  # (size, size) values of the surface, by name

    def pack(self, window: Window, tile: Tile) -> PackedTile:
        """Round and compress the tile of a window. Several threads may do it at once.

        Nothing is kept yet: `add` does that, in the order of the windows.
        """
        seen = tile.views > 0
        alpha = np.where(seen, 255, 0).astype(np.uint8)[..., None]
        color = np.concatenate([np.rint(tile.value).astype(np.uint8) * (alpha > 0), alpha], axis=2)
        variance = np.where(
            seen, np.rint(tile.variance / VARIANCE_STEP) * VARIANCE_STEP, np.nan
        ).astype(np.float32)
        # For the histogram the last bin has all larger variances, and texels beyond the raster do
        # not count as unseen
        rows = np.minimum(variance[seen] / VARIANCE_STEP, len(self.histogram) - 1).astype(int)
        inside = tile.views[: self.grid.height - window.top, : self.grid.width - window.left]
        return PackedTile(
            color=self.color.pack(color),
            variance=self.variance.pack(variance),
            counts=self.counts.pack(tile.views),
            of_surface={name: self.of_surface[name].pack(v) for name, v in tile.of_surface.items()},
            small=self._reduce(color),
            histogram=np.bincount(rows, minlength=len(self.histogram)),
            views=np.bincount(inside.ravel(), minlength=len(self.views)),
        )

    def add(self, window: Window, tile: PackedTile) -> None:
        """Keep the tile of a window. Add it to the sums and to the small copy.

        Tiles must come in the order of `grid.tiles(size)`.
        """
        self.color.add_packed(tile.color)
        self.variance.add_packed(tile.variance)
        self.counts.add_packed(tile.counts)
        for name, packed in tile.of_surface.items():
            self.of_surface[name].add_packed(packed)
        self.histogram += tile.histogram
        self.views += tile.views
        top, left = window.top // self.reduction, window.left // self.reduction
        side = self.size // self.reduction
        target = self.small[top : top + side, left : left + side]
        target[...] = tile.small[: target.shape[0], : target.shape[1]]

    def _reduce(self, color: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Reduce a tile for the small copy, by the mean of the seen texels in each block.

        A block is opaque where at least half of it is seen, so that holes of single texels do not
        show. color: (size, size, channels and alpha).
        """
        seen = (color[..., -1:] > 0).astype(np.float32)
        share = block_means(seen, self.reduction)
        mean = block_means(color[..., :-1] * seen, self.reduction)
        mean /= np.maximum(share, self.reduction**-2)
        small = np.concatenate([mean, 255 * np.minimum(1, 2 * share)], axis=2)
        return np.asarray(np.rint(small).astype(np.uint8))

    def variance_percentiles(self, percent: Sequence[float]) -> list[float]:
        """Compute percentiles of the variance from the histogram, as upper ends of its bins."""
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
    of_surface: Collection[str] = (),
) -> TileStore:
    """Make and keep every tile of a grid.

    Parameters
    ----------
    grid
        Texels of the mosaic.
    channels
        Number of channels of the images, without alpha.
    size
        Side of a tile, px.
    max_pixels
        Longer side of the small copy. It is halved until it fits, as often as `size` can be.
    make
        Makes the tile of a window. Called from several threads where `stream` has them.
    stream
        Maps work over threads.
    scratch
        A file that keeps the tiles.
    of_surface
        Names of the surface's values that each tile has.
    """
    # The small copy: its pixels must fill a tile without a rest
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
        of_surface={
            name: CompressedTiles((size, size), value_type(name), scratch) for name in of_surface
        },
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
    """Blend the views on every tile of a grid.

    Parameters
    ----------
    surface, grid
        The surface, and the raster on its chart.
    footprints, image_views
        Where the rays of each image meet the surface, and the images as views.
    limits
        How oblique a view may be, and how much that costs.
    channels
        Number of channels of the images.
    tile_px
        Side of a tile.
    stream
        Maps work over threads.
    scratch
        A file that keeps the tiles.
    """
    windows = footprint_windows(grid, footprints)
    return make_tiles(
        grid,
        channels,
        tile_px,
        TEXTURE_PX,
        lambda window: blend_tile(surface, grid, window, image_views, windows, limits, channels),
        stream,
        scratch,
        surface.values.keys(),
    )
