# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Planes of the pose graph: planar patches of the hull that bound the drift without a camera
[Ozog2016 2.3.4].

A plane is three numbers, pi (m): its unit normal towards the origin of its frame times its distance
from it, so that pi . x = -|pi|^2 on it. It is held in the vehicle frame of its anchor, the node
that first saw it: in g it would be singular where it passes through the origin [Ozog2016 B.4].
"""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.native.columns import floats, integers
from hullrecon.typing import Array, Ints32


@dataclass(frozen=True, kw_only=True)
class PlaneTable:
    """Where the planes of Unknowns.plane (p, 3) are held. anchor (p,): nodes."""

    anchor: Ints32 = integers(0)


@dataclass(frozen=True, kw_only=True)
class PlaneSightingTable:
    """Planes seen from poses [Ozog2016 eq. 2.2]: sqrt_information @ (plane in the vehicle frame of
    the node - measured).

    node, plane (m,); measured (m, 3) m; sqrt_information (m, 3, 3). A sighting from the anchor
    joins no poses.
    """

    node: Ints32 = integers(0)
    plane: Ints32 = integers(0)
    measured: Array = floats(0, 3)
    sqrt_information: Array = floats(0, 3, 3)


@dataclass(frozen=True, kw_only=True)
class PlanePairTable:
    """Pairs of planes on one smooth surface, piecewise planar [Ozog2016 eq. 2.3]: sqrt_information
    @ (second - first - measured - by_place @ (y - place)), both in the vehicle frame of the first's
    anchor.

    first, second (m,): planes, different; measured (m, 3) m: the difference that the curvature
    between them makes, zeros where it is left to sqrt_information (m, 3, 3). `curvature_difference`
    and `curvature_information` give both from radii. That difference is of a second plane whose
    point (m, 3) m, in the vehicle frame of its anchor, lies at place (m, 3) m in that of the
    first's; by_place (m, 3, 3): by how much it changes with where the point lies, y; zeros where it
    does not.
    """

    first: Ints32 = integers(0)
    second: Ints32 = integers(0)
    measured: Array = floats(0, 3)
    sqrt_information: Array = floats(0, 3, 3)
    point: Array = floats(0, 3)
    place: Array = floats(0, 3)
    by_place: Array = floats(0, 3, 3)


@dataclass(frozen=True, kw_only=True)
class PlaneRangeTable:
    """Ranges of single DVL beams to planes [Ozog2016 eq. 2.4, its sign and square corrected]:
    (predicted - measured) / sigma, under Huber's loss (Options.huber_range); predicted is -(h + n .
    o) / (n . d) for a beam from o along d and a plane n . x = -h, in the vehicle frame of the node.

    node, plane (m,); offset (m, 7), tray_offset (m,), beam (m, 3), measured, sigma (m,) as in
    RangeTable.
    """

    node: Ints32 = integers(0)
    plane: Ints32 = integers(0)
    offset: Array = floats(0, 7)
    tray_offset: Array = floats(0)
    beam: Array = floats(0, 3)
    measured: Array = floats(0)
    sigma: Array = floats(0)
