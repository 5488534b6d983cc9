# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The images of an imaging sonar while a log is read: in a file, as those of a long dive do not fit
into memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.samples import SonarSample
from hullrecon.typing import Array

# of a ping's pixels are no brighter than its bright one: a few may be saturated
BRIGHT_PERCENT = 99.5
Images = NDArray[np.uint8]  # (pings, beams, ranges)
# from their shape, one (beams, ranges) after the other
KeepImages = Callable[[tuple[int, int, int], Iterator[Images]], Images]


@dataclass(frozen=True)
class PingStorage:
    """Where the images of a sonar go. spool: an empty file that may be read and written, for them
    as they were logged; keep: keeps them as they are used.
    """

    spool: BinaryIO
    keep: KeepImages


@dataclass(frozen=True, slots=True)
class SpooledPing(SonarSample):
    """A ping whose image lies in a spool from byte `at` on. What stands for it has its shape, type
    and bright pixel, and no memory.
    """

    at: int = 0


class PingSpool:
    """Takes pings as they are read and gives them back from the file. Without a file, images are
    left aside.
    """

    def __init__(self, file: BinaryIO | None) -> None:
        self._file = file
        self._size = 0
        self._directions: Array | None = None
        self._range_m: Array | None = None

    def keep(self, sample: SonarSample) -> SpooledPing:
        """Write a ping's image to the file; directions and ranges are those of the ping before
        where they are equal.
        """
        image = np.ascontiguousarray(sample.image)
        if (
            self._directions is None
            or sample.directions is None
            or not np.array_equal(self._directions, sample.directions)
        ):
            self._directions = sample.directions
        if self._range_m is None or not np.array_equal(self._range_m, sample.range_m):
            self._range_m = sample.range_m
        at = self._size
        if self._file is not None:
            self._file.seek(at)
            self._file.write(image.data)
            self._size += image.nbytes
        stand_in = np.broadcast_to(bright_pixel(image), image.shape)
        return SpooledPing(sample.t_ns, stand_in, self._directions, self._range_m, at)

    def load(self, ping: SonarSample) -> SonarSample:
        """Return the ping with its image read from the file; one that was not kept here as it is."""
        if self._file is None or not isinstance(ping, SpooledPing):
            return ping
        self._file.seek(ping.at)
        data = self._file.read(ping.image.nbytes)
        image = np.frombuffer(data, ping.image.dtype).reshape(ping.image.shape)
        return SonarSample(ping.t_ns, image, ping.directions, ping.range_m)


def bright_pixel(image: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return the pixel () that is brighter than nearly all that are not black of an image (beams,
    ranges), 0 where none is; of one of 8 bits, which need no scale, the brightest. Of what stands
    for an image in a spool it is its one value.
    """
    pixels = np.asarray(image[:1, :1] if not any(image.strides) else image)
    if pixels.dtype == np.uint8:
        return np.asarray(pixels.max(), np.uint8)
    bright = pixels[np.isfinite(pixels) & (pixels > 0)]
    return np.asarray(
        np.percentile(bright, BRIGHT_PERCENT, method="higher") if len(bright) else 0, image.dtype
    )
