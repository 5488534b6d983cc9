# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every reading of a simulated dive in the order of time, whatever the form of the log."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.sensors import instruments
from hullrecon.synthetic.sensors.photographs import photographs
from hullrecon.synthetic.sensors.sonar import pings
from hullrecon.typing import Array

START_NS = 1_777_887_000_000_000_000  # 2026-05-04T09:30:00Z


Item = TypeVar("Item")


class Track(Protocol):
    """Show the items of a long loop while they pass, and hand them on."""

    def __call__(self, items: Iterator[bytes], label: str, total: int, /) -> Iterator[bytes]: ...


def without_progress(items: Iterator[bytes], label: str, total: int, /) -> Iterator[bytes]:
    """Hand on the items and show nothing."""
    return items


class InTurn(Generic[Item]):
    """Give the items of an iterator by number, keeping the last one alone: a number may repeat or
    grow, never fall.
    """

    def __init__(self, items: Iterator[Item]) -> None:
        self._items, self._number = items, -1
        self._last: Item

    def __getitem__(self, number: int) -> Item:
        if number < self._number:
            raise IndexError(f"item {number} is gone, {self._number} is the last one")
        while self._number < number:
            self._last = next(self._items)
            self._number += 1
        return self._last


@dataclass(frozen=True, kw_only=True)
class Streams:
    """Hold what the sensors gave; images and pings are made as they are asked for, in the order of
    time.

    cameras: names of those carried; frames: by frame, a JPEG file for each of them; pings: by ping,
    (beams, ranges) uint8.
    """

    dvl: instruments.Dvl
    imu: instruments.Imu
    pressure: instruments.Series
    joints: instruments.Series
    positions: instruments.Series = instruments.NO_POSITIONS
    cameras: tuple[str, ...]
    frame_s: Array
    frames: InTurn[tuple[bytes, ...]]
    ping_s: Array
    pings: InTurn[NDArray[np.uint8]]


def record(dive: Dive, track: Track = without_progress) -> Streams:
    """Return the readings of all sensors of the dive."""
    spec, motion = dive.spec, dive.motion
    cameras = {"stereo": ("camera_top", "camera_bottom"), "mono": ("camera_top",), "none": ()}[
        spec.cameras.carried
    ]
    images = track(_jpegs(dive), "images written", len(cameras) * len(dive.frame_s))
    ping_s, pinged = pings(dive) if spec.sonar else (np.zeros(0), iter(()))
    return Streams(
        dvl=instruments.dvl(spec, motion, dive.rig, dive.hull),
        imu=instruments.imu(spec, motion),
        pressure=instruments.pressure(spec, motion),
        joints=instruments.joints(spec, motion),
        positions=instruments.positions(spec, motion),
        cameras=cameras,
        frame_s=dive.frame_s,
        frames=InTurn(zip(*[images] * len(cameras), strict=True)),
        ping_s=ping_s,
        pings=InTurn(pinged),
    )


def stamp_ns(t_s: Array) -> NDArray[np.int64]:
    """Return times since the start, s, as nanoseconds since 1970."""
    return START_NS + np.rint(np.asarray(t_s) * 1e9).astype(np.int64)


def in_order(streams: Streams) -> Iterator[tuple[int, str, int]]:
    """Return (stamp, stream, row) of every reading by time of stamp."""
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
    """Yield the images of all cameras, frame by frame."""
    for frame in photographs(dive):
        for image in frame:
            if image is not None:
                yield _jpeg(image, dive.spec.cameras.jpeg_quality)


def _jpeg(image: NDArray[np.uint8], quality: int) -> bytes:
    import cv2

    done, data = cv2.imencode(
        ".jpg", np.ascontiguousarray(image[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, quality]
    )
    assert done
    return data.tobytes()
