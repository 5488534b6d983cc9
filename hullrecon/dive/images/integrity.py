# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check that an image is whole. Decoders forgive a lot: half a JPEG comes back as a half-gray
picture.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.images.deep import decode_deep, is_deep
from hullrecon.dive.images.header import Size, fits, header_size

MARKER = re.compile(rb"\xff([\x01-\xfe])")
START, END, SCAN = 0xD8, 0xD9, 0xDA
RESTART = range(0xD0, 0xD8)


@dataclass(frozen=True)
class CheckedImage:
    """size: (width, height) of a whole image, None for a damaged one or for other bytes. largest:
    value of an image whose samples have 16 bits, None of any other.
    """

    size: Size | None
    largest: int | None = None


def check_image(encoded: bytes, wanted: Size | None = None) -> CheckedImage:
    """Return what is found of an image.

    wanted: of an image whose header says another size nothing is decoded; that size is returned. So
    it is for one that is too large to be decoded at all.
    """
    size = header_size(encoded)
    if size is None or not fits(size) or wanted not in (None, size):
        return CheckedImage(size)
    if encoded[:2] == b"\xff\xd8" and not jpeg_is_whole(encoded):
        return CheckedImage(None)
    return _decoded(encoded)


def size_of(encoded: bytes, wanted: Size | None = None) -> Size | None:
    """Return the size that check_image finds."""
    return check_image(encoded, wanted).size


def jpeg_is_whole(encoded: bytes) -> bool:
    """Return whether the JPEG runs from start to end marker with nothing but ordered restarts and
    tables inside its scans.
    """
    at = 2
    while at + 4 <= len(encoded) and encoded[at] == 0xFF:
        code = encoded[at + 1]
        if code == END:
            return False  # before any scan
        if code == 0xFF:
            at += 1
            continue
        at += 2 + int.from_bytes(encoded[at + 2 : at + 4], "big")
        if code != SCAN:
            continue
        following = _behind_scan(encoded, at)
        if following is None:
            return False
        if encoded[following + 1] == END:
            return True
        at = following
    return False


def _behind_scan(encoded: bytes, at: int) -> int | None:
    """Return the offset of the marker behind a scan's data; None when a restart is out of order or
    the data never ends.
    """
    restarts = 0
    for match in MARKER.finditer(encoded, at):
        code = match[1][0]
        if code not in RESTART:
            return match.start()
        if code != RESTART[restarts % 8]:
            return None
        restarts += 1  # noqa: SIM113 (it counts restarts, not matches)
    return None


def _decoded(encoded: bytes) -> CheckedImage:
    import cv2

    image: NDArray[np.integer] | None = decode_deep(encoded) if is_deep(encoded) else None
    if image is not None:
        return CheckedImage((image.shape[1], image.shape[0]), int(image.max()))
    try:
        image = cv2.imdecode(
            np.frombuffer(encoded, np.uint8), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
        )
    except cv2.error:
        return CheckedImage(None)
    return CheckedImage(None if image is None else (int(image.shape[1]), int(image.shape[0])))
