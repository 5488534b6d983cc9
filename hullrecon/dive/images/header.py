# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the size of an image from its header, before anything of it is decoded."""

from __future__ import annotations

import io
import warnings
from typing import Literal

LARGEST_PIXELS = 80_000_000  # decoded in colour a PNG takes six bytes for each (measured): 480 MB
PNG, JPEG, RIFF = b"\x89PNG\r\n\x1a\n", b"\xff\xd8", b"RIFF"
# of files with one image
IMAGE_SUFFIXES = frozenset((".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff"))
OTHERS = ("BMP", "GIF", "JPEG2000", "PPM", "TIFF")
FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # JPEG's markers that carry a size
Size = tuple[int, int]


def header_size(encoded: bytes) -> Size | None:
    """Return (width, height) as the header of an image says; None for bytes that are no image that
    is read here.
    """
    if encoded.startswith(JPEG):
        return _jpeg_size(encoded)
    if encoded.startswith(PNG):
        return _png_size(encoded)
    if encoded.startswith(RIFF):
        return _webp_size(encoded)
    return _other_size(encoded)


def fits(size: Size) -> bool:
    """Return whether an image of that size may be decoded."""
    return 0 < size[0] * size[1] <= LARGEST_PIXELS


def _png_size(encoded: bytes) -> Size | None:
    """Return the size of a PNG whose chunks are all there: OpenCV makes room for what each claims,
    up to four gigabytes.
    """
    at = len(PNG)
    while at + 12 <= len(encoded) and encoded[at + 4 : at + 8] != b"IEND":
        at += 12 + int.from_bytes(encoded[at : at + 4], "big")
    is_whole = at + 12 <= len(encoded) and encoded[12:16] == b"IHDR"
    return _pair(encoded, 16, 4, "big") if is_whole else None


def _jpeg_size(encoded: bytes) -> Size | None:
    at = 2
    while at + 4 <= len(encoded) and encoded[at] == 0xFF:
        code = encoded[at + 1]
        if code == 0xFF:
            at += 1
        elif code in FRAMES:
            size = _pair(encoded, at + 5, 2, "big")
            return None if size is None else (size[1], size[0])
        else:
            at += 2 + int.from_bytes(encoded[at + 2 : at + 4], "big")
    return None


def _webp_size(encoded: bytes) -> Size | None:
    kind = encoded[12:16]
    if kind == b"VP8X":
        size = _pair(encoded, 24, 3, "little")
        return None if size is None else (size[0] + 1, size[1] + 1)
    if kind == b"VP8L" and len(encoded) >= 25:
        bits = int.from_bytes(encoded[21:25], "little")
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    if kind == b"VP8 ":
        size = _pair(encoded, 26, 2, "little")
        return None if size is None else (size[0] & 0x3FFF, size[1] & 0x3FFF)
    return None


def _other_size(encoded: bytes) -> Size | None:
    """Return the size as Pillow reads it, which decodes nothing before it is asked to."""
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about sizes and tags that are odd
        try:
            with Image.open(io.BytesIO(encoded), formats=OTHERS) as image:
                return image.size
        except Exception:  # Pillow raises whatever damaged bytes lead it to
            return None


def _pair(encoded: bytes, at: int, width: int, order: Literal["big", "little"]) -> Size | None:
    """Return two numbers of `width` bytes each; None where the bytes end before them."""
    if len(encoded) < at + 2 * width:
        return None
    first, second = (int.from_bytes(encoded[k : k + width], order) for k in (at, at + width))
    return first, second
