# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a video file by their number, in order, as JPEG."""

from __future__ import annotations

import os
from pathlib import Path

from hullrecon.dive.images.encoded import fits
from hullrecon.dive.logs.readers.file_log import require_regular_file

SUFFIXES = (".mp4", ".mov", ".mkv", ".avi", ".ts")
# Containers alone: a playlist under the name of a video would have the decoder open what it lists.
MAGICS = ((4, b"ftyp"), (0, b"\x1a\x45\xdf\xa3"), (8, b"AVI "), (0, b"\x47"))
MOST_FRAMES = 10_000_000
QUALITY = 95  # of the JPEG: the video's own losses are larger


class VideoFrames:
    """A video that is read forward. Raises ValueError, here and in `jpeg`, with what is wrong."""

    def __init__(self, path: Path) -> None:
        """Open a video, and check its kind and the size of its frames."""
        import cv2

        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # what is wrong is said by us
        require_regular_file(path)
        with path.open("rb") as stream:
            start = stream.read(16)
        if not any(start[at:].startswith(magic) for at, magic in MAGICS):
            raise ValueError("it is no MP4, MOV, MKV, AVI or TS")
        self._capture = cv2.VideoCapture(str(path.absolute()), cv2.CAP_FFMPEG)
        if not self._capture.isOpened():
            raise ValueError("it cannot be decoded; an MP4 or MOV that is cut off has no index")
        # as the sensor stored them, like all pictures (images/encoded.py)
        self._capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        self.turned_deg = int(self._capture.get(cv2.CAP_PROP_ORIENTATION_META)) % 360
        size = (
            int(self._capture.get(cv2.CAP_PROP_FRAME_WIDTH)),
            int(self._capture.get(cv2.CAP_PROP_FRAME_HEIGHT)),
        )
        if not fits(size):
            raise ValueError(f"its frames have {size[0]} x {size[1]} pixels")
        self._next = 0

    def jpeg(self, number: int) -> bytes:
        """Encode a frame as JPEG by its number from 0.

        Frames are only read forward, so that numbers have to grow from call to call. Raises
        ValueError where they do not, and for a frame that is not there.
        """
        import cv2

        if not self._next <= number < MOST_FRAMES:
            raise ValueError(f"frame {number}: frames have to grow from row to row")
        while self._next < number:
            if not self._capture.grab():
                raise ValueError(f"it has no frame {number}")
            self._next += 1
        found, pixels = self._capture.read()
        self._next += 1
        if not found:
            raise ValueError(f"it has no frame {number}, or one that cannot be decoded")
        encoded, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        if not encoded:
            raise ValueError(f"frame {number} cannot be kept")
        return bytes(data)
