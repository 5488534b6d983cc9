# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find Nortek AD2CP blocks in a file. A header has a checksum of its own and one of its data.

Layout: Nortek, Signature Integrator's Guide 6.1 [NortekAD2CP].
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.readers.unpack import DamagedError, fields

SYNC, FAMILY = 0xA5, 0x10
SHORT, LONG = 10, 12  # bytes of a header; the long one has 32 bits for the size of its data
CHECKSUM_START = 0xB58C
# bytes; a block with more is an echo sounder's raw samples, which are not read
LARGEST_DATA = 1 << 20
# bytes that are searched at a time, and that are read beyond so that the longest block is whole
WINDOW, REACH = 1 << 20, LARGEST_DATA + LONG


@dataclass(frozen=True)
class Block:
    """One block whose two checksums hold."""

    kind: int  # the number of its data series
    data: bytes  # what lies behind its header


def is_ad2cp(start: bytes) -> bool:
    """Tell whether a file starts with a block of this family (Nortek's Nucleus has another)."""
    return (
        len(start) >= SHORT
        and start[0] == SYNC
        and start[1] in (SHORT, LONG)
        and start[3] == FAMILY
    )


def blocks(stream: BinaryIO) -> Iterator[tuple[int, int, Block | str]]:
    """Yield (start, end, block) of whole blocks, and (start, end, why) of bytes between them.

    The bytes between are damaged, or of blocks that are not read. start, end: bytes of the file.
    """
    at = bad = 0  # where the search is, and where bytes of no block begin
    why = ""
    while True:
        stream.seek(at)
        data = stream.read(WINDOW + REACH)
        if not data:
            break
        starts, ends = _whole_blocks(data)
        inside, limit = 0, min(WINDOW, len(data))
        while inside < limit:
            row = int(np.searchsorted(starts, inside))
            if row == len(starts) or starts[row] != inside:
                why = why or _why_none(data, inside)
                inside = min(int(starts[row]), limit) if row < len(starts) else limit
                continue
            if at + inside > bad:
                yield bad, at + inside, why
            bad, why = at + int(ends[row]), ""
            yield (
                at + inside,
                bad,
                Block(data[inside + 2], data[inside + data[inside + 1] : int(ends[row])]),
            )
            inside = int(ends[row])
        at += inside
    if at > bad:
        yield bad, at, why


def checksum(data: bytes) -> int:
    """Compute Nortek's checksum of 16-bit words. An odd last byte is the high half of a word."""
    values = np.frombuffer(data, np.uint8)
    return (
        int(
            CHECKSUM_START
            + values[0::2].sum(dtype=np.int64)
            + 256 * values[1::2].sum(dtype=np.int64)
            + _odd(data)
        )
        % 65536
    )


def _odd(data: bytes) -> int:
    """Compute what a sum lacks over an odd number of bytes: the last is the high half of a word."""
    return 255 * data[-1] if len(data) % 2 else 0


def _whole_blocks(data: bytes) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Find starts and ends (m,) of blocks whose header, length and both checksums are right.

    The sum over a block is the difference of two running sums, so that each byte is added once,
    however many headers claim it. Starts are in order. Blocks of more than LARGEST_DATA are left
    out.
    """
    sums = _RunningSums(data)
    starts, ends = [], []
    for size in (SHORT, LONG):
        # the header's own checksum is its last word, that of the data the one before
        at = sums.headers(size)
        at = at[sums.total(at, at + size - 2) == sums.word(at + size - 2)]
        length = sums.word(at + 4) + (65536 * sums.word(at + 6) if size == LONG else 0)
        end = at + size + length
        fits = (length <= LARGEST_DATA) & (end <= len(data))
        at, end = at[fits], end[fits]
        holds = sums.total(at + size, end) == sums.word(at + size - 4)
        starts.append(at[holds])
        ends.append(end[holds])
    found, behind = np.concatenate(starts), np.concatenate(ends)
    order = np.argsort(found)
    return np.asarray(found[order], np.intp), np.asarray(behind[order], np.intp)


class _RunningSums:
    """Sums of the bytes at even and at odd places before each byte, for checksums of any span."""

    def __init__(self, data: bytes) -> None:
        """Sum the bytes at even and at odd places from the start of `data` on."""
        self.values = np.frombuffer(data, np.uint8).astype(np.int64)
        every = np.zeros((2, len(data) + 1), np.int64)
        every[0, 1:][0::2] = self.values[0::2]
        every[1, 1:][1::2] = self.values[1::2]
        self.running = np.cumsum(every, axis=1)  # rows: even places, odd places

    def headers(self, size: int) -> NDArray[np.int64]:
        """Find where a header of that size may begin, by its sync, size and family."""
        v = self.values
        if len(v) < size:
            return np.zeros(0, np.int64)
        last = len(v) - size + 1
        return np.flatnonzero(
            (v[:last] == SYNC) & (v[1 : last + 1] == size) & (v[3 : last + 3] == FAMILY)
        ).astype(np.int64)

    def word(self, at: NDArray[np.int64]) -> NDArray[np.int64]:
        """Read the 16-bit words at these bytes."""
        return self.values[at] + 256 * self.values[at + 1]

    def total(self, start: NDArray[np.int64], end: NDArray[np.int64]) -> NDArray[np.int64]:
        """Compute Nortek's checksum of the bytes from each start up to its end.

        Words of 16 bits begin at `start`: bytes at its parity are their low halves.
        """
        parity = start % 2
        low = self.running[parity, end] - self.running[parity, start]
        high = self.running[1 - parity, end] - self.running[1 - parity, start]
        odd = np.where((end - start) % 2 == 1, 255 * self.values[np.maximum(end - 1, 0)], 0)
        return np.asarray((CHECKSUM_START + low + 256 * high + odd) % 65536)


def _why_none(data: bytes, at: int) -> str:
    """Explain why no whole block starts at a byte."""
    try:
        sync, size, _, family = fields("<4B", data, at)
        if sync != SYNC or size not in (SHORT, LONG):
            return "no block starts there"
        if family != FAMILY:
            return f"its family {family:#04x} is not that of a DVL or Signature"
        (length,) = fields("<I" if size == LONG else "<H", data, at + 4)
        (stated,) = fields("<H", data, at + size - 2)
    except DamagedError:
        return "the last block is cut off"
    if checksum(data[at : at + size - 2]) != stated:
        return "a header's checksum is wrong"
    if length > LARGEST_DATA:
        return f"a block of {length} bytes is longer than any that is read"
    if at + size + length > len(data):
        return "the last block is cut off"
    return "a checksum is wrong"
