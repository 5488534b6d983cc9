# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import struct

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hullrecon.dive.logs.formats.oculus_ping import (
    HEADER,
    HEADS,
    is_ping,
    message_bytes,
    parse_ping,
)
from hullrecon.dive.logs.readers.unpack import DamagedError

QUICK = settings(
    max_examples=75,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)


def ping_bytes(version=1, pixels=None, gain=False, kind=0, **more):
    """A message written by hand after Oculus.h; pixels [ranges, beams]."""
    pixels = np.arange(12, dtype=np.uint8).reshape(4, 3) if pixels is None else pixels
    ranges, beams = pixels.shape
    layout, at, image_at, end = HEADS[version]
    rows = b"".join((b"\1\0\0\0" if gain else b"") + row.tobytes() for row in pixels)
    offset = end + 2 * beams
    body = bytearray(offset)
    struct.pack_into(
        layout,
        body,
        at,
        kind,
        more.get("resolution", 0.01),
        more.get("ranges", ranges),
        more.get("beams", beams),
    )
    struct.pack_into(
        "<III",
        body,
        image_at,
        more.get("offset", offset),
        more.get("size", len(rows)),
        offset + len(rows),
    )
    struct.pack_into(
        f"<{beams}h", body, end, *more.get("bearings", range(-1000, 1000 * beams - 1000, 1000))
    )
    body[20] = 0x19 | (4 if gain else 0)
    struct.pack_into(
        HEADER,
        body,
        0,
        0x4F53,
        1,
        0,
        0x23,
        version if version == 2 else 0,
        offset + len(rows) - 16,
        0,
    )
    return bytes(body) + rows


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("gain", [False, True])
def test_a_ping_of_either_version_reads_back(version, gain):
    content = ping_bytes(version, gain=gain)
    assert is_ping(content)
    assert message_bytes(content) == len(content)
    ping = parse_ping(content)
    np.testing.assert_array_equal(ping.image, np.arange(12).reshape(4, 3).T)
    np.testing.assert_allclose(np.degrees(ping.azimuth_rad), [-10, 0, 10])
    np.testing.assert_allclose(ping.range_m, [0.005, 0.015, 0.025, 0.035])


def test_sixteen_bits_are_little_endian():
    pixels = np.array([[1, 256], [65535, 7]], "<u2")
    np.testing.assert_array_equal(parse_ping(ping_bytes(2, pixels, kind=1)).image, pixels.T)


@pytest.mark.parametrize(
    "wrong",
    [
        {"beams": 0},
        {"ranges": 0},
        {"size": 11},
        {"offset": 5},
        {"kind": 2},
        {"kind": 9},
        {"resolution": float("nan")},
        {"bearings": (0, 0, 0)},
        {"bearings": (-20_000, 0, 20_000)},
    ],
    ids=range(9),
)
def test_sizes_that_do_not_fit_are_damage(wrong):
    with pytest.raises(DamagedError):
        parse_ping(ping_bytes(**wrong))


def test_a_real_ping_is_read_as_its_source_describes_it(data):
    content = (data / "oculus-pings" / "three_pings_8bit.raw").read_bytes()
    assert message_bytes(content) == 182_016
    ping = parse_ping(content)
    assert ping.image.shape == (256, 703)
    assert np.diff(ping.range_m).mean() == pytest.approx(0.002842, abs=1e-6)
    assert np.degrees(ping.azimuth_rad[[0, -1]]) == pytest.approx([-30, 30])


@QUICK
@given(data=st.data())
def test_any_flipped_byte_and_any_cut_gives_a_ping_or_damage(data):
    content = bytearray(ping_bytes(data.draw(st.sampled_from([1, 2]))))
    content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    try:
        ping = parse_ping(bytes(content[: data.draw(st.integers(0, len(content)))]))
    except DamagedError:
        return
    assert ping.image.shape == (len(ping.azimuth_rad), len(ping.range_m))
    assert np.isfinite(ping.range_m).all()
