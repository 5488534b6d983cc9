# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The logo that [report] of dive.toml names."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from hullrecon.dive.files import MIB, read_regular
from hullrecon.errors import InputError

LARGEST_LOGO = 4 * MIB  # bytes of the file
MOST_PIXELS = 40_000_000  # of the decoded picture
SHOWN = (640, 200)  # pixels, twice the size on the page: sharp on fine screens


def read_logo(path: Path) -> bytes:
    """Read a logo and shrink it to a PNG of at most SHOWN pixels, without the file's metadata.

    Raises InputError if the file is no PNG, JPEG or WebP of at most 4 MiB.
    """
    from PIL import Image

    what = f"report.logo cannot be used: {path.name}"
    try:
        data = read_regular(path, LARGEST_LOGO)
    except OSError as error:
        raise InputError(
            f"{what}: {error.strerror}", where=str(path.parent), remedy="correct [report] logo"
        ) from None
    try:
        with Image.open(BytesIO(data), formats=("PNG", "JPEG", "WEBP")) as picture:
            if picture.width * picture.height > MOST_PIXELS:
                raise ValueError("too many pixels")
            shown = picture.convert("RGBA")
    except (
        OSError,
        ValueError,
        SyntaxError,
        Image.DecompressionBombError,
        Image.DecompressionBombWarning,
    ):
        raise InputError(
            f"{what}: no PNG, JPEG or WebP that can be read",
            where=str(path.parent),
            remedy="give the logo as a PNG",
        ) from None
    shown.thumbnail(SHOWN)
    buffer = BytesIO()
    shown.save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()
