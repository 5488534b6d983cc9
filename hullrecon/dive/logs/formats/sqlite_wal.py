# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The write-ahead log beside an SQLite database. SQLite stops at its first damaged frame without a
word: it is looked at first.

Layout and checksum: sqlite.org/fileformat2.html, section 4.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import BinaryIO

HEADER, FRAME_HEAD = 32, 24  # bytes
MAGICS = {0x377F0682: "<", 0x377F0683: ">"}  # byte order of the checksums
WORD = 0xFFFFFFFF
BLOCK = 1 << 20


def describe_damage(path: Path) -> str:
    """Return what of a write-ahead log SQLite will leave aside, though it was written: "" for
    nothing.

    Frames of an older generation (another salt) behind those of the last one are sound, and belong
    to nobody.
    """
    with path.open("rb") as stream:
        header = stream.read(HEADER)
        order = MAGICS.get(int.from_bytes(header[:4], "big"))
        if len(header) < HEADER or order is None:
            return "its header is damaged"
        page = int.from_bytes(header[8:12], "big")
        sums = _checksum(header[:24], order, (0, 0))
        if (
            sums != struct.unpack(">II", header[24:])
            or not 512 <= page <= 65536
            or page & (page - 1)
        ):
            return "its header is damaged"
        count = finished = 0
        while len(frame := stream.read(FRAME_HEAD + page)) == FRAME_HEAD + page:
            found = _checksum(frame[FRAME_HEAD:], order, _checksum(frame[:8], order, sums))
            if frame[8:16] != header[16:24] or found != struct.unpack(">II", frame[16:24]):
                break
            sums, count = found, count + 1
            finished = count if any(frame[4:8]) else finished
        if _holds(stream, frame, header[16:24]):
            return f"it is damaged from frame {count + 1} on"
    if frame and len(frame) < FRAME_HEAD + page:
        return "it is cut off"
    return "its last transaction was not finished" if count > finished else ""


def _holds(stream: BinaryIO, start: bytes, salt: bytes) -> bool:
    """Tell whether the salt stands anywhere in what is left: there, frames of the last generation
    follow, in whatever place.
    """
    while start:
        if salt in start:
            return True
        following = stream.read(BLOCK)
        start = start[-len(salt) + 1 :] + following if following else b""
    return False


def _checksum(data: bytes, order: str, sums: tuple[int, int]) -> tuple[int, int]:
    first, second = sums
    words = iter(struct.unpack(f"{order}{len(data) // 4}I", data))
    for one, two in zip(words, words, strict=True):
        first = (first + one + second) & WORD
        second = (second + two + first) & WORD
    return first, second
