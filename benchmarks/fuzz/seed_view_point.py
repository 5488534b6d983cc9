# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Small logs of Oculus ViewPoint, written field by field."""

from __future__ import annotations

import struct
import zlib

from benchmarks.fuzz.seed_files import oculus_ping

START_S = 1_777_887_000.0  # 2026-05-04T09:30:00Z


def file_header(encryption: int = 0) -> bytes:
    """Return the header of a file."""
    return struct.pack("<II16sHH4xqd", 0x11223344, 48, b"Oculus", 1, encryption, 0, START_S)


def item(payload: bytes, number: int = 0, **more: float) -> bytes:
    """Return an item, a fifth of a second after the one before. more: kind, time_s, compression,
    original, claimed (bytes), size (of the header).
    """
    packed = int(more.get("compression", 0))
    data = struct.pack(">I", len(payload)) + zlib.compress(payload) if packed == 1 else payload
    size = int(more.get("size", 40))
    head = struct.pack(
        "<IIHH4xdHxxIII",
        0xAABBCCDD,
        size,
        int(more.get("kind", 10)),
        0,
        more.get("time_s", START_S + 0.2 * number),
        packed,
        int(more.get("original", len(payload))),
        int(more.get("claimed", len(data))),
        0,
    )
    return head.ljust(size, b"\0") + data


def oculus_file(count: int = 4, **more: float) -> bytes:
    """Return a log of so many pings, with an item of settings before them."""
    return (
        file_header()
        + item(b"settings", kind=1)
        + b"".join(item(oculus_ping(), n, **more) for n in range(count))
    )
