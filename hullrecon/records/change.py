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
    """What one dive knows of the hull, in its own hull frame M. as_found: support 0 where unseen;
    form_sigma (n,) m: one sigma of each vertex without what the hull pose leaves open; objects: as
    reported.
    """

    name: str
    chart: Chart
    as_found: Surface
    form_sigma: Array
    hull_pose: HullPose
    objects: tuple[ReportedObject, ...]


@dataclass(frozen=True, kw_only=True)
class SurveyOffset:
    """Where the second survey lies in the first one's hull frame: both lie on the CAD model within
    their hull poses' sigmas only.

    first_from_second: a batch of one, near the identity. covariance (6, 6): of (translation,
    rotation about center), m and rad; prior_covariance (6, 6): what both hull poses leave open.
    center (3,) in M. chi_square: of the offset by its prior, 6 degrees of freedom.
    """

    first_from_second: Poses
    covariance: Array
    prior_covariance: Array
    center: Array
    chi_square: float
    p_value: float


@dataclass(frozen=True, kw_only=True)
class ObjectChange:
    """One object of either survey, or a place where the surface changed as an object does.
    first_id, second_id: in the surveys' objects.json. center (3,) in the first survey's M; outline
    (k, 2) along and girth there, m. height_before, height_after: above the hull around it, NaN
    where not seen, with their sigmas, m; change, its sigma, m; p_value: probability that nothing
    changed and any place looks so; area m2 of what changed. sigma (3,) m: of the place, along, in
    girth, along the normal.
    """

    status: Status
    first_id: int | None
    second_id: int | None
    center: Array
    along_girth: Array
    outline: Array
    height_before: float
    height_after: float
    height_before_sigma: float
    height_after_sigma: float
    change: float
    change_sigma: float
    p_value: float
    area: float
    sigma: Array
    address: str = ""


@dataclass(frozen=True, kw_only=True)
class SurfaceMove:
    """A stretch of bare hull whose form is another one: it moved by move m, outward positive, with
    sigma and p_value over all places looked at; outline (k, 2) along and girth, m; area m2.
    """

    along_girth: Array
    outline: Array
    move: float
    move_sigma: float
    p_value: float
    area: float
    address: str = ""


@dataclass(frozen=True, kw_only=True)
class ChangeMap:
    """Cells of the chart (a, g). change: m, second survey's height minus the first's, offset taken
    off; NaN where not both saw the hull; sigma: m; first_seen, second_seen.
    """

    lattice: Lattice
    change: Array
    sigma: Array
    first_seen: Mask
    second_seen: Mask


@dataclass(frozen=True, kw_only=True)
class HullChange:
    """What changed. areas in m2; detectable_m: the median of the smallest change that would have
    been found, m; places: how many were looked at.
    """

    first: str
    second: str
    offset: SurveyOffset
    objects: tuple[ObjectChange, ...]
    moves: tuple[SurfaceMove, ...]
    map: ChangeMap
    area_both: float
    area_first: float
    area_second: float
    detectable_m: float
    places: int

    def changed(self) -> tuple[ObjectChange, ...]:
        """Return the objects that are new, gone, grown or shrunk."""
        return tuple(found for found in self.objects if found.status in CHANGED)
