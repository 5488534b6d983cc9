# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is seen on the screen, as pixels. The rasteriser's last bit is not the same in every picture
of the same thing.
"""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Locator

Picture = NDArray[np.int64]
LAST_BITS = 3
OTHER = 12  # levels: another eye would call it another colour
MOST_PICTURES = 100


def picture_of(element: Locator) -> Picture:
    """Return what an element looks like now, (h, w, 3) RGB."""
    return np.asarray(Image.open(io.BytesIO(element.screenshot())).convert("RGB")).astype(np.int64)


def picture_at_rest(element: Locator) -> Picture:
    """Return what an element looks like once it has stopped changing."""
    last = picture_of(element)
    for _ in range(MOST_PICTURES):
        element.page.wait_for_timeout(150)
        now = picture_of(element)
        if now.shape == last.shape and np.abs(now - last).max() <= LAST_BITS:
            return now
        last = now
    raise AssertionError("the page does not come to rest")


def share_changed(before: Picture, after: Picture) -> float:
    """Return the share of pixels that have another colour; 1 where the size is another."""
    if before.shape != after.shape:
        return 1.0
    return float((np.abs(before - after).max(axis=2) > OTHER).mean())
