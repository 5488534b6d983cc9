# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Patches of the hull that the DVL saw from two passes, and what ties them."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class PlaneRanges(Rows):
    """Returns that measure planes, one row a beam. plane (r,): of the patch that it fell on; node
    (r,), quaternion (r, 4), translation (r, 3), tray_offset (r,), beam (r, 3) as in Returns;
    range_m (r,): the range to the plane, the measured one plus how far the patch stands over its
    plane along the beam; sigma_m (r,).
    """

    plane: Ints
    node: Ints
    quaternion: Array
    translation: Array
    tray_offset: Array
    beam: Array
    range_m: Array
    sigma_m: Array


@dataclass(frozen=True, kw_only=True)
class TiedPlanes:
    """Planes that touch the hull, each in the vehicle frame of its anchor, a node; what measures
    them; pairs of one surface.

    anchor (p,); plane (p, 3) m: unit normal towards the vehicle times its distance from the
    vehicle's origin. first, second (m,): planes of two passes; difference (m, 3) m: second less
    first, in the vehicle frame of the first's anchor, as the curvature between them makes it;
    information (m, 3, 3): square root of that of the difference. point (m, 3) m: the middle of the
    second's patch in the vehicle frame of its anchor; place (m, 3) m: where it lay in that of the
    first's anchor; by_place (m, 3, 3): of the difference by that place.
    """

    anchor: Ints
    plane: Array
    ranges: PlaneRanges
    first: Ints
    second: Ints
    difference: Array
    information: Array
    point: Array
    place: Array
    by_place: Array

    def __len__(self) -> int:
        """Return the number of ties."""
        return len(self.first)
