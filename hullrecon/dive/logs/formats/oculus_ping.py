# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The simple ping result of an Oculus sonar, versions 1 and 2: its image, bearings and ranges.

Layout: Blueprint Subsea's Oculus.h, as liboculus (University of Washington) publishes it, packed,
little-endian. A message has no time of day: its clock counts from power-up.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.readers.unpack import DamagedError, fields
from hullrecon.typing import Array

MAGIC = b"SO"  # 0x4f53
# check, source, destination, kind, version, payload bytes, spare
HEADER, SIMPLE_PING = "<HHHHHIH", 0x23
HEADER_BYTES = struct.calcsize(HEADER)
# byte of the fire message's flags, and the flag that each row begins with four bytes of gain
FLAGS_AT, GAIN_IS_SENT = 20, 0x04
# By version: struct format of pixel size, range resolution, ranges and beams, and the byte where
# they are; the byte of the image's offset and size; the end of the head, where bearings begin
HEADS = {1: ("<BdHH", 93 + 4, 110, 122), 2: ("<BdHH", 161, 190, 202)}
SAMPLES = {0: "<u1", 1: "<u2", 2: "<u4", 3: "<u4"}  # DataSizeType; 24 bits are not read
NOT_READ = 2
MOST_BEAMS, MOST_RANGES = 1024, 20_000
FARTHEST_M, WIDEST_DEG = 500.0, 90.0


@dataclass(frozen=True, kw_only=True)
class OculusPing:
    """One ping."""

    image: NDArray[np.unsignedinteger]  # (beams, ranges)
    azimuth_rad: Array  # (beams,) as sent, growing from left to right
    range_m: Array  # (ranges,) of bin centres


def message_bytes(data: bytes) -> int:
    """Read the length of a message, header included. Raises DamagedError if none starts there."""
    check, *_, payload, _ = fields(HEADER, data)
    if check != int.from_bytes(MAGIC, "little"):
        raise DamagedError("no Oculus message starts there")
    return HEADER_BYTES + payload


def is_ping(data: bytes) -> bool:
    """Tell whether a message is a simple ping result."""
    return int(fields(HEADER, data)[3]) == SIMPLE_PING


def parse_ping(data: bytes) -> OculusPing:
    """Parse one whole message: image, bearings and ranges.

    The gain in front of each row is dropped. Raises DamagedError for any other message, for pixels
    of 24 bits, and where sizes or bearings do not fit together.
    """
    length = message_bytes(data)
    if not is_ping(data) or length > len(data):
        raise DamagedError("it is no whole ping of an Oculus")
    layout, at, image_at, end = HEADS[2 if fields(HEADER, data)[4] == 2 else 1]
    kind, resolution, ranges, beams = fields(layout, data, at)
    offset, size = fields("<II", data, image_at)
    if kind not in SAMPLES or kind == NOT_READ:
        raise DamagedError(f"pixels of kind {kind} are not read")
    if not (
        0 < beams <= MOST_BEAMS
        and 0 < ranges <= MOST_RANGES
        and 0 < resolution * ranges <= FARTHEST_M
    ):
        raise DamagedError(f"a ping of {beams} beams and {ranges} ranges of {resolution:g} m")
    dtype = np.dtype(SAMPLES[kind])
    gain = 4 if data[FLAGS_AT] & GAIN_IS_SENT else 0
    row = gain + beams * dtype.itemsize
    if size != row * ranges or offset < end + 2 * beams or offset + size > len(data):
        raise DamagedError(f"an image of {size} bytes for {beams} beams and {ranges} ranges")
    bearing = np.frombuffer(data, "<i2", beams, end) / 100
    if np.abs(bearing).max() > WIDEST_DEG or not (np.diff(bearing) > 0).all():
        raise DamagedError("its bearings do not grow from beam to beam")
    rows = np.frombuffer(data, np.uint8, size, offset).reshape(ranges, row)[:, gain:]
    image = np.ascontiguousarray(rows).view(dtype).reshape(ranges, beams)
    return OculusPing(
        image=np.ascontiguousarray(image.T),
        azimuth_rad=np.radians(bearing),
        range_m=np.asarray((np.arange(ranges) + 0.5) * resolution, float),
    )
