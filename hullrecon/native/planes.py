# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Planes of the pose graph: patches of hull that bound the drift without a camera [Ozog2016 2.3.4].

A plane is three numbers, pi (m): its unit normal towards the origin of its frame times its distance
from it, so that pi . x = -|pi|^2 on it. It is held in the vehicle frame of its anchor, the node
that first saw it: in g it would be singular where it passes through the origin [Ozog2016 B.4].
"""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.native.columns import floats, integers
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints32


@dataclass(frozen=True, kw_only=True)
class PlaneTable(Rows):
    """The anchors of the planes in Unknowns.plane."""

    anchor: Ints32 = integers(0)  # (p,) node in whose vehicle frame each plane is given


@dataclass(frozen=True, kw_only=True)
class PlaneSightingTable(Rows):
    """Planes seen from poses [Ozog2016 eq. 2.2].

    sqrt_information @ (plane in the vehicle frame of the node - measured). A sighting from the
    plane's anchor constrains the plane alone, and no poses.
    """

    node: Ints32 = integers(0)  # (m,)
    plane: Ints32 = integers(0)  # (m,)
    measured: Array = floats(0, 3)  # (m, 3) m
    sqrt_information: Array = floats(0, 3, 3)  # (m, 3, 3)


@dataclass(frozen=True, kw_only=True)
class PlanePairTable(Rows):
    """Pairs of planes on one smooth surface, piecewise planar [Ozog2016 eq. 2.3].

    sqrt_information @ (second - first - measured - by_place @ (y - place)), both planes in the
    vehicle frame of the first's anchor; y is where `point` lies there. `curvature_difference` and
    `curvature_information` give measured and sqrt_information from radii.
    """

    first: Ints32 = integers(0)  # (m,) planes
    second: Ints32 = integers(0)  # (m,) planes, others than first
    # (m, 3) m difference due to curvature; zeros where sqrt_information allows for it instead
    measured: Array = floats(0, 3)
    sqrt_information: Array = floats(0, 3, 3)  # (m, 3, 3)
    point: Array = floats(0, 3)  # (m, 3) m on the second plane, in the vehicle frame of its anchor
    # (m, 3) m value of y for which `measured` holds, in the vehicle frame of the first's anchor
    place: Array = floats(0, 3)
    # (m, 3, 3) derivative of the difference by y; zeros where it is constant
    by_place: Array = floats(0, 3, 3)


@dataclass(frozen=True, kw_only=True)
class PlaneRangeTable(Rows):
    """Ranges of single DVL beams to planes [Ozog2016 eq. 2.4, its sign and square corrected].

    (predicted - measured) / sigma, under Huber's loss (Options.huber_range). The predicted range is
    -(h + n . o) / (n . d) for a beam from o along d and a plane n . x = -h, in the vehicle frame of
    the node. Columns are as in RangeTable.
    """

    node: Ints32 = integers(0)  # (m,)
    plane: Ints32 = integers(0)  # (m,)
    offset: Array = floats(0, 7)  # (m, 7)
    tray_offset: Array = floats(0)  # (m,) rad
    beam: Array = floats(0, 3)  # (m, 3) unit
    measured: Array = floats(0)  # (m,) m
    sigma: Array = floats(0)  # (m,) m
