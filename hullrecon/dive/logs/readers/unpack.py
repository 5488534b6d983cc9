# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Decompression, headers and text of damaged files. Any damage raises `DamagedError`."""

from __future__ import annotations

import bz2
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import BinaryIO, Protocol

# bytes; recorders write chunks of 1 to 4 MiB, or of one message; a larger size is a damaged field
LARGEST_CHUNK = 1 << 27
# a log may unpack to the first number of bytes plus the second times its own size
FREE_BYTES, RATIO = 1 << 23, 256
# Bytes that a search reads first. The step then doubles, so that many searches over short distances
# do not each read a whole window
FIRST_STEP = 1 << 14
# Bytes of records that turn out to be none, over the file's size, after which the rest is given up:
# false records may each claim the rest of the file
PATIENCE = 4
LONGEST_NAME = 400  # characters; ROS allows 255, and a line that names one stays a line
# characters of what a library says about damaged bytes: they may quote all of them
LONGEST_REASON = 200


class DamagedError(ValueError):
    """Bytes that are damaged. Caught by the readers, which go on behind them."""


class UnpackBudget:
    """Limits the unpacked size of a log, so that kilobytes do not become hours of work."""

    def __init__(self, size: int) -> None:
        self._left = FREE_BYTES + RATIO * size

    def take(self, size: int) -> None:
        """Charge `size` bytes to the budget. Raises DamagedError when they exceed what is left."""
        if size > self._left:
            raise DamagedError(
                f"with its {size} bytes the log would unpack to more than {RATIO} times its size"
            )
        self._left -= size


def decompress(data: bytes, how: str, size: int, budget: UnpackBudget | None = None) -> bytes:
    """Unpack a chunk packed as "", "none", "zstd", "lz4", "bz2" or "zlib" to `size` bytes.

    Raises DamagedError for another packing, for damaged data, where they unpack to another size,
    and where the size is beyond LARGEST_CHUNK or what is left of the budget.
    """
    if size > LARGEST_CHUNK:
        raise DamagedError(f"it claims {size} bytes")
    unpack = {
        "": lambda: data,
        "none": lambda: data,
        "zstd": lambda: _zstd(data, size),
        "lz4": lambda: _lz4(data, size),
        "bz2": lambda: _to_the_end(bz2.BZ2Decompressor(), data, size),
        "zlib": lambda: _to_the_end(zlib.decompressobj(), data, size),
    }.get(how)
    if unpack is None:
        raise DamagedError(f"its compression {printable(how)!r} is not known")
    if budget is not None and how not in ("", "none"):
        budget.take(size)
    try:
        out = unpack()
    except (OSError, EOFError, RuntimeError, ValueError, MemoryError, zlib.error) as error:
        raise DamagedError(f"it cannot be decompressed: {error}") from None
    if len(out) != size:
        raise DamagedError(f"it holds {len(out)} bytes instead of {size}")
    return out


def decompress_start(data: bytes, how: str, budget: UnpackBudget) -> bytes:
    """Unpack what is there of a chunk that is cut off, LARGEST_CHUNK at most.

    Nothing of it is checked. Raises DamagedError for damaged data, and beyond the budget.
    """
    import lz4.frame  # type: ignore[import-untyped]
    import zstandard

    try:
        if how == "zstd":
            data = zstandard.ZstdDecompressor().stream_reader(data).read(LARGEST_CHUNK)
        elif how == "lz4":
            data = lz4.frame.LZ4FrameDecompressor().decompress(data, LARGEST_CHUNK)
        elif how == "bz2":
            data = bz2.BZ2Decompressor().decompress(data, LARGEST_CHUNK)
    except (zstandard.ZstdError, OSError, RuntimeError) as error:
        raise DamagedError(f"it cannot be decompressed: {error}") from None
    budget.take(len(data))
    return data


