# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every reading of a simulated dive in the order of time, whatever the form of the log."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.synthetic import instruments
from hullrecon.synthetic.dive import Dive, photographs, pings
from hullrecon.synthetic.sonar import BEAM_COUNT, BIN_COUNT

Array = NDArray[np.float64]
START_NS = 1_777_887_000_000_000_000  # 2026-05-04T09:30:00Z


@dataclass(frozen=True)
class Streams:
    """What the sensors gave. jpeg_top, jpeg_bottom: one file a frame; pings (n, beams, ranges)."""

    dvl: instruments.Dvl
    imu: instruments.Imu
    pressure: instruments.Series
    joints: instruments.Series
    frame_s: Array
    jpeg_top: list[bytes]
    jpeg_bottom: list[bytes]
    ping_s: Array
    pings: NDArray[np.uint8]


def record(dive: Dive) -> Streams:
    """All sensors of the dive, images last: they take the time."""
    spec, motion = dive.spec, dive.motion
    ping_s, images = pings(dive) if spec.sonar else (np.zeros(0), iter(()))
    heard = np.array(list(images), np.uint8).reshape(len(ping_s), BEAM_COUNT, BIN_COUNT)
    top, bottom = _jpegs(dive)
    return Streams(
        instruments.dvl(spec, motion, dive.rig, dive.hull),
        instruments.imu(spec, motion),
        instruments.pressure(spec, motion),
        instruments.joints(spec, motion),
        dive.frame_s,
        top,
        bottom,
        ping_s,
        heard,
    )


def stamp_ns(t_s: Array) -> NDArray[np.int64]:
    return START_NS + np.rint(np.asarray(t_s) * 1e9).astype(np.int64)


def in_order(streams: Streams) -> Iterator[tuple[int, str, int]]:
    """(stamp, stream, row) of every reading by time of stamp."""
    times = {
        "imu": streams.imu.t_s,
        "joints": streams.joints.t_s,
        "pressure": streams.pressure.t_s,
        "dvl": streams.dvl.t_s,
        "sonar": streams.ping_s,
        "camera_bottom": streams.frame_s[: len(streams.jpeg_bottom)],
        "camera_top": streams.frame_s[: len(streams.jpeg_top)],
    }
    rows = [(int(ns), name, k) for name, t in times.items() for k, ns in enumerate(stamp_ns(t))]
    return iter(sorted(rows))


def _jpegs(dive: Dive) -> tuple[list[bytes], list[bytes]]:
    top, bottom = list[bytes](), list[bytes]()
    if dive.spec.cameras == "none":
        return top, bottom
    for first, second in photographs(dive):
        top.append(_jpeg(first, dive.spec.jpeg_quality))
        if second is not None:
            bottom.append(_jpeg(second, dive.spec.jpeg_quality))
    return top, bottom


def _jpeg(image: NDArray[np.uint8], quality: int) -> bytes:
    import cv2

    done, data = cv2.imencode(".jpg", np.ascontiguousarray(image[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert done
    return data.tobytes()
