# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull chart: a two-dimensional coordinate (along, girth) in metres on the hull, and hull addresses."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Chart(Protocol):
    """Coordinates on a surface. `along` grows forward, `girth` from the keel up, port positive (metres of arc)."""

    def to_chart(self, points: Array) -> Array:
        """(n, 3) points near the surface, in the chart's frame (M, or g without a drawing), to (n, 3):
        along, girth, offset (metres, outward positive)."""

    def from_chart(self, along_girth: Array) -> tuple[Array, Array]:
        """(n, 2) to points on the surface (n, 3) and outward unit normals (n, 3); NaN rows outside the chart."""

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """What an artifact stores; `chart_from_arrays` reads it back."""
