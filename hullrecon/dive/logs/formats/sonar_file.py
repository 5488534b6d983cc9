# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A sonar ping of plain files: an .npz with `image`, `azimuth` and `range`, whose sizes are looked at before it is unpacked, or
one of those that an Oculus sent and a file keeps as they came."""

from __future__ import annotations

import math
import warnings
import zipfile
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.formats import oculus_ping
from hullrecon.dive.logs.readers.file_log import require_regular_file
from hullrecon.dive.logs.readers.unpack import LONGEST_REASON, printable
from hullrecon.typing import Array

KEYS = ("image", "azimuth", "range")
LARGEST_FILE = 1 << 26  # bytes; 1024 beams of 8192 ranges as float64 have as many
FREE_BYTES, RATIO = 1 << 22, 256  # an array unpacks to at most so many bytes and so many times its packed size
NUMBERS = "biuf"  # kinds of dtypes


def read_ping(path: Path, number: int = 0) -> tuple[NDArray[np.generic], Array, Array]:
    """Return the image [beams, ranges], azimuth (beams,) rad and range (ranges,) m of a ping.

    number: which ping, from 0, of a file of what an Oculus sent. Raises ValueError that says what is wrong with the file.
    """
    try:
        require_regular_file(path)
        with warnings.catch_warnings(action="ignore"):
            image, azimuth, range_m = _oculus(path, number) if _is_oculus(path) else _arrays(path)
    except Exception as error:  # numpy and zipfile raise a dozen kinds over a damaged .npz
        raise ValueError(printable(str(error), LONGEST_REASON)) from None
    if azimuth.ndim != 1 or range_m.ndim != 1 or image.shape != (len(azimuth), len(range_m)) or not image.size:
        raise ValueError("the sonar image's shape is not [beams, ranges]")
    if not (np.isfinite(azimuth).all() and np.isfinite(range_m).all()):
        raise ValueError("azimuth and range are not all numbers")
    return image, azimuth.astype(float), range_m.astype(float)


def _is_oculus(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(len(oculus_ping.MAGIC)) == oculus_ping.MAGIC


def _oculus(path: Path, number: int) -> tuple[NDArray[np.generic], Array, Array]:
    found = path.stat()
    offsets = _ping_offsets(path, found.st_size, found.st_mtime_ns)
    if number >= len(offsets):
        raise ValueError("it holds no ping of that number")
    with path.open("rb") as stream:
        stream.seek(offsets[number])
        head = stream.read(oculus_ping.HEADER_BYTES)
        length = oculus_ping.message_bytes(head)
        if length > LARGEST_FILE:
            raise ValueError(f"the ping has {length} bytes")
        ping = oculus_ping.parse_ping(head + stream.read(length - len(head)))
    return ping.image, ping.azimuth_rad, ping.range_m


@lru_cache(maxsize=4)
def _ping_offsets(path: Path, size: int, mtime_ns: int) -> list[int]:
    """Where the pings begin: heads are stepped over by the lengths that they tell. A file that has changed is read anew."""
    offsets, at = [], 0
    with path.open("rb") as stream:
        while len(head := stream.read(oculus_ping.HEADER_BYTES)) == oculus_ping.HEADER_BYTES:
            if oculus_ping.is_ping(head):
                offsets.append(at)
            at += oculus_ping.message_bytes(head)
            stream.seek(at)
    return offsets


def _arrays(path: Path) -> list[NDArray[np.generic]]:
    require_regular_file(path)
    if path.stat().st_size > LARGEST_FILE:
        raise ValueError(f"it has {path.stat().st_size} bytes")
    with zipfile.ZipFile(path) as archive:
        members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
        absent = [name for name in KEYS if name not in members]
        if absent:
            raise ValueError(f"it has no {' and no '.join(absent)}")
        before = min(info.header_offset for info in archive.infolist())
        if before > 0:  # a ZIP may have anything before it; a ping that has was overwritten by another
            raise ValueError(f"{before} bytes of something else stand before its arrays")
        return [_array(archive, members[name]) for name in KEYS]


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[np.generic]:
    """One array of numbers. What its head says of its size must be what the archive says, before either is believed."""
    if member.file_size > min(LARGEST_FILE, FREE_BYTES + RATIO * member.compress_size):
        raise ValueError(f"{member.filename} would unpack to {member.file_size} bytes")
    with archive.open(member) as stream:
        is_first = np.lib.format.read_magic(stream) == (1, 0)
        read_head = np.lib.format.read_array_header_1_0 if is_first else np.lib.format.read_array_header_2_0
        shape, _, dtype = read_head(stream)
        if dtype.kind not in NUMBERS or dtype.itemsize > 8:
            raise ValueError(f"{member.filename} holds no numbers")
        if min(shape, default=0) < 0 or stream.tell() + math.prod(shape) * dtype.itemsize != member.file_size:
            raise ValueError(f"{member.filename} is not as long as its head says")
    with archive.open(member) as stream:
        return np.asarray(np.lib.format.read_array(stream, allow_pickle=False))
