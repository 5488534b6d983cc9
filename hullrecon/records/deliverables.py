# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What objects.json and coverage.json say, as records (docs/deliverables.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

Point = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class PositionMembers:
    """Where something lies on the hull and how well that is known: metres in the frame of
    summary.json, along and girth on the hull chart, frame the ship's, depth below the water
    surface.
    """

    position_covariance: tuple[Point, Point, Point] | None = None
    position_sigma: Point | None = None
    sigma_along: float | None = None
    sigma_girth: float | None = None
    sigma_normal: float | None = None
    along: float | None = None
    girth: float | None = None
    side: str | None = None
    frame: float | None = None
    depth: float | None = None
    depth_sigma: float | None = None
    address: str = ""


@dataclass(frozen=True, kw_only=True)
class ReportedObject(PositionMembers):
    """One row of objects.json: metres, square and cubic metres, points in the frame of
    summary.json.
    """

    center: Point
    height: float
    id: int = 0
    normal: Point = (0.0, 0.0, 0.0)
    height_sigma: float | None = None
    deviation: float | None = None
    deviation_sigma: float | None = None
    extent: tuple[float, float] = (0.0, 0.0)
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
    """A region that detect looked at and did not report: centre, height over the hull around it
    (m), and why.
    """

    center: Point
    height: float
    reason: str
    height_sigma: float | None = None


@dataclass(frozen=True, kw_only=True)
class SensorCoverage:
    """What one sensor saw: areas in m2, area_sigma_m2 None where it is not known; percentiles by
    name (p05, p50, p95) of the ground sample distance (m), of the incidence of the best view
    (degrees) and of the views.
    """

    area_m2: float | None = None
    area_sigma_m2: float | None = None
    area_twice_m2: float | None = None
    gsd_m: Mapping[str, float] | None = None
    incidence_deg: Mapping[str, float] | None = None
    views: Mapping[str, float] | None = None


@dataclass(frozen=True, kw_only=True)
class CoverageHole(PositionMembers):
    """A hole in what was seen: its area and a point in its middle."""

    area_m2: float
    center: Point | None = None


@dataclass(frozen=True, kw_only=True)
class RegionShare:
    """What one sensor saw of a region: m2, and the share of the region's hull, each with one sigma."""

    area_m2: float
    area_sigma_m2: float
    share: float
    share_sigma: float


@dataclass(frozen=True, kw_only=True)
class RegionCoverage:
    """A region of dive.toml: its limits in m (None: none), the hull in it in m2, and what each
    sensor saw of it, None for one that was not carried.
    """

    name: str
    along: tuple[float, float] | None
    girth: tuple[float, float] | None
    area_m2: float
    camera: RegionShare | None = None
    sonar: RegionShare | None = None
    dvl: RegionShare | None = None


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """coverage.json; None for a sensor that was not carried. min_hole_m2: smaller holes are not
    listed.
    """

    camera: SensorCoverage | None = None
    sonar: SensorCoverage | None = None
    dvl: SensorCoverage | None = None
    holes: Sequence[CoverageHole] = field(default_factory=tuple)
    min_hole_m2: float = 0.03
    regions: Sequence[RegionCoverage] = field(default_factory=tuple)
