# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Encoded images: their size by the header, whether they are whole, and their pixels.

OpenCV decodes. It makes room for whatever a header claims (a PNG chunk of four gigabytes, an image
of a billion pixels) and forgives a lot (half a JPEG comes back as a half-gray picture), so that
sizes, PNG chunks and JPEG markers are checked before it sees the bytes. Pillow reads the other
headers, and decodes nothing before it is asked to.
"""

from __future__ import annotations

import io
import re
import warnings
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Pixels

LARGEST_PIXELS = 80_000_000  # decoded in colour a PNG takes six bytes for each (measured): 480 MB
PNG, JPEG, RIFF = b"\x89PNG\r\n\x1a\n", b"\xff\xd8", b"RIFF"
# of files with one image
IMAGE_SUFFIXES = frozenset((".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff"))
BY_PILLOW = ("BMP", "GIF", "JPEG", "JPEG2000", "PPM", "TIFF")
# the first bytes of PGM and TIFF, which may have 16 bits a sample
GRAY_OR_TIFF = (b"P2", b"P5", b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
BITS_PER_SAMPLE = 258  # TIFF's tag
# of larger images of 16 bits the upper 8 are read: in colour each pixel takes 12 bytes
MOST_DEEP_PIXELS = LARGEST_PIXELS // 2
EXIF_ORIENTATION = 0x0112
TURNS = {  # by the values of that tag; 1 is as stored
    2: "mirrored",
    3: "turned by 180 degrees",
    4: "mirrored",
    5: "turned by 270 degrees and mirrored",
    6: "turned by 90 degrees",
    7: "turned by 90 degrees and mirrored",
    8: "turned by 270 degrees",
}
DEPTHS = (8, 10, 12, 14)  # bits that cameras measure; 16 take all that two bytes hold
MARKER = re.compile(rb"\xff([\x01-\xfe])")  # of a JPEG
END, SCAN, RESTART = 0xD9, 0xDA, range(0xD0, 0xD8)
# cv2.IMREAD_*; OpenCV itself is imported when it is needed
GRAYSCALE, ANY_DEPTH_AND_COLOR, COLOR_RGB = 0, 2 | 4, 256
# How much more pixels side by side differ than those two apart: 0.6 in pictures, 1 in noise, 5 to 9
# in Bayer mosaics, whose neighbours are of other colours (rendered and real, under water). Every so
# many rows and columns are looked at
MOSAIC, EVERY = 1.5, 16
Size = tuple[int, int]  # width, height


@dataclass(frozen=True)
class CheckedImage:
    """Result of checking an encoded image."""

    size: Size | None  # None for a damaged image and for other bytes
    largest: int | None = None  # value of an image whose samples have 16 bits
    is_mosaic: bool = False  # a Bayer mosaic that is stored as a gray picture


def header_size(encoded: bytes) -> Size | None:
    """Read (width, height) from an image's header. None for bytes that are no readable image."""
    if encoded.startswith(PNG):
        return _png_size(encoded)
    if encoded.startswith(RIFF):
        return _webp_size(encoded)
    return _pillow_size(encoded)


def turn_in_exif(encoded: bytes) -> str:
    """Say how EXIF would have a picture shown, such as "turned by 180 degrees". "" for as stored.

    Nothing here turns pictures: a calibration is one of the sensor.
    """
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with Image.open(io.BytesIO(encoded), formats=("JPEG", "PNG", "TIFF", "WEBP")) as image:
                return TURNS.get(image.getexif().get(EXIF_ORIENTATION, 1), "")
        except Exception:  # Pillow raises whatever damaged bytes lead it to
            return ""


def fits(size: Size) -> bool:
    """Tell whether an image of this size may be decoded."""
    return 0 < size[0] * size[1] <= LARGEST_PIXELS


def check_image(encoded: bytes, wanted: Size | None = None) -> CheckedImage:
    """Check that an image is whole, by decoding it.

    An image that is too large, or whose header states another size than the wanted one, is not
    decoded: the size that its header states is returned unchecked. wanted: None for any size.
    """
    size = header_size(encoded)
    if size is None or not fits(size) or wanted not in (None, size):
        return CheckedImage(size)
    if encoded.startswith(JPEG) and not jpeg_is_whole(encoded):
        return CheckedImage(None)
    deep = decode_deep(encoded) if is_deep(encoded) else None
    if deep is not None:
        return CheckedImage((deep.shape[1], deep.shape[0]), int(deep.max()), _is_mosaic(deep))
    image = _decode(encoded, GRAYSCALE)
    if image is None:
        return CheckedImage(None)
    size = int(image.shape[1]), int(image.shape[0])
    return CheckedImage(size, is_mosaic=_is_mosaic(image))


def _is_mosaic(image: NDArray[np.integer]) -> bool:
    """Tell whether an image (h, w) has its colours side by side, as the sensor measures them."""
    if image.ndim != 2 or min(image.shape) < EVERY:
        return False
    steps = []
    for rows in (image[::EVERY].astype(float), image[:, ::EVERY].T.astype(float)):
        near, far = (np.abs(rows[:, k:] - rows[:, :-k]).mean() for k in (1, 2))
        steps.append(near > MOSAIC * far)
    return all(steps)


