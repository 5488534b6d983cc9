# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Images with 16 bits a sample, of which a camera fills 10, 12 or 14."""

from __future__ import annotations

import io
import warnings

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.images.header import LARGEST_PIXELS, PNG, header_size
from hullrecon.typing import Pixels

# the first bytes of PGM and TIFF, which may have 16 bits
GRAY_OR_TIFF = (b"P2", b"P5", b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
BITS_PER_SAMPLE = 258  # TIFF's tag
# of larger ones the upper 8 bits are read: in colour each takes 12 bytes, half a gigabyte
MOST_PIXELS = LARGEST_PIXELS // 2
DEPTHS = (8, 10, 12, 14)  # bits that cameras measure; 16 take all that two bytes hold


def is_deep(encoded: bytes) -> bool:
    """Return whether it is a PNG, TIFF or PGM of 16 bits a sample, and none too large to be decoded
    with them.
    """
    if not (encoded.startswith(PNG) or encoded.startswith(GRAY_OR_TIFF)):
        return False
    size = header_size(encoded)
    if size is None or not 0 < size[0] * size[1] <= MOST_PIXELS:
        return False
    return encoded[24:25] == b"\x10" if encoded.startswith(PNG) else _pillow_finds_16_bits(encoded)


def _pillow_finds_16_bits(encoded: bytes) -> bool:
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about sizes and tags that are odd
        try:
            with Image.open(io.BytesIO(encoded), formats=("PPM", "TIFF")) as image:
                tags = getattr(image, "tag_v2", None)
                return (
                    image.mode.startswith("I")
                    if tags is None
                    else set(tags.get(BITS_PER_SAMPLE, (1,))) == {16}
                )
        except Exception:  # Pillow raises whatever damaged bytes lead it to
            return False


def decode_deep(encoded: bytes) -> NDArray[np.uint16] | None:
    """Return the samples (h, w), or (h, w, 3) blue, green, red; None where they are damaged or have
    a sign.
    """
    import cv2

    flags = cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        image = cv2.imdecode(np.frombuffer(encoded, np.uint8), flags)
    except cv2.error:
        return None
    return np.asarray(image, np.uint16) if image is not None and image.dtype == np.uint16 else None


def significant_bits(largest: int | None) -> int:
    """Return the bits that hold the largest value of all images of a camera; 16 where none has 16
    bits.

    Of all, not of each: an image's brightness stays comparable with another's.
    """
    return next((bits for bits in DEPTHS if largest is not None and largest < 1 << bits), 16)


def upper_eight(image: NDArray[np.uint16], bits: int) -> Pixels:
    """Return the upper 8 of so many lower bits of what decode_deep gave, larger values as 255, (h,
    w, 3) RGB. `image` is written over.
    """
    import cv2

    np.right_shift(image, bits - 8, out=image)  # in place, for large images
    shallow = np.minimum(image, 255, out=image).astype(np.uint8)
    return np.asarray(
        cv2.cvtColor(shallow, cv2.COLOR_GRAY2RGB if shallow.ndim == 2 else cv2.COLOR_BGR2RGB),
        np.uint8,
    )
