# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Size limits of the formats that are written and of the browsers that show them.

A long narrow survey reaches them first: 45 m at 2.2 mm a pixel are 20,000 pixels.
"""

from __future__ import annotations

import math

# Formats
WEBP_SIDE_PX = 16_383  # 14 bits a side (RFC 9649, section 2.5); libwebp refuses one more
JPEG_SIDE_PX = 65_500  # JPEG_MAX_DIMENSION of libjpeg-turbo, which OpenCV and Pillow write with
# (the format itself has 16 bits a side, ITU-T T.81 B.2.2)
PNG_SIDE_PX = 2**16 - 1  # matplotlib's Agg renderer until 3.8; PNG itself has 2^31 - 1
PDF_SIDE_UNITS = 14_400  # of a page, 200 in (ISO 32000-1, annex C.2); our pages are A4
GLB_BYTES = 2**32 - 1  # length of file and chunk are 32 bits (glTF 2.0, section 4.4)
SINGLE_PRECISION = 2.0**-24  # relative rounding of float32 (IEEE 754), which glTF and WebGL store

# Browsers
CANVAS_PIXELS = 16_777_216  # a canvas whose pixels are read: Safari (4096 squared) has the fewest
TEXTURE_SIDE_PX = 4096  # of WebGL on any device; three.js shrinks a larger one to the device's own


def reduction(width_px: float, height_px: float, side_px: float, pixels: float = math.inf) -> float:
    """Compute the factor, at least 1, by which a picture shrinks to keep to a side and an area."""
    return max(1.0, max(width_px, height_px) / side_px, math.sqrt(width_px * height_px / pixels))
