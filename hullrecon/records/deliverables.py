# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Members of objects.json and coverage.json, as records (docs/deliverables.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

Point = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class PositionMembers:
    """The place of something on the hull, in the frame of the results, with its sigma."""

    position_covariance: tuple[Point, Point, Point] | None = None
    position_sigma: Point | None = None
    sigma_along: float | None = None
    sigma_girth: float | None = None
    sigma_normal: float | None = None  # along the hull's normal
    along: float | None = None  # on the hull chart, as is girth
    girth: float | None = None
    side: str | None = None
    frame: float | None = None  # the ship's
    depth: float | None = None  # below the water surface
    depth_sigma: float | None = None
    address: str = ""


@dataclass(frozen=True, kw_only=True)
class ReportedObject(PositionMembers):
    """A row of objects.json: m, m2, m3, points in the frame of summary.json."""

    center: Point
    height: float  # over the hull around it, negative for a recess
    id: int = 0
    normal: Point = (0.0, 0.0, 0.0)  # outward
    height_sigma: float | None = None
    deviation: float | None = None  # of its top from the CAD model
    deviation_sigma: float | None = None
    extent: tuple[float, float] = (0.0, 0.0)  # along the hull and in girth
    extent_sigma: tuple[float, float] | None = None
    area: float = 0.0
    area_sigma: float | None = None
    volume: float = 0.0
    volume_sigma: float | None = None
    open_edge: float | None = None
    views: int = 0
    p_value: float | None = None
    images: tuple[str, ...] = ()
    outline: tuple[Point, ...] = ()


@dataclass(frozen=True, kw_only=True)
class RejectedRegion(PositionMembers):
    """A region that detect looked at and did not report."""

    center: Point
    height: float  # m over the hull around it
    reason: str
    height_sigma: float | None = None


@dataclass(frozen=True, kw_only=True)
class SensorCoverage:
    """What one sensor saw. Percentiles by name: p05, p50, p95."""

    area_m2: float | None = None
    area_sigma_m2: float | None = None  # None if unknown
    area_twice_m2: float | None = None  # seen at least twice
    gsd_m: Mapping[str, float] | None = None  # ground sample distance
    incidence_deg: Mapping[str, float] | None = None  # of the best view
    views: Mapping[str, float] | None = None


@dataclass(frozen=True, kw_only=True)
class CoverageHole(PositionMembers):
    """A hole in what was seen."""

    area_m2: float
    center: Point | None = None  # a point in its middle


@dataclass(frozen=True, kw_only=True)
class RegionShare:
    """What one sensor saw of a region."""

    area_m2: float
    area_sigma_m2: float
    share: float  # of the region's hull
    share_sigma: float


@dataclass(frozen=True, kw_only=True)
class RegionCoverage:
    """A region of dive.toml, and what each sensor saw of it."""

    name: str
    along: tuple[float, float] | None  # limits in m, None without limits
    girth: tuple[float, float] | None  # limits in m, None without limits
    area_m2: float  # of the hull in it
    camera: RegionShare | None = None  # None for a sensor that was not carried
    sonar: RegionShare | None = None
    dvl: RegionShare | None = None


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """coverage.json."""

    camera: SensorCoverage | None = None  # None for a sensor that was not carried
    sonar: SensorCoverage | None = None
    dvl: SensorCoverage | None = None
    holes: Sequence[CoverageHole] = field(default_factory=tuple)
    min_hole_m2: float = 0.03  # smaller holes are not listed
    # A bay of the rim is listed if a square with this side fits into it
    min_bay_m: float = 0.2
    regions: Sequence[RegionCoverage] = field(default_factory=tuple)
