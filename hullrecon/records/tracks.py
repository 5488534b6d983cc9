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
    """Image features followed over images, sorted by (landmark, node)."""

    landmark: Ints  # (m,)
    node: Ints  # (m,)
    top: Array  # (m, 2) px in the raw image, NaN where that camera did not see it
    bottom: Array  # (m, 2) px
    response: Array  # (m,) of the detector, mean of both images, NaN for corners
    color: NDArray[np.uint8]  # (landmarks, 3) RGB

    SHARED: ClassVar = frozenset({"color"})
