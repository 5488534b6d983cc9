# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two surveys of one hull, and what changed between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.lattice import Lattice
from hullrecon.geometry.poses import Poses
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.solution import HullPose
from hullrecon.records.surface import Surface
from hullrecon.typing import Array, Mask

Status = Literal[
    "new", "gone", "grown", "shrunk", "unchanged", "uncertain", "not seen before", "not seen again"
]
CHANGED: tuple[Status, ...] = ("new", "gone", "grown", "shrunk")


@dataclass(frozen=True, kw_only=True)
class HullSurvey:
    """The hull as one dive surveyed it, in its own hull frame M."""

    name: str
    chart: Chart
    as_found: Surface  # support 0 where unseen
    form_sigma: Array  # (n,) m, of each vertex's form, without the hull pose's uncertainty
    hull_pose: HullPose
    objects: tuple[ReportedObject, ...]  # as reported


@dataclass(frozen=True, kw_only=True)
class SurveyOffset:
    """The second survey's pose in the first survey's hull frame.

    Both lie on the CAD model within their hull poses' sigmas only.
    """

    first_from_second: Poses  # a batch of one, near the identity
    covariance: Array  # (6, 6) of (translation, rotation about center), m and rad
    prior_covariance: Array  # (6, 6) sum of both hull poses' covariances
    center: Array  # (3,) m in M
    chi_square: float  # of the offset by its prior, 6 degrees of freedom
    p_value: float  # probability of as large a chi-square


@dataclass(frozen=True, kw_only=True)
class ObjectChange:
    """An object of either survey, or a place where the surface changed as an object does."""

    status: Status
    first_id: int | None  # in the first survey's objects.json
    second_id: int | None  # in the second survey's
    center: Array  # (3,) m in the first survey's M
    along_girth: Array  # (2,) m on the chart
    outline: Array  # (k, 2) m along and in girth there
    height_before: float  # m above the hull around it, NaN if not seen
    height_after: float  # m
    height_before_sigma: float
    height_after_sigma: float
    change: float  # m
    change_sigma: float
    p_value: float  # probability of such a change at any place of an unchanged hull
    area: float  # m2 of what changed
    sigma: Array  # (3,) m of the place, along, in girth, along the normal
    address: str = ""


@dataclass(frozen=True, kw_only=True)
class SurfaceMove:
    """A part of bare hull that moved."""

    along_girth: Array  # (2,) m of its middle on the chart
    outline: Array  # (k, 2) m along and in girth
    move: float  # m, outward positive
    move_sigma: float
    p_value: float  # corrected for the number of patches compared
    area: float  # m2
    address: str = ""


@dataclass(frozen=True, kw_only=True)
class ChangeMap:
    """Cells (a, g) of the chart."""

    lattice: Lattice
    # m, second survey's height minus the first's without the offset, NaN unless both saw the hull
    change: Array
    sigma: Array  # m
    first_seen: Mask  # cells that the first survey saw
    second_seen: Mask


@dataclass(frozen=True, kw_only=True)
class HullChange:
    """What changed between two surveys."""

    first: str
    second: str
    offset: SurveyOffset
    objects: tuple[ObjectChange, ...]
    moves: tuple[SurfaceMove, ...]
    map: ChangeMap
    area_both: float  # m2 that both surveys saw
    area_first: float  # m2
    area_second: float  # m2
    detectable_m: float  # median of the smallest change that would have been found
    places: int  # number of places that were tested

    def changed(self) -> tuple[ObjectChange, ...]:
        """List the objects that are new, gone, grown or shrunk."""
        return tuple(found for found in self.objects if found.status in CHANGED)
