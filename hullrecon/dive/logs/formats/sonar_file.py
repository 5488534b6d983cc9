# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A sonar ping of plain files: an .npz, a ping among an Oculus' messages, or a frame of a DIDSON.

An .npz holds `image`, `azimuth` and `range`, whose sizes are checked before it is unpacked.
"""

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
from hullrecon.dive.logs.readers.sound_metrics import didson_frames
from hullrecon.dive.logs.readers.unpack import LONGEST_REASON, printable
from hullrecon.typing import Array

KEYS = ("image", "azimuth", "range")
LARGEST_FILE = 1 << 26  # bytes; 1024 beams of 8192 ranges as float64 have as many
# an array may unpack to the first number of bytes plus the second times its packed size
FREE_BYTES, RATIO = 1 << 22, 256
NUMBERS = "biuf"  # kinds of dtypes
FARTHEST_M = 200.0  # of a DIDSON


Ping = tuple[NDArray[np.generic], Array | None, Array]


def read_ping(path: Path, number: int = 0, window_m: tuple[float, float] | None = None) -> Ping:
    """Read image (beams, ranges), azimuth (beams,) rad and range (ranges,) m of a ping in a file.

    Parameters
    ----------
    path : the file
    number : which ping, from 0, of a file of an Oculus or a DIDSON
    window_m : ranges at which the samples of a DIDSON begin and end, which its file does not
        state. None for any other file

    Returns
    -------
    image, azimuth and range. The azimuth of a DIDSON is None, as its file states none

    Raises
    ------
    ValueError
        Anything that is wrong with the file, in words.
    """
    try:
        require_regular_file(path)
        if _begins_with(path, didson_frames.MAGIC):
            return _didson(path, number, window_m)
        if window_m is not None:
            raise ValueError(
                "range_from and range_to are for files of a DIDSON; this one has ranges of its own"
            )
        with warnings.catch_warnings(action="ignore"):
            is_oculus = _begins_with(path, oculus_ping.MAGIC)
            image, azimuth, range_m = _oculus(path, number) if is_oculus else _arrays(path)
    except Exception as error:  # numpy and zipfile raise a dozen kinds over a damaged .npz
        raise ValueError(printable(str(error), LONGEST_REASON)) from None
    if (
        azimuth.ndim != 1
        or range_m.ndim != 1
        or image.shape != (len(azimuth), len(range_m))
        or not image.size
    ):
        raise ValueError("the sonar image's shape is not [beams, ranges]")
    if not (np.isfinite(azimuth).all() and np.isfinite(range_m).all()):
        raise ValueError("azimuth and range are not all numbers")
    return image, azimuth.astype(float), range_m.astype(float)


def _begins_with(path: Path, magic: bytes) -> bool:
    with path.open("rb") as stream:
        return stream.read(len(magic)) == magic


def _didson(path: Path, number: int, window_m: tuple[float, float] | None) -> Ping:
    """Read a frame of a DIDSON's file: image, no azimuths, ranges.

    Its samples divide the window evenly. Raises ValueError without a window, or for an absurd one.
    """
    image = didson_frames.read_frame(path, number)
    if window_m is None:
        raise ValueError("a DIDSON's file states no ranges in metres: give range_from and range_to")
    near, far = window_m
    if not 0 <= near < far <= FARTHEST_M:
        raise ValueError(f"a window from {near:g} to {far:g} m")
    middles = (np.arange(image.shape[1]) + 0.5) / image.shape[1]
    return image, None, near + (far - near) * middles


def _oculus(path: Path, number: int) -> tuple[NDArray[np.generic], Array, Array]:
    """Read a ping of an Oculus log: image, azimuths of the beams, ranges."""
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
    """Find the bytes at which the pings of an Oculus' file begin. Other messages are skipped.

    size, mtime_ns: of the file, so that the cache does not serve one that has changed.
    """
    offsets, at = [], 0
    with path.open("rb") as stream:
        while len(head := stream.read(oculus_ping.HEADER_BYTES)) == oculus_ping.HEADER_BYTES:
            if oculus_ping.is_ping(head):
                offsets.append(at)
            at += oculus_ping.message_bytes(head)
            stream.seek(at)
    return offsets


def _arrays(path: Path) -> list[NDArray[np.generic]]:
    """Read the arrays of a ping's .npz.

    Raises ValueError for one that lacks arrays, is too large, or has other bytes before them.
    """
    require_regular_file(path)
    if path.stat().st_size > LARGEST_FILE:
        raise ValueError(f"it has {path.stat().st_size} bytes")
    with zipfile.ZipFile(path) as archive:
        members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
        absent = [name for name in KEYS if name not in members]
        if absent:
            raise ValueError(f"it has no {' and no '.join(absent)}")
        before = min(info.header_offset for info in archive.infolist())
        # A ZIP is valid with other bytes before it. In a ping's file these are the remains of an
        # earlier, longer file that was overwritten in part.
        if before > 0:
            raise ValueError(f"{before} bytes that are none of its own precede its arrays")
        return [_array(archive, members[name]) for name in KEYS]


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[np.generic]:
    """Read one array of numbers.

    Raises ValueError where it would unpack to too much, or where its head states another size than
    the archive does.
    """
    if member.file_size > min(LARGEST_FILE, FREE_BYTES + RATIO * member.compress_size):
        raise ValueError(f"{member.filename} would unpack to {member.file_size} bytes")
    with archive.open(member) as stream:
        is_first = np.lib.format.read_magic(stream) == (1, 0)
        read_head = (
            np.lib.format.read_array_header_1_0 if is_first else np.lib.format.read_array_header_2_0
        )
        shape, _, dtype = read_head(stream)
        if dtype.kind not in NUMBERS or dtype.itemsize > 8:
            raise ValueError(f"{member.filename} holds no numbers")
        if (
            min(shape, default=0) < 0
            or stream.tell() + math.prod(shape) * dtype.itemsize != member.file_size
        ):
            raise ValueError(f"{member.filename} is not as long as its head says")
    with archive.open(member) as stream:
        return np.asarray(np.lib.format.read_array(stream, allow_pickle=False))
