# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Small sound AD2CP files of a Nortek DVL and a Signature, written field by field; both checksums
right.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

DF20, DF21, WATER_TRACK, TEXT = 0x17, 0x1B, 0x1D, 0xA0
PHI_DEG = (0, -90, 180, 90)  # of a Signature's beams, from x towards y; its theta is 25 degrees
SUM_START = 0xB58C


def word_sum(data: bytes) -> int:
    """Return Nortek's checksum, word by word."""
    padded = data if len(data) % 2 == 0 else data[:-1] + b"\0" + data[-1:]
    return (SUM_START + sum(struct.unpack(f"<{len(padded) // 2}H", padded))) % 65536


def block(kind: int, data: bytes, *, is_long: bool = False, family: int = 0x10) -> bytes:
    """Return a block with a header of 10 or 12 bytes."""
    size = struct.pack("<I" if is_long else "<H", len(data))
    head = (
        struct.pack("<BBBB", 0xA5, 12 if is_long else 10, kind, family)
        + size
        + struct.pack("<H", word_sum(data))
    )
    return head + struct.pack("<H", word_sum(head)) + data


def configuration(phi_deg: Sequence[float] = PHI_DEG, theta_deg: float = 25.0) -> bytes:
    """Return the text at the start of a file: among others, where the beams point."""
    lines = ['GETCLOCKSTR,TIME="2026-05-04 09:30:00"', 'ID,STR="DVL",SN=100996']
    lines += [
        f"BEAMCFGLIST,BEAM={n},THETA={theta_deg:.2f},PHI={phi:.2f},FREQ=1000"
        for n, phi in enumerate(phi_deg, 1)
    ]
    return block(TEXT, b"\x10" + "\r\n".join([*lines, ""]).encode() + b"\0")


def signature_record(
    number: int = 0, velocity: Sequence[int] = (100, 200, 300, 300), **more: int | Sequence[int]
) -> bytes:
    """Return a DF20 record. velocity: in units of 10^scale m/s. more: code (of the frame), scale,
    heading, pitch, roll (0.01 degrees), orientation, config, distance (mm), merit, physical, count,
    version, month.
    """
    count = more.get("count", len(velocity))
    head = bytearray(78)
    struct.pack_into(
        "<BBHI", head, 0, more.get("version", 1), 78, more.get("config", 0x32F), 101654
    )
    struct.pack_into("<6BH", head, 8, 126, more.get("month", 4), 4, 9, 30, number % 60, 2500)
    struct.pack_into("<Hh", head, 16, 15329, 1000)
    struct.pack_into(
        "<IHhh", head, 20, 10_500, more.get("heading", 0), more.get("pitch", 0), more.get("roll", 0)
    )
    struct.pack_into("<H", head, 30, count << 12 | more.get("code", 1) << 10 | 587)
    struct.pack_into("<H", head, 56, more.get("physical", 0x4321))
    struct.pack_into("<b", head, 60, more.get("scale", -3))
    struct.pack_into("<III", head, 66, 0, 0x30D00000 | more.get("orientation", 4) << 25, number)
    values = struct.pack(f"<{len(velocity)}i", *velocity)
    values += struct.pack(f"<{len(velocity)}i", *more.get("distance", [3000] * len(velocity)))
    return (
        bytes(head)
        + values
        + struct.pack(f"<{len(velocity)}h", *more.get("merit", [12] * len(velocity)))
    )


def dvl_record(
    number: int = 0,
    velocity: Sequence[float] = (0.1, -0.2, 0.05, 0.07),
    distance: Sequence[float] = (3.0, 3.1, 3.2, 3.3),
    merit: Sequence[float] = (0.003, 0.004, 0.005, 0.005),
    status: int = 0xFFFFF,
    **more: int,
) -> bytes:
    """Return a DF21 record. more: version, count (of beams), month."""
    head = struct.pack("<BBI", more.get("version", 1), 36, 100996)
    head += struct.pack("<6BH", 126, more.get("month", 4), 4, 9, 30, number % 60, 2500)
    head += struct.pack("<HII", more.get("count", 4), 0, status) + struct.pack(
        "<fff", 1500.0, 12.5, 0.1
    )
    beams = [0.1, 0.2, 0.1, 0.2, *distance, *[0.004] * 4, *[0.02] * 4, *[-0.1] * 4, *[0.001] * 4]
    return head + struct.pack(
        "<24f20f", *beams, *velocity, *merit, *[0.02] * 4, *[-0.1] * 4, *[0.001] * 4
    )


def dvl_file(count: int = 4) -> bytes:
    """Write a DVL's file: configuration, bottom tracks, and a water track to be passed over."""
    pings = [
        block(DF21, dvl_record(n, velocity=(0.1, -0.2, 0.01 * n, 0.07)), is_long=n % 2 == 1)
        for n in range(count)
    ]
    return (
        configuration((45, -45, -135, 135))
        + pings[0]
        + block(WATER_TRACK, bytes(211))
        + b"".join(pings[1:])
    )


def signature_file(code: int, count: int = 4) -> bytes:
    """Return a Signature's file with velocities east, north, up (0), in x, y, z (1) or along the
    beams (2).
    """
    turned = {"heading": 4500, "pitch": -200, "roll": 300}
    return configuration() + b"".join(
        block(DF20, signature_record(n, code=code, **turned)) for n in range(count)
    )
