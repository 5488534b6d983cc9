# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Convert the pixels of sensor_msgs/Image and mosaics of CompressedImage to PNG, without loss."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.messages.decode import Fields
from hullrecon.dive.logs.readers.unpack import DamagedError

CHANNELS = {
    "mono8": 1,
    "8uc1": 1,
    "bgr8": 3,
    "8uc3": 3,
    "rgb8": 3,
    "bgra8": 4,
    "8uc4": 4,
    "rgba8": 4,
    "mono16": 1,
    "16uc1": 1,
    "bayer_rggb8": 1,
    "bayer_bggr8": 1,
    "bayer_gbrg8": 1,
    "bayer_grbg8": 1,
    "yuv422": 2,
    "uyvy": 2,
    "yuv422_yuy2": 2,
    "yuyv": 2,
}
VIDEO_FORMS = ("h264", "h265", "hevc", "av1", "ffmpeg", "theora")
QUICK = 1  # PNG's compression level: images are written once, and read a few times


def encode_raw(message: Fields) -> bytes:
    """Encode an image as PNG. Raises DamagedError for missing pixels or an unknown encoding."""
    return _png(_to_bgr(_pixels(message), message.encoding.lower()))


def decoded_mosaic(form: str, encoded: bytes) -> bytes:
    """Turn a compressed mosaic of a colour sensor into a picture. Other pictures stay as they are.

    Parameters
    ----------
    form : of sensor_msgs/CompressedImage: "jpeg", or as image_transport has it, "bayer_rggb8; jpeg
        compressed bgr8": what was published, and what was compressed
    encoded : a picture

    Raises
    ------
    DamagedError
        What is no picture of a camera: a depth image, a frame of a video stream.
    """
    import cv2

    first, _, rest = form.lower().partition(";")
    words = rest.split()
    if "compresseddepth" in rest.replace(" ", "") or any(v in form.lower() for v in VIDEO_FORMS):
        raise DamagedError(f"an image in the format {form!r}")
    kept = words[-1] if len(words) > 2 else first.strip()
    if not kept.startswith("bayer_"):
        return encoded
    pixels = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_UNCHANGED)
    if pixels is None or pixels.ndim != 2 or kept not in CHANNELS:
        return encoded
    return _png(_to_bgr(pixels, kept))


def _png(pixels: NDArray[np.integer]) -> bytes:
    import cv2

    ok, png = cv2.imencode(".png", pixels, [cv2.IMWRITE_PNG_COMPRESSION, QUICK])
    if not ok:
        raise DamagedError("an image cannot be encoded")
    return bytes(png)


def _pixels(message: Fields) -> NDArray[np.integer]:
    """Read pixels (h, w) or (h, w, channels), rows freed of their padding."""
    encoding = message.encoding.lower()
    if encoding not in CHANNELS:
        raise DamagedError(f"an image in the encoding {message.encoding!r}")
    width = 2 if "16" in encoding and not encoding.startswith("yuv") else 1
    row = int(message.width) * CHANNELS[encoding] * width
    data = np.frombuffer(bytes(message.data), np.uint8)
    if (
        not row
        or row > message.step
        or data.size < int(message.step) * int(message.height)
        or not message.height
    ):
        raise DamagedError(
            f"an image of {data.size} bytes for {message.width} x {message.height} pixels"
        )
    rows = np.ascontiguousarray(
        data[: int(message.step) * int(message.height)].reshape(int(message.height), -1)[:, :row]
    )
    if width == 2:
        rows = rows.view(">u2" if message.is_bigendian else "<u2")
    return (
        rows.reshape(int(message.height), int(message.width), -1).squeeze(-1)
        if CHANNELS[encoding] == 1
        else rows.reshape(int(message.height), int(message.width), -1)
    )


def _to_bgr(pixels: NDArray[np.integer], encoding: str) -> NDArray[np.integer]:
    """Convert pixels to gray or blue, green, red, as OpenCV writes them. 16 bits stay."""
    import cv2

    if pixels.dtype.itemsize == 2:
        return np.asarray(pixels, np.uint16)
    codes = {
        "rgb8": cv2.COLOR_RGB2BGR,
        "rgba8": cv2.COLOR_RGBA2BGR,
        "bgra8": cv2.COLOR_BGRA2BGR,
        "8uc4": cv2.COLOR_BGRA2BGR,
        "bayer_rggb8": cv2.COLOR_BayerRGGB2BGR,
        "bayer_bggr8": cv2.COLOR_BayerBGGR2BGR,
        "bayer_gbrg8": cv2.COLOR_BayerGBRG2BGR,
        "bayer_grbg8": cv2.COLOR_BayerGRBG2BGR,
        "yuv422": cv2.COLOR_YUV2BGR_UYVY,
        "uyvy": cv2.COLOR_YUV2BGR_UYVY,
        "yuv422_yuy2": cv2.COLOR_YUV2BGR_YUY2,
        "yuyv": cv2.COLOR_YUV2BGR_YUY2,
    }
    return np.asarray(
        cv2.cvtColor(pixels, codes[encoding]) if encoding in codes else pixels, np.uint8
    )
