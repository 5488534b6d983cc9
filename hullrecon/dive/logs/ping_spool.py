# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Spool the images of an imaging sonar to a file, as those of a long dive do not fit in memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.samples import SonarSample
from hullrecon.typing import Array

# percentile of a ping's pixels that is its bright pixel: the brightest few may be saturated
BRIGHT_PERCENT = 99.5
Images = NDArray[np.uint8]  # (pings, beams, ranges)
# stores images (beams, ranges) as they come, given the shape of the whole array, and returns it
KeepImages = Callable[[tuple[int, int, int], Iterator[Images]], Images]


@dataclass(frozen=True)
class PingStorage:
    """The place where the images of a sonar go."""

    spool: BinaryIO  # an empty file that may be read and written, for images as they were logged
    keep: KeepImages  # stores the images of eight bits that the other steps use


@dataclass(frozen=True, slots=True)
class SpooledPing(SonarSample):
    """A ping whose image lies in a spool. `image` has its shape, type and bright pixel alone."""

    at: int = 0  # byte of the spool at which its image begins


class PingSpool:
    """Store pings in a file and load them again. Without a file, their images are dropped."""

    def __init__(self, file: BinaryIO | None) -> None:
        self._file = file
        self._size = 0
        self._directions: Array | None = None
        self._range_m: Array | None = None

    def keep(self, sample: SonarSample) -> SpooledPing:
        """Write a ping's image to the file, and return the ping without it.

        In its place the ping has a stand-in of the same shape and type, which takes no memory and
        holds the image's bright pixel everywhere. Directions and ranges equal to those of the ping
        before share its arrays, to save memory.
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
        """Read a ping's image back. A ping that was not kept here stays as it is."""
        if self._file is None or not isinstance(ping, SpooledPing):
            return ping
        self._file.seek(ping.at)
        data = self._file.read(ping.image.nbytes)
        image = np.frombuffer(data, ping.image.dtype).reshape(ping.image.shape)
        return SonarSample(ping.t_ns, image, ping.directions, ping.range_m)


def bright_pixel(image: NDArray[np.generic]) -> NDArray[np.generic]:
    """Find a bright pixel () of an image, by which all pings are scaled to eight bits.

    It is the pixel at BRIGHT_PERCENT of those that are not black, 0 if all are. Of an image of
    eight bits, which needs no scale, it is the brightest one. A spooled ping's stand-in has this
    value.
    """
    # strides of zero: a stand-in has one value in all pixels
    pixels = np.asarray(image[:1, :1] if not any(image.strides) else image)
    if pixels.dtype == np.uint8:
        return np.asarray(pixels.max(), np.uint8)
    bright = pixels[np.isfinite(pixels) & (pixels > 0)]
    return np.asarray(
        np.percentile(bright, BRIGHT_PERCENT, method="higher") if len(bright) else 0, image.dtype
    )