def decode(encoded: bytes, bits: int = 16) -> Pixels | None:
    """Decode an image into (h, w, 3) RGB, without EXIF rotation.

    JPEG, PNG, TIFF, BMP, PNM, WebP, GIF and JPEG 2000 are read. None for bytes that are none of
    these, that are damaged beyond decoding, or that claim more than LARGEST_PIXELS.

    bits: 16-bit samples are reduced to the upper 8 of their lower `bits` bits. Larger values become
    255.
    """
    size = header_size(encoded)
    if size is None or not fits(size):
        return None
    deep = decode_deep(encoded) if bits < 16 and is_deep(encoded) else None
    if deep is not None:
        return _upper_eight(deep, bits)
    image = _decode(encoded, COLOR_RGB)
    return None if image is None else np.asarray(image, np.uint8)


def is_deep(encoded: bytes) -> bool:
    """Tell whether bytes are a decodable PNG, TIFF or PGM of 16 bits per sample."""
    if not (encoded.startswith(PNG) or encoded.startswith(GRAY_OR_TIFF)):
        return False
    size = header_size(encoded)
    if size is None or not 0 < size[0] * size[1] <= MOST_DEEP_PIXELS:
        return False
    return encoded[24:25] == b"\x10" if encoded.startswith(PNG) else _pillow_finds_16_bits(encoded)


def decode_deep(encoded: bytes) -> NDArray[np.uint16] | None:
    """Decode 16 bits per sample into (h, w), or (h, w, 3) blue, green, red.

    None where the image is damaged or its samples are signed.
    """
    image = _decode(encoded, ANY_DEPTH_AND_COLOR)
    return np.asarray(image, np.uint16) if image is not None and image.dtype == np.uint16 else None


def significant_bits(largest: int | None) -> int:
    """Find the bits that hold the largest value of all images of a camera.

    All images share them, so that their brightness stays comparable. 16 where no image has 16 bits.
    """
    return next((bits for bits in DEPTHS if largest is not None and largest < 1 << bits), 16)


def jpeg_is_whole(encoded: bytes) -> bool:
    """Tell whether a JPEG reaches its end marker, and restart markers in its scans are in order.

    A decoder fills what is missing with gray.
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
    """Find the marker behind a scan's data. None without one, or for a restart out of order."""
    restarts = 0
    for match in MARKER.finditer(encoded, at):
        code = match[1][0]
        if code not in RESTART:
            return match.start()
        if code != RESTART[restarts % 8]:
            return None
        restarts += 1  # noqa: SIM113 (it counts restarts, not matches)
    return None


def _png_size(encoded: bytes) -> Size | None:
    """Read the size of a PNG. None where a chunk is cut off: OpenCV allocates what each claims."""
    at = len(PNG)
    while at + 12 <= len(encoded) and encoded[at + 4 : at + 8] != b"IEND":
        at += 12 + int.from_bytes(encoded[at : at + 4], "big")
    is_whole = at + 12 <= len(encoded) and encoded[12:16] == b"IHDR"
    return _pair(encoded, 16, 4, "big") if is_whole else None


def _webp_size(encoded: bytes) -> Size | None:
    """Read the size of a WebP, whose canvas Pillow would allocate. None where it is cut off."""
    kind = encoded[12:16]
    if kind == b"VP8L" and len(encoded) >= 25:
        bits = int.from_bytes(encoded[21:25], "little")
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    if kind == b"VP8X" and (size := _pair(encoded, 24, 3, "little")):
        return size[0] + 1, size[1] + 1
    if kind == b"VP8 " and (size := _pair(encoded, 26, 2, "little")):
        return size[0] & 0x3FFF, size[1] & 0x3FFF
    return None


def _pillow_size(encoded: bytes) -> Size | None:
    """Read the size of an image of BY_PILLOW. None for any other."""
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about sizes and tags that are odd
        try:
            with Image.open(io.BytesIO(encoded), formats=BY_PILLOW) as image:
                return image.size
        except Exception:  # Pillow raises whatever damaged bytes lead it to
            return None


def _pillow_finds_16_bits(encoded: bytes) -> bool:
    """Tell whether a PPM or TIFF has 16 bits a channel."""
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with Image.open(io.BytesIO(encoded), formats=("PPM", "TIFF")) as image:
                tags = getattr(image, "tag_v2", None)
                if tags is None:
                    return image.mode.startswith("I")
                return set(tags.get(BITS_PER_SAMPLE, (1,))) == {16}
        except Exception:  # as above
            return False


def _pair(encoded: bytes, at: int, width: int, order: Literal["big", "little"]) -> Size | None:
    """Read two numbers of `width` bytes each. None where the bytes end before them."""
    if len(encoded) < at + 2 * width:
        return None
    first, second = (int.from_bytes(encoded[k : k + width], order) for k in (at, at + width))
    return first, second


def _decode(encoded: bytes, flags: int) -> NDArray[np.integer] | None:
    """Decode an image by OpenCV, as stored. None where it cannot be. flags: cv2.IMREAD_*."""
    import cv2

    try:
        return cv2.imdecode(np.frombuffer(encoded, np.uint8), flags | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error:
        return None


def _upper_eight(image: NDArray[np.uint16], bits: int) -> Pixels:
    """Reduce samples of `bits` bits to their upper 8 as (h, w, 3) RGB. Overwrites `image`.

    image: (h, w), or (h, w, 3) blue, green, red.
    """
    import cv2

    np.right_shift(image, bits - 8, out=image)  # in place, for large images
    shallow = np.minimum(image, 255, out=image).astype(np.uint8)
    code = cv2.COLOR_GRAY2RGB if shallow.ndim == 2 else cv2.COLOR_BGR2RGB
    return np.asarray(cv2.cvtColor(shallow, code), np.uint8)