def unpack_frame(data: bytes, budget: UnpackBudget) -> bytes:
    """Unpack one zstd frame, which need not state its size.

    Raises DamagedError where it is damaged, larger than LARGEST_CHUNK, or beyond the budget.
    """
    import zstandard

    try:
        size = zstandard.frame_content_size(data)
        if size >= 0:
            return decompress(data, "zstd", size, budget)
        out = bytes(zstandard.ZstdDecompressor().stream_reader(data).read(LARGEST_CHUNK + 1))
    except zstandard.ZstdError as error:
        raise DamagedError(f"it cannot be decompressed: {error}") from None
    if len(out) > LARGEST_CHUNK:
        raise DamagedError(f"it holds more than {LARGEST_CHUNK} bytes")
    budget.take(len(out))
    return out


def text(data: bytes) -> str:
    """Decode a name. Raises DamagedError when it is not UTF-8."""
    try:
        return data.decode()
    except UnicodeDecodeError:
        raise DamagedError("a name is not UTF-8") from None


def printable(name: str, longest: int = LONGEST_NAME) -> str:
    """Escape what is not printable, so that a name is shown on one line and terminals ignore it."""
    shown = (
        name
        if name.isprintable()
        else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in name[: longest + 1])
    )
    return shown if len(shown) <= longest else f"{shown[: longest - 3]}..."


def fields(layout: str, data: bytes, offset: int = 0) -> tuple[int, ...]:
    """Unpack fields as struct.unpack_from does.

    Raises DamagedError when the bytes end too early.
    """
    try:
        return struct.unpack_from(layout, data, offset)
    except struct.error:
        raise DamagedError("it ends too early") from None


def _zstd(data: bytes, size: int) -> bytes:
    """Unpack zstd data to `size` bytes. Raises DamagedError."""
    import zstandard

    try:
        claimed = zstandard.frame_content_size(data)
        if claimed not in (-1, size):
            raise DamagedError(f"it claims {claimed} bytes instead of {size}")
        return zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
    except zstandard.ZstdError as error:
        raise DamagedError(f"it cannot be decompressed: {error}") from None


def _lz4(data: bytes, size: int) -> bytes:
    """Unpack LZ4 to the size that the file claims."""
    import lz4.frame

    return _to_the_end(lz4.frame.LZ4FrameDecompressor(), data, size)


class _Decompressor(Protocol):
    """An unpacker of bz2, LZ4 or the like, as in Python's own modules."""

    @property
    def eof(self) -> bool: ...

    def decompress(self, data: bytes, /, max_length: int) -> bytes: ...


def _to_the_end(decompressor: _Decompressor, data: bytes, size: int) -> bytes:
    """Unpack `size` bytes, and require the stream's end, where its own checksum stands."""
    out = bytes(decompressor.decompress(data, size + 1))
    if len(out) == size and not decompressor.eof:
        raise DamagedError("it is cut off before its checksum")
    return out


@dataclass(frozen=True)
class HeaderMark:
    """The marks by which a header is found."""

    magic: bytes
    magic_at: int  # bytes behind the header's start
    header_bytes: int
    parse: Callable[[bytes], object]  # raises DamagedError for what is no header


def find_header(stream: BinaryIO, at: int, end: int, window: int, mark: HeaderMark) -> int:
    """Find the byte, at or after `at`, at which the next header begins.

    Returns `end`, the size of the file, if there is none.

    Parameters
    ----------
    stream : the file
    at, end : where the search begins, and the size of the file
    window : bytes to read at a time, at most
    mark : how a header is recognised
    """
    step = min(FIRST_STEP, window)
    while at < end:
        stream.seek(at)
        data = stream.read(step + mark.header_bytes)
        found = data.find(mark.magic, mark.magic_at)
        while 0 <= found < step + mark.magic_at:
            start = found - mark.magic_at
            try:
                mark.parse(data[start : start + mark.header_bytes])
                return at + start
            except DamagedError:
                found = data.find(mark.magic, found + 1)
        at, step = at + step, min(2 * step, window)
    return end
