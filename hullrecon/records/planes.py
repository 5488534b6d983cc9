# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Patches of hull that the DVL saw on two passes, and the constraints between them."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.native import PlanePairTable, PlaneRangeTable, PlaneTable
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class TiedPlanes:
    """Planes that touch the hull, the returns that measure them, and pairs of one surface.

    The tables are those of a native problem.
    """

    # (p, 3) m: unit normal towards the vehicle times its distance from the vehicle's origin, in the
    # vehicle frame of the plane's anchor
    plane: Array
    table: PlaneTable
    # The range to the plane: measured, plus how far the patch stands over its plane along the beam
    ranges: PlaneRangeTable
    pairs: PlanePairTable  # planes of two passes, which differ by the hull's curvature

    def __len__(self) -> int:
        """Count the pairs."""
        return len(self.pairs.first)
