# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The parts of a survey that lie on the hull's chart, as plan, page's map and form map show them.

Positions are chart coordinates (along, girth) in metres. `Extent.outside` converts them to map
coordinates, which rasters, vector layers and the page's script use.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.charts.viewing_side import flips
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.content.deviation import deviation_figures, weighted_percentiles
from hullrecon.report.survey import Survey
from hullrecon.typing import Array, Ints32

Bounds = tuple[float, float, float, float]  # left, bottom, right, top in map coordinates, m


@dataclass(frozen=True, kw_only=True)
class Extent:
    """A rectangle of the chart, and how it is turned in pictures."""

    along: tuple[float, float]  # m, from and to
    girth: tuple[float, float]
    # whether along points left, and girth down, in a picture of the hull seen from outside
    flips: tuple[bool, bool] = (False, False)

    @property
    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Left and right, bottom and top of a picture of the rectangle."""
        along, girth = (
            s[::-1] if f else s for s, f in zip((self.along, self.girth), self.flips, strict=True)
        )
        return (along[0], along[1]), (girth[0], girth[1])

    @property
    def size(self) -> tuple[float, float]:
        """Spans along and in girth, m."""
        return self.along[1] - self.along[0], self.girth[1] - self.girth[0]

    @property
    def outside(self) -> OutsideMap:
        """The map as seen from outside, with x to the right and y upwards."""
        x, y = (-1 if flip else 1 for flip in self.flips)
        return OutsideMap(x_sign=x, y_sign=y, frame="")

    @property
    def bounds(self) -> Bounds:
        """The rectangle in map coordinates."""
        corners = self.outside.to_map(np.array([self.along, self.girth]).T)
        (left, bottom), (right, top) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        return left, bottom, right, top


@dataclass(frozen=True, kw_only=True)
class SigmaEllipse:
    """The one-sigma ellipse of a position on the chart."""

    half_axes: tuple[float, float]  # m, the longer first
    angle_rad: float  # of the longer axis, from along towards girth

    def ring(self) -> Array:
        """Sample the ellipse about the origin as points (41, 2) along and in girth."""
        turn = np.linspace(0, 2 * np.pi, 41)
        along, girth = self.half_axes[0] * np.cos(turn), self.half_axes[1] * np.sin(turn)
        cosine, sine = math.cos(self.angle_rad), math.sin(self.angle_rad)
        return np.stack([cosine * along - sine * girth, sine * along + cosine * girth], axis=1)


@dataclass(frozen=True, kw_only=True)
class ChartedObject:
    """An object with its place on the chart."""

    found: ReportedObject
    at: Array  # (2,) along and in girth, NaN off the chart
    ellipse: SigmaEllipse | None  # of its position, None if that is not known


@dataclass(frozen=True, kw_only=True)
class ChartedSurface:
    """A surface with its vertices on the chart."""

    surface: Surface
    at: Array  # (n, 2)
    faces: Ints32  # without those off the chart or across its seam

    def seen_faces(self) -> Ints32:
        """Select the faces whose three corners were seen."""
        return self.faces[(self.surface.support[self.faces] >= 1).all(axis=1)]


@dataclass(frozen=True, kw_only=True)
class HullMap:
    """What is shown on the chart."""

    chart: Chart
    extent: Extent  # of all that is shown
    path: Array  # (n, 2) of the vehicle, NaN off the chart
    objects: Sequence[ChartedObject]
    found: ChartedSurface | None  # the hull as found, else the surveyed surface


@dataclass(frozen=True, kw_only=True)
class Shading:
    """How values are coloured."""

    colours: str  # matplotlib's name
    low: float  # the value at the lower end of the colours
    high: float
    label: str  # of the legend, with its unit
    extend: str  # which ends include values beyond them: "max" or "both"


@dataclass(frozen=True, kw_only=True)
class MapField:
    """Values at the vertices of the surface, to be shown on the map."""

    name: str
    title: str
    values: Array  # (n,) in the legend's unit
    shading: Shading
    note: str  # sentences that a reader of the map needs


def hull_map(survey: Survey) -> HullMap | None:
    """Project path, objects and surface of a survey onto its chart. None if nothing lies on it."""
    chart, surfaces = survey.surfaces.chart, survey.surfaces
    if chart is None:
        return None
    path = chart.to_chart(survey.track.poses.translation)[:, :2]
    objects = charted_objects(survey.findings.objects or (), chart)
    surface = surfaces.as_found if surfaces.as_found is not None else surfaces.surveyed
    found = project_surface(surface, chart) if surface is not None else None
    seen = found.at[found.surface.support > 0] if found is not None else np.zeros((0, 2))
    corners = np.vstack([path, *(placed.at[None] for placed in objects), seen])
    if not np.isfinite(corners).all(axis=1).any():
        return None
    # As the delivered rasters are turned, else as seen from where the vehicle was
    turned = surfaces.outside.flips if surfaces.outside is not None else flips(chart, path)
    extent = extent_of(corners, turned)
    return HullMap(chart=chart, extent=extent, path=path, objects=objects, found=found)


def charted_objects(objects: Sequence[ReportedObject], chart: Chart) -> list[ChartedObject]:
    """Place objects on the chart, each with the sigma of its own place."""
    if not objects:
        return []
    centers = np.array([found.center for found in objects], float)
    places = chart.to_chart(centers)[:, :2]
    placed = []
    for found, at, axes in zip(
        objects, places, np.stack(tangents_at(chart, centers), axis=1), strict=True
    ):
        covariance = found.position_covariance
        known = covariance is not None and np.isfinite(axes).all()
        ellipse = sigma_ellipse(axes @ np.array(covariance) @ axes.T) if known else None
        placed.append(ChartedObject(found=found, at=at, ellipse=ellipse))
    return placed


def sigma_ellipse(covariance: Array) -> SigmaEllipse:
    """Compute the one-sigma ellipse of a covariance (2, 2), m², of along and girth.

    Its half axes are the longer, then the shorter one. The angle is that of the longer one, from
    along to girth.
    """
    variance, axes = np.linalg.eigh(covariance)
    half = np.sqrt(np.maximum(variance, 0.0))
    return SigmaEllipse(
        half_axes=(float(half[1]), float(half[0])),
        angle_rad=math.atan2(float(axes[1, 1]), float(axes[0, 1])),
    )


def project_surface(surface: Surface, chart: Chart) -> ChartedSurface:
    """Project a surface onto the chart, without faces off the chart or across its seam.

    A face across the seam, where the girth jumps, is much wider on the chart than its edge is long.
    """
    at = chart.to_chart(surface.vertices)[:, :2]
    span = np.ptp(at[surface.faces], axis=1).max(axis=1)
    first, second = surface.vertices[surface.faces[:, 0]], surface.vertices[surface.faces[:, 1]]
    edge = np.linalg.norm(first - second, axis=1)
    kept = np.isfinite(span) & (span < 4 * edge + 0.5)
    return ChartedSurface(surface=surface, at=at, faces=surface.faces[kept])


def extent_of(points: Array, flips: tuple[bool, bool], margin_m: float = 0.4) -> Extent:
    """Bound chart points (n, 2) with a margin. Rows with NaN are left out."""
    good = points[np.isfinite(points).all(axis=1)]
    low, high = (good.min(axis=0) - margin_m).tolist(), (good.max(axis=0) + margin_m).tolist()
    return Extent(along=(low[0], high[0]), girth=(low[1], high[1]), flips=flips)


# Fields of the surface as found


def survey_fields(survey: Survey, found: ChartedSurface) -> list[MapField]:
    """Make the fields of the hull as found: form (else the surface's sigma), then coverage."""
    split = survey.surfaces.deviation
    if split is not None and survey.is_in_hull_frame and form_shadings(found, split) is not None:
        fields = _form_fields(survey, found, split)
    else:
        fields = _sigma_field(found)
    return [*fields, *_coverage_field(found, survey.surfaces.found_by_images)]


def form_shadings(found: ChartedSurface, split: DeviationSplit) -> tuple[Shading, Shading] | None:
    """Choose the colour ranges of form and its sigma (mm). None if nothing was seen.

    The form's range is five times its median magnitude over the seen area, at least 5 mm. Most of
    that area is bare hull, so that structures lie beyond the range. The sigma's range ends at its
    95th percentile, at least at 2 mm.
    """
    weight = np.where(np.isfinite(split.form), vertex_areas(found.surface.mesh()), 0.0)
    if not weight.sum() > 0:
        return None
    form, sigma = 1000 * np.nan_to_num(split.form), 1000 * np.nan_to_num(split.form_sigma)
    top = max(5.0, 5 * float(weighted_percentiles(np.abs(form), weight, (50,))[0]))
    most = max(2.0, float(weighted_percentiles(sigma, weight, (95,))[0]))
    label = "one sigma of the form (mm)"
    return (
        Shading(colours="RdBu_r", low=-top, high=top, label="form (mm)", extend="both"),
        Shading(colours="viridis", low=0, high=most, label=label, extend="max"),
    )


def _form_fields(survey: Survey, found: ChartedSurface, split: DeviationSplit) -> list[MapField]:
    """Make the fields of the form and its sigma, in mm."""
    shadings, figures = form_shadings(found, split), deviation_figures(survey)
    assert shadings is not None
    note = "Red is outside the CAD model, blue inside; offset and tilt of the patch are taken out."
    if figures is not None:
        note += f" Not shown: as a whole the patch lies {figures.offset_words}."
    return [
        MapField(
            name="form",
            title="Form off the CAD model",
            values=1000 * split.form,
            shading=shadings[0],
            note=note,
        ),
        MapField(
            name="form_sigma",
            title="Sigma of the form",
            values=1000 * split.form_sigma,
            shading=shadings[1],
            note="One standard deviation.",
        ),
    ]


def _sigma_field(found: ChartedSurface) -> list[MapField]:
    """Make the field of the surface's sigma, in mm. Empty if nothing was seen."""
    surface, values = found.surface, 1000 * found.surface.sigma
    known = (surface.support > 0) & np.isfinite(values)
    weight = np.where(known, vertex_areas(surface.mesh()), 0.0)
    if not weight.sum() > 0:
        return []
    most = max(1.0, float(weighted_percentiles(np.nan_to_num(values), weight, (95,))[0]))
    label = "one sigma of the surface (mm)"
    field = MapField(
        name="sigma",
        title="Sigma of the surface",
        values=values,
        shading=Shading(colours="viridis", low=0, high=most, label=label, extend="max"),
        note="One standard deviation of the surface along its normal.",
    )
    return [field]


def _coverage_field(found: ChartedSurface, by_images: bool) -> list[MapField]:
    """Make the field of how many images, or DVL returns, saw each vertex. Empty if none did."""
    support = found.surface.support.astype(float)
    if not (support > 0).any():
        return []
    most = max(4.0, float(np.percentile(support[support > 0], 95)))
    sensor, label, none = (
        ("cameras", "images that show a place", "no image shows it")
        if by_images
        else ("DVL", "DVL returns within reach", "no return is near")
    )
    field = MapField(
        name="coverage",
        title=f"Coverage by the {sensor}",
        values=support,
        shading=Shading(colours="YlGnBu", low=0, high=most, label=label, extend="max"),
        note=f"Without colour: {none}.",
    )
    return [field]
