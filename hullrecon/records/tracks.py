# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Image features followed over images."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class Tracks(Rows):
    """Observations, sorted by (landmark, node): landmark (m,), node (m,), top (m, 2) and bottom (m,
    2) pixels in the raw (distorted) images, NaN where that camera did not see it. response (m,): of
    the feature detector, the mean of both images; NaN for corners, whose detector has another
    scale. color (landmarks, 3) uint8 RGB.
    """

    landmark: Ints
    node: Ints
    top: Array
    bottom: Array
    response: Array
    color: NDArray[np.uint8]

    SHARED: ClassVar = frozenset({"color"})
