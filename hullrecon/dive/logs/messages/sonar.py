# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Translate pings of imaging sonars to samples: one small function per type.

Arguments are those of `Translate` in samples.py.
"""

from __future__ import annotations

import numpy as np

from hullrecon.dive.logs.formats.oculus_ping import parse_ping
from hullrecon.dive.logs.messages.decode import Fields, vector
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.logs.samples import Sample, SonarSample
from hullrecon.typing import Array

# of SonarImageData
DTYPES = {0: "u1", 1: "i1", 2: "u2", 3: "i2", 4: "u4", 5: "i4", 6: "u8", 7: "i8", 8: "f4", 9: "f8"}
WIDTHS = {1: "u1", 2: "u2", 4: "u4"}  # bytes a pixel, of messages that name no type


def projected_sonar(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read ProjectedSonarImage. The pixel of range bin r and beam b lies at r * beam_count + b.

    Without any direction, where the beams point is left to dive.toml. Raises DamagedError where
    beams, ranges and pixels do not fit together, or there are none.
    """
    if int(message.image.dtype) not in DTYPES:
        raise DamagedError(f"a sonar image of data type {message.image.dtype}")
    order = ">" if message.image.is_bigendian else "<"
    directions = np.array([vector(b) for b in message.beam_directions]).reshape(-1, 3)
    range_m = np.asarray(message.ranges, float)
    pixels = np.frombuffer(bytes(message.image.data), order + DTYPES[int(message.image.dtype)])
    beams = int(message.image.beam_count)
    if len(directions) not in (0, beams) or pixels.size != beams * len(range_m) or not pixels.size:
        raise DamagedError(
            f"a sonar image of {pixels.size} pixels for {beams} beams and {len(range_m)} ranges"
        )
    return [
        SonarSample(
            t_ns,
            np.ascontiguousarray(pixels.reshape(len(range_m), beams).T),
            directions if len(directions) else None,
            range_m,
        )
    ]


def sonar_image(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read acoustic_msgs/SonarImage, the forerunner of ProjectedSonarImage.

    Pixel (r, b) lies at r * beams + b, azimuth grows from z towards y. Raises DamagedError where
    beams, ranges and pixels do not fit together, or there are none.
    """
    if int(message.data_size) not in WIDTHS:
        raise DamagedError(f"a sonar image of {message.data_size} bytes a pixel")
    azimuth, range_m = np.asarray(message.azimuth_angles, float), np.asarray(message.ranges, float)
    order = ">" if message.is_bigendian else "<"
    pixels = np.frombuffer(bytes(message.intensities), order + WIDTHS[int(message.data_size)])
    if pixels.size != len(azimuth) * len(range_m) or not pixels.size:
        raise DamagedError(
            f"a sonar image of {pixels.size} pixels for {len(azimuth)} beams and {len(range_m)} "
            "ranges"
        )
    image = np.ascontiguousarray(pixels.reshape(len(range_m), len(azimuth)).T)
    return [SonarSample(t_ns, image, in_fan(azimuth), range_m)]


def oculus_raw(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read a message that holds an Oculus' bytes. Bearings grow from port to starboard."""
    ping = parse_ping(bytes(message.data))
    return [SonarSample(t_ns, ping.image, in_fan(ping.azimuth_rad), ping.range_m)]


def oculus_ping(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read oculus_interfaces/Ping: one row for each range, behind four bytes of gain if any.

    Bearings are in hundredths of a degree. Raises DamagedError where its sizes do not fit together.
    """
    beams, ranges, row, width = (
        int(v) for v in (message.n_beams, message.n_ranges, message.step, message.sample_size)
    )
    gain = 4 if message.has_gains else 0
    if width not in WIDTHS or not beams or not ranges or row < gain + beams * width:
        raise DamagedError(f"an Oculus ping of {beams} beams in rows of {row} bytes")
    data = np.frombuffer(bytes(message.ping_data), np.uint8)
    if data.size < ranges * row or len(message.bearings) != beams:
        raise DamagedError(
            f"an Oculus ping of {data.size} bytes for {beams} beams and {ranges} ranges"
        )
    rows = np.ascontiguousarray(
        data[: ranges * row].reshape(ranges, row)[:, gain : gain + beams * width]
    )
    image = np.ascontiguousarray(rows.view("<" + WIDTHS[width]).T)
    range_m = np.asarray((np.arange(ranges) + 0.5) * float(message.range_resolution), float)
    return [
        SonarSample(
            t_ns, image, in_fan(np.radians(np.asarray(message.bearings, float) / 100)), range_m
        )
    ]


def in_fan(azimuth_rad: Array) -> Array:
    """Compute unit vectors (b, 3) in `sonar` of beams in the fan's plane, from z towards y."""
    return np.stack([np.zeros(len(azimuth_rad)), np.sin(azimuth_rad), np.cos(azimuth_rad)], axis=1)
