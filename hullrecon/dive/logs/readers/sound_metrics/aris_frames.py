# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the frames of an .aris file (DDF_05), also behind damage: each a header and an image.

Layout: Sound Metrics, ARIS File SDK [ArisFileSDK]. There are no checksums.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.readers.unpack import DamagedError, HeaderMark, fields, find_header
from hullrecon.typing import Array

MAGIC = b"DDF\x05"
HEADER = 1024  # bytes, of the file's header and of each frame's
MAGIC_AT = 12  # in a frame's header
# number of beams by ping mode
BEAMS = {1: 48, 2: 48, 3: 96, 4: 96, 5: 96, 6: 64, 7: 64, 8: 64, 9: 128, 10: 128, 11: 128, 12: 128}
MOST_SAMPLES = 20_000  # of a beam
# 2008, before the first ARIS, and 2099
EARLIEST_US, LATEST_US = 1_200_000_000_000_000, 4_100_000_000_000_000
SLOWEST, FASTEST = 1300.0, 1700.0  # m/s, of sound in any water
LONGEST_US = 200_000  # from the ping to the first sample: 150 m
FARTHEST_M = 200.0
WINDOW = 1 << 20  # bytes that a search behind damage reads at a time


@dataclass(frozen=True, kw_only=True)
class FrameHeader:
    """The fields read from a frame's header."""

    t_ns: int  # by the clock of the computer that recorded it
    model: int
    beams: int
    range_m: Array  # (samples,) of the middles of the samples
    is_telephoto: bool
    is_sounding: bool  # its transmitter was on
    rotator_deg: Array  # (3,) pan, tilt and roll of a rotator, 0 without one

    @property
    def image_bytes(self) -> int:
        return self.beams * len(self.range_m)


@dataclass(frozen=True, kw_only=True)
class ArisFrame:
    """One frame."""

    header: FrameHeader
    # (beams, samples), beams from port to starboard of an upright sonar (files have the reverse)
    image: NDArray[np.uint8]


def parse_header(data: bytes) -> FrameHeader:
    """Read a frame's header. Raises DamagedError for values that no ARIS writes."""
    if data[MAGIC_AT : MAGIC_AT + len(MAGIC)] != MAGIC:
        raise DamagedError("no frame begins there")
    (time_us,) = fields("<Q", data, 4)
    ping_mode, period_us = fields("<I", data, 436)[0], fields("<I", data, 452)[0]
    is_sounding, speed, samples = fields("<I4xfI", data, 456)
    delay_us, lens, model = fields("<III", data, 476)
    if not EARLIEST_US < time_us < LATEST_US:
        raise DamagedError("its frame has no time of day")
    if ping_mode not in BEAMS or not 0 < samples <= MOST_SAMPLES:
        raise DamagedError(f"a frame of ping mode {ping_mode} with {samples} samples a beam")
    if not (SLOWEST < speed < FASTEST and 0 < period_us <= 1000 and 0 <= delay_us <= LONGEST_US):
        raise DamagedError(
            f"samples every {period_us} us from {delay_us} us on, in water of {speed:g} m/s"
        )
    if not fields("<I", data, 516)[0]:
        raise DamagedError("its samples are in the order of the instrument's channels")
    range_m = speed / 2 * 1e-6 * (delay_us + period_us * (np.arange(samples) + 0.5))
    if range_m[-1] > FARTHEST_M:
        raise DamagedError(f"samples up to {range_m[-1]:.0f} m")
    return FrameHeader(
        t_ns=1000 * int(time_us),
        model=int(model),
        beams=BEAMS[ping_mode],
        range_m=np.asarray(range_m),
        is_telephoto=bool(lens),
        is_sounding=bool(is_sounding),
        rotator_deg=np.array(fields("<fff", data, 244)),
    )


def frames(stream: BinaryIO) -> Iterator[tuple[int, int, ArisFrame | str]]:
    """Yield (start, end, frame) of whole frames, and (start, end, why) of the bytes between them.

    A frame is accepted if it ends where another begins or the file ends, or if it is as large as
    the one before. start, end: bytes of the file.
    """
    at, last, mark = HEADER, 0, HeaderMark(MAGIC, MAGIC_AT, HEADER, parse_header)
    end = stream.seek(0, 2)
    while at < end:
        try:
            frame = _frame_at(stream, at, end, last)
        except DamagedError as error:
            following = find_header(stream, at + 1, end, WINDOW, mark)
            yield at, following, str(error)
            at = following
            continue
        last = frame.header.image_bytes
        yield at, at + HEADER + last, frame
        at += HEADER + last


def _frame_at(stream: BinaryIO, at: int, end: int, last: int) -> ArisFrame:
    """Read the frame that begins at byte `at`. Raises DamagedError where there is no whole one.

    Parameters
    ----------
    stream, end : the file, and its size
    at : where the frame begins
    last : bytes of the image of the previous frame, 0 for the first
    """
    stream.seek(at)
    header = parse_header(stream.read(HEADER))
    size = header.image_bytes
    if at + HEADER + size > end:
        raise DamagedError("the file ends within its frame")
    if at + HEADER + size < end and size != last:
        stream.seek(at + HEADER + size)
        if not _is_header(stream.read(MAGIC_AT + len(MAGIC))):
            raise DamagedError("no other frame follows where its frame ends")
        stream.seek(at + HEADER)
    image = np.frombuffer(stream.read(size), np.uint8).reshape(len(header.range_m), header.beams)
    return ArisFrame(header=header, image=np.ascontiguousarray(image[:, ::-1].T))


def _is_header(data: bytes) -> bool:
    """Tell whether bytes look like the beginning of a frame's header, even of a cut one."""
    return len(data) < MAGIC_AT + len(MAGIC) or data[MAGIC_AT:] == MAGIC
