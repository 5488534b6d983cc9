# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Convert the pixels of sensor_msgs/Image and mosaics of CompressedImage to PNG, without loss."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.messages.decode import Fields
from hullrecon.dive.logs.readers.unpack import DamagedError

CHANNELS = {
    "mono": 1,
    "bgr": 3,
    "rgb": 3,
    "bgra": 4,
    "rgba": 4,
    "bayer_rggb": 1,
    "bayer_bggr": 1,
    "bayer_gbrg": 1,
    "bayer_grbg": 1,
    "yuv422": 2,
    "uyvy": 2,
    "yuv422_yuy2": 2,
    "yuyv": 2,
}
# encodings that OpenCV names by channels and type, as those of ROS
PLAIN = {"8uc1": "mono8", "8uc3": "bgr8", "8uc4": "bgra8", "16uc1": "mono16", "16uc3": "bgr16"}
# How much rougher 16-bit pixels are, at least, with their bytes in the wrong order. Rows between
# those looked at for that, and least bytes of an image of which rows are skipped
ROUGH, EVERY, LEAST_BYTES = 3.0, 16, 10_000
VIDEO_FORMS = ("h264", "h265", "hevc", "av1", "ffmpeg", "theora")
QUICK = 1  # PNG's compression level: images are written once, and read a few times


def encode_raw(message: Fields) -> bytes:
    """Encode an image as PNG. Raises DamagedError for missing pixels or an unknown encoding."""
    encoding, width = _parse_encoding(message.encoding)
    # how many samples further along a row the same colour comes again
    period = 2 if encoding.startswith("bayer") else CHANNELS[encoding]
    return _png(_to_bgr(_pixels(message, CHANNELS[encoding], width, period), encoding))


def decoded_mosaic(form: str, encoded: bytes) -> bytes:
    """Turn a compressed Bayer mosaic into a colour picture. Other pictures are returned unchanged.

    So are mosaics that cannot be decoded: the image is then found damaged later.

    Parameters
    ----------
    form : `format` of sensor_msgs/CompressedImage: "jpeg", or, as image_transport writes it,
        "bayer_rggb8; jpeg compressed bgr8": the published encoding, and what was compressed
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
    if pixels is None or pixels.ndim != 2 or kept.rstrip("0123456789") not in CHANNELS:
        return encoded
    return _png(_to_bgr(pixels, kept.rstrip("0123456789")))


def _png(pixels: NDArray[np.integer]) -> bytes:
    """Encode pixels as PNG, with little effort for its size."""
    import cv2

    ok, png = cv2.imencode(".png", pixels, [cv2.IMWRITE_PNG_COMPRESSION, QUICK])
    if not ok:
        raise DamagedError("an image cannot be encoded")
    return bytes(png)


def _parse_encoding(encoding: str) -> tuple[str, int]:
    """Read an encoding: its key in CHANNELS, and the bytes of a sample.

    Raises DamagedError for any that is not read.
    """
    lower = encoding.lower()
    name = PLAIN.get(lower, lower)
    if name in CHANNELS:
        return name, 1
    for end, width in (("8", 1), ("16", 2)):
        if name.endswith(end) and name.removesuffix(end) in CHANNELS:
            return name.removesuffix(end), width
    raise DamagedError(f"an image in the encoding {encoding!r}, which is not read")


def _pixels(message: Fields, channels: int, width: int, period: int) -> NDArray[np.integer]:
    """Read pixels (h, w) or (h, w, channels) of a message, without the padding of its rows.

    Where there are exactly the bytes of rows without padding, the message's step is not used: it
    may not be filled in. Raises DamagedError where pixels are missing.

    Parameters
    ----------
    message : sensor_msgs/Image
    channels : samples of a pixel
    width : bytes of a sample, 1 or 2
    period : of the colours along a row, in samples
    """
    height, row, step = (
        int(message.height),
        int(message.width) * channels * width,
        int(message.step),
    )
    data = np.frombuffer(bytes(message.data), np.uint8)
    if row and data.size == row * height:
        step = row
    if not row or not height or row > step or data.size < step * height:
        raise DamagedError(
            f"an image of {data.size} bytes and a step of {step} for {message.width} x {height} "
            f"pixels of {channels * width} bytes"
        )
    rows = np.ascontiguousarray(data[: step * height].reshape(height, -1)[:, :row])
    pixels = _read_16_bits(rows, bool(message.is_bigendian), period) if width == 2 else rows
    shape = (height, int(message.width), channels)
    return pixels.reshape(shape[:2] if channels == 1 else shape)


def _read_16_bits(rows: NDArray[np.uint8], is_bigendian: bool, period: int) -> NDArray[np.integer]:
    """Read samples of 16 bits. Raises DamagedError where their bytes are in the other order.

    Neighbouring samples of a colour are alike. With the bytes exchanged they differ all over.

    Parameters
    ----------
    rows : (h, bytes) of the image
    is_bigendian : as the message states
    period : of the colours along a row, in samples

    Returns
    -------
    samples (h, n)
    """
    orders = (">u2", "<u2") if is_bigendian else ("<u2", ">u2")
    stated, exchanged = (_roughness(rows[::EVERY].view(order), period) for order in orders)
    if rows.size > LEAST_BYTES and stated > ROUGH * exchanged:
        raise DamagedError(
            "an image of 16 bits whose bytes are not in the order that is_bigendian = "
            f"{int(is_bigendian)} states"
        )
    return rows.view(orders[0])


def _roughness(pixels: NDArray[np.integer], period: int) -> float:
    """Compute the mean difference of neighbours along rows over the standard deviation of all.

    pixels: (h, n). period: samples from one neighbour to the next.
    """
    values = pixels.astype(float)
    steps = np.abs(values[:, period:] - values[:, :-period])
    return float(steps.mean() / max(values.std(), 1.0)) if steps.size else 0.0


def _to_bgr(pixels: NDArray[np.integer], encoding: str) -> NDArray[np.integer]:
    """Convert pixels to gray or blue, green, red, as OpenCV writes them. 16 bits stay."""
    import cv2

    codes = {
        "rgb": cv2.COLOR_RGB2BGR,
        "rgba": cv2.COLOR_RGBA2BGR,
        "bgra": cv2.COLOR_BGRA2BGR,
        "bayer_rggb": cv2.COLOR_BayerRGGB2BGR,
        "bayer_bggr": cv2.COLOR_BayerBGGR2BGR,
        "bayer_gbrg": cv2.COLOR_BayerGBRG2BGR,
        "bayer_grbg": cv2.COLOR_BayerGRBG2BGR,
        "yuv422": cv2.COLOR_YUV2BGR_UYVY,
        "uyvy": cv2.COLOR_YUV2BGR_UYVY,
        "yuv422_yuy2": cv2.COLOR_YUV2BGR_YUY2,
        "yuyv": cv2.COLOR_YUV2BGR_YUY2,
    }
    native = pixels.astype(np.uint16 if pixels.dtype.itemsize == 2 else np.uint8)
    return np.asarray(cv2.cvtColor(native, codes[encoding]) if encoding in codes else native)
