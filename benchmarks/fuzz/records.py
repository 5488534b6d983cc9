# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find where the records of a sound binary file start: those are the places where damage leads a
reader astray.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache

MCAP, BAG, PNG, GLB = b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n", b"\x89PNG\r\n\x1a\n", b"glTF"
ARIS, VIEW_POINT = b"DDF\x05", b"\x44\x33\x22\x11"


@lru_cache(maxsize=64)
def record_starts(data: bytes) -> tuple[int, ...]:
    """Return the offsets of the records of an MCAP, ROS 1 bag, PNG, GLB, JPEG, zip, PD0, AD2CP,
    ARIS or ViewPoint log; none for others.
    """
    if data.startswith(MCAP):
        return tuple(
            _walk(data, len(MCAP), len(data) - len(MCAP), lambda at: 9 + _number(data, at + 1, 8))
        )
    if data.startswith(BAG):
        return tuple(_walk(data, len(BAG), len(data), lambda at: 4 + _number(data, at, 4)))
    if data.startswith(PNG):
        return tuple(
            _walk(
                data, len(PNG), len(data), lambda at: 12 + int.from_bytes(data[at : at + 4], "big")
            )
        )
    if data.startswith(GLB):
        return tuple(_walk(data, 12, len(data), lambda at: 8 + _number(data, at, 4)))
    if data.startswith(ARIS):
        return tuple(at - 12 for at in _found(data, ARIS) if at >= 1024)
    if data.startswith(VIEW_POINT):
        return tuple(_walk(data, 48, len(data), lambda at: 40 + _number(data, at + 32, 4)))
    for start in (b"PK", b"\x7f\x7f", b"\xa5", b"\xff\xd8"):
        if data.startswith(start):
            return tuple(_found(data, start[:1] if start == b"\xff\xd8" else start))
    return ()


def _walk(data: bytes, start: int, end: int, length: Callable[[int], int]) -> Iterator[int]:
    at = start
    while at < end:
        yield at
        at += length(at)


def _found(data: bytes, start: bytes) -> Iterator[int]:
    at = data.find(start)
    while at >= 0:
        yield at
        at = data.find(start, at + 1)


def _number(data: bytes, at: int, width: int) -> int:
    return int.from_bytes(data[at : at + width], "little")
