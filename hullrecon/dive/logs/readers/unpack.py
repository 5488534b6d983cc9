# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Decompression and text of damaged files: whatever is wrong with the bytes comes back as one exception, `DamagedError`."""

from __future__ import annotations

import bz2
import struct

LARGEST_CHUNK = 2**31  # bytes; a size beyond it is a damaged field, not a chunk


class DamagedError(ValueError):
    """These bytes are not what they should be. Caught by the readers, which go on behind them."""


def decompress(data: bytes, how: str, size: int) -> bytes:
    """Return `size` bytes of a chunk packed as "", "none", "zstd", "lz4" or "bz2"; DamagedError when they are not there."""
    if size > LARGEST_CHUNK:
        raise DamagedError(f"it claims {size} bytes")
    unpack = {"": lambda: data, "none": lambda: data, "zstd": lambda: _zstd(data, size), "lz4": lambda: _lz4(data, size),
              "bz2": lambda: bz2.BZ2Decompressor().decompress(data, size + 1)}.get(how)  # fmt: skip
    if unpack is None:
        raise DamagedError(f"its compression {how!r} is not known")
    try:
        out = unpack()
    except (OSError, EOFError, RuntimeError, ValueError, MemoryError) as error:
        raise DamagedError(f"it cannot be decompressed: {error}") from None
    if len(out) != size:
        raise DamagedError(f"it holds {len(out)} bytes instead of {size}")
    return out


def text(data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError:
        raise DamagedError("a name is not UTF-8") from None


def fields(layout: str, data: bytes, offset: int = 0) -> tuple[int, ...]:
    """Unpack fields as struct.unpack_from does; raises DamagedError when the bytes end too early."""
    try:
        return struct.unpack_from(layout, data, offset)
    except struct.error:
        raise DamagedError("it ends too early") from None


def _zstd(data: bytes, size: int) -> bytes:
    import zstandard

    try:
        claimed = zstandard.frame_content_size(data)
        if claimed not in (-1, size):
            raise DamagedError(f"it claims {claimed} bytes instead of {size}")
        return zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
    except zstandard.ZstdError as error:
        raise DamagedError(f"it cannot be decompressed: {error}") from None


def _lz4(data: bytes, size: int) -> bytes:
    import lz4.frame  # type: ignore[import-untyped]

    return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, size + 1))
