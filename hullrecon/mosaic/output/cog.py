# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Cloud-optimised GeoTIFFs, written block by block.

GDAL's own driver copies a whole file, and on a full disk it prints and raises errors without a
number. Here GDAL makes the tags alone. The file has the order that programs reading over a network
expect: first the directories, then the overviews from the smallest on, the full size last.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.output.tile_store import (
    CompressedTiles,
    append,
    block_means,
    read_at,
)
from hullrecon.threads import in_threads

BLOCK = 512  # px, side of a block of the file
SMALLEST = 256  # px, overviews are made until neither side is longer than this
# zlib's level: on a mosaic and on rasters of metres, 2 took two thirds of the time of 4 for 8 %
# more bytes, and 4 a quarter of the time of 6
DEFLATE = 2
CLASSIC_BYTES = 2**32 - 2**20  # longer files are BigTIFF
_HEAD = (
    "LAYOUT=IFDS_BEFORE_DATA\nBLOCK_ORDER=ROW_MAJOR\nBLOCK_LEADER=SIZE_AS_UINT4\n"
    "BLOCK_TRAILER=LAST_4_BYTES_REPEATED\nKNOWN_INCOMPATIBLE_EDITION=NO\n "
)
# Text between header and directories by which GDAL knows the order of the file
GHOST = f"GDAL_STRUCTURAL_METADATA_SIZE={len(_HEAD):06d} bytes\n{_HEAD}".encode()
_SUBFILE, _WIDTH, _HEIGHT, _PREDICTOR, _OFFSETS, _COUNTS = 254, 256, 257, 317, 324, 325
# Tags that overviews do not have: description, software, georeference, names and units of bands
_OF_FULL_SIZE = {270, 305, 33550, 33922, 34735, 34736, 34737, 42112}
_BYTES_OF_TYPE = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 7: 1, 11: 4, 12: 8, 16: 8}
_LONG, _LONG8 = 4, 16


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A picture stored as tiles, from which any window can be read, maybe turned."""

    tiles: CompressedTiles  # (size, size, bands) or (size, size), in row-major order
    size: int  # px, side of a tile
    width: int
    height: int
    mirrored: bool = False  # the picture shows the stored raster with left and right exchanged
    upside_down: bool = False  # the picture shows it with top and bottom exchanged

    @property
    def bands(self) -> int:
        return self.tiles.shape[2] if len(self.tiles.shape) == 3 else 1

    def read(self, window: Window) -> NDArray[np.generic]:
        """Read a window (h, w, bands) of the picture. Zero where it is outside of the picture."""
        # Copy from the stored tiles what the window shows of each, then turn it as the picture is
        block = np.zeros((*window.shape, self.bands), self.tiles.dtype)
        grid = TexelGrid(0.0, 0.0, 1.0, self.height, self.width)
        asked = window.meet(grid.whole)
        stored = self._turn(asked)
        part = np.zeros((*stored.shape, self.bands), self.tiles.dtype)
        across = -(-self.width // self.size)
        for row in range(stored.top // self.size, -(-stored.bottom // self.size)):
            for column in range(stored.left // self.size, -(-stored.right // self.size)):
                top, left = row * self.size, column * self.size
                tile = Window(top, top + self.size, left, left + self.size)
                both = tile.meet(stored)
                values = np.atleast_3d(self.tiles[row * across + column])
                part[both.within(stored)] = values[both.within(tile)]
        part = part[:: -1 if self.upside_down else 1, :: -1 if self.mirrored else 1]
        block[asked.within(window)] = part
        return block

    def _turn(self, window: Window) -> Window:
        """Find the window of the stored raster that a window of the picture shows."""
        top, bottom, left, right = window.top, window.bottom, window.left, window.right
        if self.upside_down:
            top, bottom = self.height - bottom, self.height - top
        if self.mirrored:
            left, right = self.width - right, self.width - left
        return Window(top, bottom, left, right)


@dataclass(frozen=True, kw_only=True)
class Level:
    """The compressed blocks of the picture in one size, in row-major order."""

    width: int
    height: int
    at: list[int]  # byte of the scratch file at which each block begins
    sizes: list[int]  # bytes of each block


def write_cog(
    path: Path, picture: Picture, template: bytes, nodata: float | None, scratch: BinaryIO
) -> list[Picture]:
    """Write a picture with its overviews as a cloud-optimised GeoTIFF.

    Parameters
    ----------
    path
        Where the file is written.
    picture
        The picture in full size, which is read block by block.
    template
        A TIFF of one sparse block with the tags of the picture.
    nodata
        Value of texels without data, None if the last band is alpha.
    scratch
        A file for the compressed blocks and the reduced pictures.

    Returns
    -------
    list of Picture
        The picture and its overviews, each half as large as the one before.
    """
    tags = read_tags(template)
    predictor = struct.unpack("<H", tags[_PREDICTOR][1])[0]
    # Compress and halve the picture until it is small enough
    levels, pictures = [], [picture]
    while True:
        reduced, level = _compress(picture, predictor, nodata, scratch)
        levels.append(level)
        if max(picture.width, picture.height) <= SMALLEST:
            break
        picture = Picture(
            tiles=reduced,
            size=BLOCK // 2,
            width=-(-picture.width // 2),
            height=-(-picture.height // 2),
        )
        pictures.append(picture)
    with path.open("wb") as file:
        _assemble(file, levels, tags, scratch)
    return pictures


def _compress(
    picture: Picture, predictor: int, nodata: float | None, scratch: BinaryIO
) -> tuple[CompressedTiles, Level]:
    """Compress a picture by blocks of the file, and halve it in the same pass.

    Each block (BLOCK texels a side) is read once. Reduced to half its side, it is one tile of the
    halved picture.

    Parameters
    ----------
    picture
        The picture in full size, or an overview.
    predictor
        Number of TIFF's predictor, 2 or 3, as for `predict`.
    nodata
        Value of texels without data, None if the last band is alpha.
    scratch
        File for the compressed blocks and tiles.

    Returns
    -------
    reduced, level
        The tiles of the picture of half the size, and where the compressed blocks are.
    """
    shape = (BLOCK // 2, BLOCK // 2, picture.bands)
    reduced = CompressedTiles(shape, picture.tiles.dtype, scratch)
    level = Level(width=picture.width, height=picture.height, at=[], sizes=[])

    def make(window: Window) -> tuple[bytes, bytes]:
        """Compress the block of a window, and the tile of the picture of half the size."""
        block = picture.read(window)
        # Beyond the edge `read` gives zero, which would be a value of a raster of metres
        if nodata is not None and nodata != 0:
            block[picture.height - window.top :] = nodata
            block[:, picture.width - window.left :] = nodata
        data = zlib.compress(predict(block, predictor), DEFLATE)
        return data, reduced.pack(halve(block, nodata))

    blocks = TexelGrid(0.0, 0.0, 1.0, picture.height, picture.width).tiles(BLOCK)
    for data, half in in_threads(make, list(blocks)):
        level.at.append(append(scratch, data))
        level.sizes.append(len(data))
        reduced.add_packed(half)
    return reduced, level


def halve(block: NDArray[np.generic], nodata: float | None) -> NDArray[np.generic]:
    """Halve a block (h, w, bands) by the mean of each 2 x 2 texels that have data.

    It is without data where none of the four has. Where the last band is alpha (`nodata` is None),
    texels are weighted by it.
    """
    values = block.astype(np.float32)
    if nodata is None:
        weight = values[..., -1:].copy()
    else:
        known = np.isfinite(values) if np.isnan(nodata) else values != nodata
        weight = known.astype(np.float32)
        values[~known] = 0
    total = block_means(weight, 2)
    values *= weight
    mean = block_means(values, 2) / np.maximum(total, 1e-9)
    if nodata is None:
        mean[..., -1:] = total
    else:
        mean[total == 0] = nodata
    whole = np.issubdtype(block.dtype, np.integer)
    return np.asarray(np.rint(mean) if whole else mean, block.dtype)


def predict(block: NDArray[np.generic], predictor: int) -> bytes:
    """Make the bytes of differences along rows, which deflate compresses better.

    `predictor`: its number in TIFF, 2 for integers and 3 for floats.
    """
    height, width, bands = block.shape
    if predictor == 2:
        unsigned = block.view(f"u{block.dtype.itemsize}")
        return np.diff(unsigned, axis=1, prepend=unsigned.dtype.type(0)).tobytes()
    # Floats: a row's bytes are reordered, all highest ones first, then the next, and differenced
    size = block.dtype.itemsize
    rows = block.astype(f">f{size}").view(np.uint8).reshape(height, width * bands, size)
    planes = rows.transpose(0, 2, 1).reshape(height, -1)
    return np.diff(planes, axis=1, prepend=np.uint8(0)).tobytes()


def read_tags(tiff: bytes) -> dict[int, tuple[int, bytes]]:
    """Read the first directory of a little-endian classic TIFF: (type, bytes) of each tag.

    Values of up to four bytes stand in the entry itself, longer ones where it points to.
    """
    (at,) = struct.unpack_from("<I", tiff, 4)
    (count,) = struct.unpack_from("<H", tiff, at)
    tags = {}
    for entry in range(at + 2, at + 2 + 12 * count, 12):
        tag, kind, length = struct.unpack_from("<HHI", tiff, entry)
        size = _BYTES_OF_TYPE[kind] * length
        start = entry + 8 if size <= 4 else struct.unpack_from("<I", tiff, entry + 8)[0]
        tags[tag] = (kind, tiff[start : start + size])
    return tags


@dataclass(frozen=True)
class _Format:
    """The layout of a TIFF: classic with 32-bit offsets, or BigTIFF with 64-bit offsets."""

    big: bool  # BigTIFF

    @property
    def header(self) -> bytes:
        """Header of a classic TIFF or BigTIFF, which points behind GHOST, and GHOST."""
        ghost_end = len(GHOST) + len(GHOST) % 2
        if self.big:
            return struct.pack("<2sHHHQ", b"II", 43, 8, 0, 16 + ghost_end) + GHOST.ljust(ghost_end)
        return struct.pack("<2sHI", b"II", 42, 8 + ghost_end) + GHOST.ljust(ghost_end)

    def directory(self, at: int, tags: Mapping[int, tuple[int, bytes]], *, last: bool) -> bytes:
        """Make the bytes of a directory, followed by the values that do not fit into it.

        Parameters
        ----------
        at
            Byte of the file at which the directory begins.
        tags
            (type, bytes) by tag.
        last
            Whether no directory follows.
        """
        # Formats of an offset and of the number of entries, and bytes of an entry
        offset_format, count_format, entry_bytes = (
            ("<Q", "<Q", 20) if self.big else ("<I", "<H", 12)
        )
        offset_bytes = struct.calcsize(offset_format)
        head = struct.calcsize(count_format) + entry_bytes * len(tags) + offset_bytes
        entries, values = b"", b""
        for tag, (kind, data) in sorted(tags.items()):
            length = len(data) // _BYTES_OF_TYPE[kind]
            entries += struct.pack("<HH", tag, kind) + struct.pack(offset_format, length)
            if len(data) <= offset_bytes:
                entries += data.ljust(offset_bytes, b"\0")
            else:
                entries += struct.pack(offset_format, at + head + len(values))
                values += data + b"\0" * (len(data) % 2)
        following = 0 if last else at + head + len(values)
        number, link = struct.pack(count_format, len(tags)), struct.pack(offset_format, following)
        return number + entries + link + values


def _assemble(
    file: BinaryIO,
    levels: list[Level],
    tags: Mapping[int, tuple[int, bytes]],
    scratch: BinaryIO,
) -> None:
    """Write the directories, then the blocks from the smallest picture to the full size.

    Each block stands between its length and a copy of its last four bytes. GHOST, in the header,
    tells readers so.
    """
    whole = sum(size + 8 for level in levels for size in level.sizes)
    form = _Format(whole > CLASSIC_BYTES)
    # The length of the directories does not depend on the offsets that they hold. So they are made
    # with zeros first, which shows where the blocks begin.
    starts = [[0] * len(level.sizes) for level in levels]
    at = len(_directories(form, levels, tags, starts))
    for level, start in zip(reversed(levels), reversed(starts), strict=True):
        for k, size in enumerate(level.sizes):
            start[k] = at + 4
            at += size + 8
    file.write(_directories(form, levels, tags, starts))
    for level in reversed(levels):
        for place, size in zip(level.at, level.sizes, strict=True):
            data = read_at(scratch, place, size)
            file.write(struct.pack("<I", size) + data + data[-4:])


def _directories(
    form: _Format,
    levels: list[Level],
    tags: Mapping[int, tuple[int, bytes]],
    starts: list[list[int]],
) -> bytes:
    """Make the bytes of the header and of one directory for each level.

    `starts`: byte of the file at which each block of each level begins.
    """
    data = form.header
    kind, letter = (_LONG8, "Q") if form.big else (_LONG, "I")
    for k, (level, start) in enumerate(zip(levels, starts, strict=True)):
        own = dict(tags) if k == 0 else {t: v for t, v in tags.items() if t not in _OF_FULL_SIZE}
        own |= {
            _SUBFILE: (_LONG, struct.pack("<I", int(k > 0))),
            _WIDTH: (_LONG, struct.pack("<I", level.width)),
            _HEIGHT: (_LONG, struct.pack("<I", level.height)),
            _OFFSETS: (kind, struct.pack(f"<{len(start)}{letter}", *start)),
            _COUNTS: (_LONG, struct.pack(f"<{len(start)}I", *level.sizes)),
        }
        data += form.directory(len(data), own, last=k == len(levels) - 1)
    return data
