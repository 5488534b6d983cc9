# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What [report] of dive.toml says of an inspection: who asked, who dived, with what, the result."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from hullrecon.dive.files import MIB, read_regular
from hullrecon.errors import InputError

LARGEST_LOGO = 4 * MIB  # bytes of the file
MOST_PIXELS = 40_000_000  # of the decoded picture
SHOWN = (640, 200)  # pixels, twice the size on the page: sharp on fine screens


@dataclass(frozen=True, kw_only=True)
class AboutInspection:
    """Texts of the page's blocks, empty if dive.toml has none."""

    client: str = ""
    operator: str = ""
    vessel_operator: str = ""
    equipment: tuple[str, ...] = ()
    water: str = ""
    conclusion: str = ""
    logo: bytes | None = None  # PNG

    def rows(self) -> list[tuple[str, str]]:
        """List the heading and text of each block that dive.toml fills in."""
        rows = [
            ("Client", self.client),
            ("Inspected by", self.operator),
            ("Operator of the vessel", self.vessel_operator),
            ("Equipment", "; ".join(self.equipment)),
            ("Water", self.water),
        ]
        return [(name, text.strip()) for name, text in rows if text.strip()]

    def paragraphs(self) -> list[str]:
        """Split the conclusion into paragraphs at its blank lines."""
        return [
            " ".join(part.split())
            for part in self.conclusion.replace("\r\n", "\n").split("\n\n")
            if part.strip()
        ]


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
