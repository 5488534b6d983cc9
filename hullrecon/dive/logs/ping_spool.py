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
LEAST_PIXELS = 1000  # not black, of a ping that tells in which order the bytes of pixels stand
Images = NDArray[np.uint8]  # (pings, beams, ranges)
# stores images (beams, ranges) as they come, given the shape of the whole array, and returns it
KeepImages = Callable[[tuple[int, int, int], Iterator[Images]], Images]


@dataclass(frozen=True)
class PingStorage:
    """The place where the images of a sonar go."""

    spool: BinaryIO  # an empty file that may be read and written, for images as they were logged
    keep: KeepImages  # stores the images of eight bits that the other steps use


@dataclass(frozen=True, slots=True)
class PingLook:
    """What the pixels of a ping tell of how they are stored, once its image is put away."""

    bright: float  # the pixel at BRIGHT_PERCENT of those above zero, 0 where none is
    exchanged_bright: float  # likewise, with the bytes of each pixel exchanged
    # How much more neighbours differ, over the spread of all, with the bytes exchanged. Below 1
    # where they are stored so. 1 where it makes no difference
    rougher: float
    is_negative: bool  # most pixels are below zero, as decibels are


@dataclass(frozen=True, slots=True)
class SpooledPing(SonarSample):
    """A ping whose image lies in a spool. `image` has its shape and type alone."""

    at: int = 0  # byte of the spool at which its image begins
    look: PingLook | None = None


class PingSpool:
    """Store pings in a file and load them again. Without a file, their images are dropped."""

    def __init__(self, file: BinaryIO | None) -> None:
        self._file = file
        self._size = 0
        self._directions: Array | None = None
        self._range_m: Array | None = None

    def keep(self, sample: SonarSample) -> SpooledPing:
        """Write a ping's image to the file, and return the ping without it.

        In its place the ping has a black one of the same shape and type, which takes no memory.
        Directions and ranges equal to those of the ping before share its arrays, to save memory.
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
        black = np.broadcast_to(np.zeros((), image.dtype), image.shape)
        return SpooledPing(sample.t_ns, black, self._directions, self._range_m, at, look_at(image))

    def load(self, ping: SonarSample) -> SonarSample:
        """Read a ping's image back. A ping that was not kept here stays as it is."""
        if self._file is None or not isinstance(ping, SpooledPing):
            return ping
        self._file.seek(ping.at)
        data = self._file.read(ping.image.nbytes)
        image = np.frombuffer(data, ping.image.dtype).reshape(ping.image.shape)
        return SonarSample(ping.t_ns, image, ping.directions, ping.range_m)


def look_of(sample: SonarSample) -> PingLook:
    """Take what the spool noted of a ping's pixels, or look at those of a ping in memory."""
    known = sample.look if isinstance(sample, SpooledPing) else None
    return known or look_at(sample.image)


@np.errstate(all="ignore")  # pixels of any values
def look_at(image: NDArray[np.generic]) -> PingLook:
    """Look at the pixels (beams, ranges) of a ping."""
    if image.dtype == np.uint8:  # needs no scale
        return PingLook(float(image.max()), float(image.max()), 1.0, False)
    finite = np.asarray(image[np.isfinite(image)], float)
    is_negative = bool(len(finite)) and bool(np.median(finite) < 0)
    has_bytes = image.dtype.kind in "iu" and image.dtype.itemsize > 1
    if not has_bytes or np.count_nonzero(image) < LEAST_PIXELS:
        bright = _bright_pixel(image)
        return PingLook(bright, bright, 1.0, is_negative)
    exchanged = image.byteswap()
    rough, other = _roughness(image), _roughness(exchanged)
    rougher = other / rough if rough > 0 else 1.0
    return PingLook(_bright_pixel(image), _bright_pixel(exchanged), rougher, is_negative)


def _roughness(image: NDArray[np.generic]) -> float:
    """Measure how much neighbours along a beam differ, over the spread of all pixels."""
    pixels = image.astype(float)
    spread = float(pixels.std())
    return float(np.abs(np.diff(pixels, axis=1)).mean()) / spread if spread > 0 else 0.0


def _bright_pixel(image: NDArray[np.generic]) -> float:
    """Find the pixel at BRIGHT_PERCENT of those of an image that are not black, 0 if all are."""
    bright = image[np.isfinite(image) & (np.asarray(image, float) > 0)]
    if not len(bright):
        return 0.0
    return float(np.percentile(bright, BRIGHT_PERCENT, method="higher"))
