# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Small sound files of an ARIS and of a DIDSON, written field by field."""

from __future__ import annotations

import struct

import numpy as np

START_US = 1_777_887_000_000_000  # 2026-05-04T09:30:00Z
HEADER = 1024
BEAMS = {1: 48, 3: 96, 6: 64, 9: 128}


def frame(number: int = 0, samples: int = 8, **more: float) -> bytes:
    """Return a frame of noise. more: mode (of pings), model, lens, time_us, period_us, delay_us,
    speed, ordered, on, pan, claimed (samples a beam, where its header lies).
    """
    head = bytearray(HEADER)
    mode = int(more.get("mode", 6))
    struct.pack_into(
        "<IQ4s", head, 0, number, int(more.get("time_us", START_US + 200_000 * number)), b"DDF\x05"
    )
    struct.pack_into("<f", head, 244, more.get("pan", 0.0))
    struct.pack_into("<I", head, 436, mode)
    struct.pack_into(
        "<IIff",
        head,
        452,
        int(more.get("period_us", 10)),
        int(more.get("on", 1)),
        5.0,
        more.get("speed", 1500.0),
    )
    struct.pack_into("<I", head, 468, int(more.get("claimed", samples)))
    struct.pack_into(
        "<III",
        head,
        476,
        int(more.get("delay_us", 2000)),
        int(more.get("lens", 0)),
        int(more.get("model", 1)),
    )
    struct.pack_into("<I", head, 516, int(more.get("ordered", 1)))
    pixels = np.random.default_rng(number).integers(
        0, 255, samples * BEAMS.get(mode, 48), dtype=np.uint8
    )
    return bytes(head) + pixels.tobytes()


def file_header(beams: int = 64, samples: int = 8) -> bytes:
    """Return the header of a file."""
    head = bytearray(HEADER)
    struct.pack_into("<4sIIIIfI", head, 0, b"DDF\x05", 0, 0, 1, beams, 0.0, samples)
    return bytes(head)


def aris_file(count: int = 4, **more: float) -> bytes:
    """Return a file of so many frames."""
    return file_header() + b"".join(frame(n, **more) for n in range(count))


def didson_file(version: int, count: int = 2, beams: int = 48) -> bytes:
    """Return a DIDSON's file of so many frames of noise, 512 samples a beam."""
    before, header = {3: (512, 256), 4: (1024, 1024)}[version]
    magic = b"DDF" + bytes([version])
    out = struct.pack("<4sIIII", magic, count, 8, 0, beams).ljust(before, b"\0")
    for number in range(count):
        pixels = np.random.default_rng(number).integers(0, 255, 512 * beams, dtype=np.uint8)
        out += struct.pack("<IQ4s", number, 0, magic).ljust(header, b"\0") + pixels.tobytes()
    return out
