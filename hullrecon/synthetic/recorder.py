# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The sensor readings of a simulated dive in order of time, for any format of the log."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.synthetic import instruments
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.rendering import photographs
from hullrecon.synthetic.sonar import pings
from hullrecon.typing import Array

START_NS = 1_777_887_000_000_000_000  # 2026-05-04T09:30:00Z


Item = TypeVar("Item")


class Track(Protocol):
    """Shows the items of a long loop while they pass."""

    def __call__(self, items: Iterator[bytes], label: str, total: int, /) -> Iterator[bytes]: ...


def without_progress(items: Iterator[bytes], label: str, total: int, /) -> Iterator[bytes]:
    """Hand on the items and show nothing."""
    return items


class InTurn(Generic[Item]):
    """The items of an iterator by number. Only the last one is kept in memory.

    So numbers may repeat or grow, but never decrease.
    """

    def __init__(self, items: Iterator[Item]) -> None:
        self._items, self._number = items, -1
        self._last: Item

    def __getitem__(self, number: int) -> Item:
        """Make items up to this number, and keep the last one alone. Earlier ones are gone."""
        if number < self._number:
            raise IndexError(f"item {number} is gone, {self._number} is the last one")
        while self._number < number:
            self._last = next(self._items)
            self._number += 1
        return self._last


@dataclass(frozen=True, kw_only=True)
class Streams:
    """The readings of all sensors. Images and pings are made when accessed, in order of time."""

    dvl: instruments.Dvl
    imu: instruments.Imu
    pressure: instruments.Series
    joints: instruments.Series
    positions: instruments.Series = instruments.NO_POSITIONS
    cameras: tuple[str, ...]  # names of those carried
    frame_s: Array  # as stamped
    frames: InTurn[tuple[bytes, ...]]  # by frame, a JPEG file for each camera
    ping_s: Array
    pings: InTurn[NDArray[np.uint8]]  # by ping, (beams, ranges)


def record(dive: Dive, track: Track = without_progress) -> Streams:
    """Simulate all sensors of the dive."""
    spec, motion = dive.spec, dive.motion
    count = {"stereo": 2, "mono": 1, "none": 0}[spec.cameras.carried]
    cameras = ("camera_top", "camera_bottom")[:count]
    images = track(_jpegs(dive), "images written", len(cameras) * len(dive.frame_s))
    ping_s, pinged = pings(dive) if spec.sonar else (np.zeros(0), iter(()))
    # The images come camera by camera within a frame: one iterator, taken once for each camera,
    # gives the images of a frame.
    return Streams(
        dvl=instruments.dvl(spec, motion, dive.rig, dive.hull),
        imu=instruments.imu(spec, motion),
        pressure=instruments.pressure(spec, motion),
        joints=instruments.joints(spec, motion),
        positions=instruments.positions(spec, motion),
        cameras=cameras,
        frame_s=dive.frame_s + spec.cameras.camera_offset_s,
        frames=InTurn(zip(*[images] * len(cameras), strict=True)),
        ping_s=ping_s,
        pings=InTurn(pinged),
    )


def stamp_ns(t_s: Array) -> NDArray[np.int64]:
    """Convert times since the start, s, to nanoseconds since 1970."""
    return START_NS + np.rint(np.asarray(t_s) * 1e9).astype(np.int64)


def in_order(streams: Streams) -> Iterator[tuple[int, str, int]]:
    """List (stamp in ns, stream, row) of every reading, sorted."""
    times = {
        "imu": streams.imu.t_s,
        "joints": streams.joints.t_s,
        "pressure": streams.pressure.t_s,
        "dvl": streams.dvl.t_s,
        "position": streams.positions.t_s,
        "sonar": streams.ping_s,
        **dict.fromkeys(streams.cameras, streams.frame_s),
    }
    rows = [(int(ns), name, k) for name, t in times.items() for k, ns in enumerate(stamp_ns(t))]
    return iter(sorted(rows))


def _jpegs(dive: Dive) -> Iterator[bytes]:
    """Render and encode the images of all cameras, frame by frame."""
    for frame in photographs(dive):
        for image in frame:
            if image is not None:
                yield _jpeg(image, dive.spec.cameras.jpeg_quality)


def _jpeg(image: NDArray[np.uint8], quality: int) -> bytes:
    """Encode an image (h, w, 3) RGB as JPEG."""
    import cv2

    done, data = cv2.imencode(
        ".jpg", np.ascontiguousarray(image[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, quality]
    )
    assert done
    return data.tobytes()
