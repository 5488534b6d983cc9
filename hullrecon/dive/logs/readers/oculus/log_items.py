# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the items of an .oculus file of ViewPoint, also behind damage: each a header and a payload.

Layout: [OculusDriver], little-endian, fields aligned by their size. Each header states its own
length. There are no checksums.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

from hullrecon.dive.logs.formats.oculus_ping import message_bytes
from hullrecon.dive.logs.readers.unpack import (
    PATIENCE,
    DamagedError,
    HeaderMark,
    UnpackBudget,
    decompress,
    fields,
    find_header,
)

MAGIC, ITEM_MAGIC = b"\x44\x33\x22\x11", b"\xdd\xcc\xbb\xaa"
# struct formats; the last field of an item only fills it up to a multiple of eight bytes
FILE_HEADER, ITEM_HEADER = "<II16sHH4xqd", "<IIHH4xdHxxIII"
FILE_HEADER_BYTES, ITEM_HEADER_BYTES = 48, 40
LONGEST_HEADER = 1024
# kinds of compression: none; zlib behind four bytes that tell the length (Qt's qCompress)
PLAIN, PACKED = 0, 1
LENGTH_BYTES = 4
EARLIEST_S, LATEST_S = 1.2e9, 4.1e9  # 2008, before the first Oculus, and 2099
MOST_BYTES = 1 << 26  # of a payload
WINDOW = 1 << 20  # bytes that a search behind damage reads at a time


@dataclass(frozen=True, kw_only=True)
class ItemHeader:
    """The header before a payload."""

    size: int  # bytes of the header itself
    kind: int
    t_ns: int  # by the clock of the computer that recorded it
    is_packed: bool
    original_bytes: int
    payload_bytes: int


def parse_file_header(data: bytes) -> tuple[int, bool]:
    """Read the length of the file's header, and whether the rest is encrypted.

    Raises DamagedError where it is no header.
    """
    if data[: len(MAGIC)] != MAGIC:
        raise DamagedError("no log of ViewPoint begins there")
    _, size, _, _, encryption, _, _ = fields(FILE_HEADER, data)
    if not FILE_HEADER_BYTES <= size <= LONGEST_HEADER:
        raise DamagedError(f"a header of {size} bytes")
    return int(size), bool(encryption)


def parse_item_header(data: bytes) -> ItemHeader:
    """Read an item's header. Raises DamagedError for values that ViewPoint does not write."""
    if data[: len(ITEM_MAGIC)] != ITEM_MAGIC:
        raise DamagedError("no item begins there")
    _, size, kind, _, time_s, compression, original, payload, _ = fields(ITEM_HEADER, data)
    if not ITEM_HEADER_BYTES <= size <= LONGEST_HEADER:
        raise DamagedError(f"an item with a header of {size} bytes")
    if not EARLIEST_S < time_s < LATEST_S:
        raise DamagedError("its item has no time of day")
    if compression not in (PLAIN, PACKED):
        raise DamagedError(f"an item packed in the unknown way {compression}")
    if max(original, payload) > MOST_BYTES:
        raise DamagedError(f"an item of {max(original, payload)} bytes")
    return ItemHeader(
        size=int(size),
        kind=int(kind),
        t_ns=round(time_s * 1e9),
        is_packed=compression == PACKED,
        original_bytes=int(original),
        payload_bytes=int(payload),
    )


def items(
    stream: BinaryIO, at: int, budget: UnpackBudget
) -> Iterator[tuple[int, int, tuple[ItemHeader, bytes] | str]]:
    """Yield (start, end, header and payload) of items, and (start, end, why) of bytes between them.

    An item is accepted if another item or the file's end follows it, or if it holds one whole
    message of an Oculus. False headers may each claim the rest of the file, so that PATIENCE limits
    how much is read for them. Beyond that the rest is one stretch of other bytes.

    Parameters
    ----------
    stream : the file
    at : byte at which the items begin
    budget : limits what they unpack to
    """
    mark = HeaderMark(ITEM_MAGIC, 0, ITEM_HEADER_BYTES, parse_item_header)
    end = stream.seek(0, 2)
    patience = PATIENCE * end
    while at < end:
        read = 0
        try:
            header = _header_at(stream, at, end)
            read = header.payload_bytes
            payload = _payload_at(stream, at + header.size, header, budget)
        except DamagedError as error:
            patience -= read
            following = find_header(stream, at + 1, end, WINDOW, mark) if patience >= 0 else end
            yield at, following, str(error)
            at = following
            continue
        after = at + header.size + header.payload_bytes
        yield at, after, (header, payload)
        at = after


def unpacked(header: ItemHeader, payload: bytes, budget: UnpackBudget) -> bytes:
    """Unpack a payload. Raises DamagedError for another size, and beyond the log's budget."""
    return (
        decompress(payload[LENGTH_BYTES:], "zlib", header.original_bytes, budget)
        if header.is_packed
        else payload
    )


def _header_at(stream: BinaryIO, at: int, end: int) -> ItemHeader:
    """Read the header at a byte, whose payload lies in the file."""
    stream.seek(at)
    header = parse_item_header(stream.read(ITEM_HEADER_BYTES))
    if at + header.size + header.payload_bytes > end:
        raise DamagedError("the file ends within its item")
    return header


def _payload_at(stream: BinaryIO, at: int, header: ItemHeader, budget: UnpackBudget) -> bytes:
    """Read the payload at a byte of the file.

    Raises DamagedError unless another item or the file's end follows, or it is one whole message.
    """
    stream.seek(at)
    payload = stream.read(header.payload_bytes)
    following = stream.read(len(ITEM_MAGIC))
    if following != ITEM_MAGIC[: len(following)] and not _is_whole_message(header, payload, budget):
        raise DamagedError("no other item follows where it ends")
    return payload


def _is_whole_message(header: ItemHeader, payload: bytes, budget: UnpackBudget) -> bool:
    """Tell whether a payload is as long as its message states."""
    try:
        data = unpacked(header, payload, budget)
        return message_bytes(data) == len(data)
    except DamagedError:
        return False
