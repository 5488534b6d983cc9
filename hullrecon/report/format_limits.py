# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The size limit of WebP, and how far a picture shrinks to keep to a limit.

A long narrow survey reaches it first: 45 m at 2.2 mm a pixel are 20,000 pixels.
"""

from __future__ import annotations

import math

WEBP_SIDE_PX = 16_383  # 14 bits a side (RFC 9649, section 2.5); libwebp refuses one more


def reduction(width_px: float, height_px: float, side_px: float, pixels: float = math.inf) -> float:
    """Compute the factor, at least 1, by which a picture shrinks to keep to a side and an area."""
    return max(1.0, max(width_px, height_px) / side_px, math.sqrt(width_px * height_px / pixels))
