# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Patches of the hull that the DVL saw from two passes, and what ties them."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class PlaneRanges(Rows):
    """Returns that measure planes, one row a beam."""

    plane: Ints  # (r,) of the patch that it fell on
    node: Ints  # (r,) and so on as in Returns
    quaternion: Array
    translation: Array
    tray_offset: Array
    beam: Array
    # (r,) to the plane: measured, plus how far the patch stands over its plane along the beam
    range_m: Array
    sigma_m: Array  # (r,)


@dataclass(frozen=True, kw_only=True)
class TiedPlanes:
    """Planes that touch the hull, what measures them, and pairs of one surface."""

    anchor: Ints  # (p,) node in whose vehicle frame a plane is
    # (p, 3) m: unit normal towards the vehicle times its distance from the vehicle's origin
    plane: Array
    ranges: PlaneRanges
    first: Ints  # (m,) planes of two passes
    second: Ints  # (m,) planes
    # (m, 3) m: second less first by the curvature between them, in the vehicle frame of the first's
    # anchor
    difference: Array
    information: Array  # (m, 3, 3) square root of the information of the difference
    point: Array  # (m, 3) m: middle of the second's patch in the vehicle frame of its anchor
    place: Array  # (m, 3) m: where that lay in the vehicle frame of the first's anchor
    by_place: Array  # (m, 3, 3) derivative of the difference by that place

    def __len__(self) -> int:
        """Count the pairs."""
        return len(self.first)
