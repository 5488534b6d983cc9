# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What of a survey is shown on the hull's chart: its extent, the vehicle's path, the objects, and
the layers of the map.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.charts.viewing_side import flips
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.content.deviation import deviation_figures
from hullrecon.report.figures.chart_map import (
    ChartedSurface,
    Extent,
    Shading,
    extent_of,
    form_shadings,
    project_surface,
    weighted_percentiles,
)
from hullrecon.report.figures.map_layers import MapLayer, field_layer, mosaic_layer
from hullrecon.report.figures.plan_view import SigmaEllipse, sigma_ellipse
from hullrecon.report.survey import Survey
from hullrecon.typing import Array

MOSAIC_TITLES = {"optical": "Camera mosaic", "sonar": "Sonar mosaic"}
RASTERS = {  # the delivered raster of a layer
    "optical": "ortho_optical.tif",
    "sonar": "ortho_sonar.tif",
    "form": "form.tif",
    "form_sigma": "form_sigma.tif",
    "sigma": "",
    "coverage": "support.tif",
}


@dataclass(frozen=True, kw_only=True)
class ChartView:
    """What is shown on the chart: its extent, the vehicle's path (n, 2), the objects (k, 2) and the
    surface as found.
    """

    chart: Chart
    extent: Extent
    path: Array
    objects: Array
    found: ChartedSurface | None


def chart_view(survey: Survey) -> ChartView | None:
    """Return what is shown on the chart; None without a chart, or when nothing of the dive lies on
    it.
    """
    chart = survey.surfaces.chart
    if chart is None:
        return None
    path = chart.to_chart(survey.track.poses.translation)[:, :2]
    centers = np.array([o.center for o in survey.findings.objects or ()], float).reshape(-1, 3)
    objects = chart.to_chart(centers)[:, :2] if len(centers) else np.zeros((0, 2))
    surface = (
        survey.surfaces.as_found
        if survey.surfaces.as_found is not None
        else survey.surfaces.surveyed
    )
    found = project_surface(surface, chart) if surface is not None else None
    seen = found.at[found.surface.support > 0] if found is not None else np.zeros((0, 2))
    corners = np.vstack([path, objects, seen])
    if not np.isfinite(corners).all(axis=1).any():
        return None
    outside = survey.surfaces.outside
    extent = extent_of(corners, outside.flips if outside is not None else flips(chart, path))
    return ChartView(chart=chart, extent=extent, path=path, objects=objects, found=found)


def object_ellipses(objects: Sequence[ReportedObject], chart: Chart) -> list[SigmaEllipse | None]:
    """Return the one-sigma ellipse of each object's own place on the chart; None where its
    covariance is not known.
    """
    if not objects:
        return []
    tangents = np.stack(tangents_at(chart, np.array([o.center for o in objects], float)), axis=1)
    out: list[SigmaEllipse | None] = []
    for found, axes in zip(objects, tangents, strict=True):
        known = found.position_covariance is not None and np.isfinite(axes).all()
        out.append(
            sigma_ellipse(axes @ np.array(found.position_covariance) @ axes.T) if known else None
        )
    return out


def survey_layers(survey: Survey, view: ChartView) -> list[MapLayer]:
    """Return the layers that this dive gives, the one that is shown first in front: mosaics,
    deviation, sigma, coverage.
    """
    rasters = survey.provenance.copies
    return [
        replace(layer, note=f"{layer.note} {_resolution(layer, rasters.get(RASTERS[layer.name]))}")
        for layer in _layers(survey, view)
    ]


def _resolution(layer: MapLayer, raster: Path | None) -> str:
    """Say at what resolution a layer is shown, and which delivered raster is finer."""
    shown = f"Shown at {_millimetres(layer.step_m)} a pixel"
    if raster is None:
        return f"{shown}."
    import rasterio

    with rasterio.open(raster) as source:
        full_m = float(source.res[0])
    if full_m >= 0.999 * layer.step_m:
        return f"{shown}."
    return f"{shown}; {RASTERS[layer.name]} has {_millimetres(full_m)}."


def _millimetres(step_m: float) -> str:
    return f"{1000 * step_m:.1f} mm" if step_m < 0.01 else f"{1000 * step_m:.0f} mm"


def _layers(survey: Survey, view: ChartView) -> list[MapLayer]:
    mosaics, copies = survey.mosaics.named(), survey.provenance.copies
    layers = [
        mosaic_layer(
            name,
            MOSAIC_TITLES[name],
            copies[f"ortho_{name}.tif"],
            f"{mosaic.facts.caption} Contrast stretched.",
        )
        for name, mosaic in mosaics.items()
        if f"ortho_{name}.tif" in copies
    ]
    if view.found is None or survey.surfaces.as_found is None:
        return layers
    return [
        *layers,
        *_deviation_layers(survey, view, view.found),
        *_coverage_layer(view, view.found, survey.surfaces.found_by_images),
    ]


def _deviation_layers(survey: Survey, view: ChartView, found: ChartedSurface) -> list[MapLayer]:
    """Return form and its sigma; without a CAD model the sigma of the surface."""
    split, figures = survey.surfaces.deviation, deviation_figures(survey)
    shadings = (
        form_shadings(found, split) if split is not None and survey.is_in_hull_frame else None
    )
    if split is not None and shadings is not None:
        apart = (
            f" Not shown: as a whole the patch lies {figures.offset_words}."
            if figures is not None
            else ""
        )
        note = f"Red is outside the CAD model, blue inside; offset and tilt of the patch are taken out.{apart}"
        form, sigma = (
            field_layer(name, title, found, 1000 * values, shading, view.extent, words)
            for name, title, values, shading, words in (
                ("form", "Form off the CAD model", split.form, shadings[0], note),
                (
                    "form_sigma",
                    "Sigma of the form",
                    split.form_sigma,
                    shadings[1],
                    "One standard deviation.",
                ),
            )
        )
        return [form, sigma]
    values = 1000 * found.surface.sigma
    weight = np.where(
        (found.surface.support > 0) & np.isfinite(values), vertex_areas(found.surface.mesh()), 0.0
    )
    if not weight.sum() > 0:
        return []
    most = max(1.0, float(weighted_percentiles(np.nan_to_num(values), weight, (95,))[0]))
    shading = Shading(
        colours="viridis", low=0, high=most, label="one sigma of the surface (mm)", extend="max"
    )
    note = "One standard deviation of the surface along its normal."
    return [field_layer("sigma", "Sigma of the surface", found, values, shading, view.extent, note)]


def _coverage_layer(view: ChartView, found: ChartedSurface, by_images: bool) -> list[MapLayer]:
    support = found.surface.support.astype(float)
    if not (support > 0).any():
        return []
    most = max(4.0, float(np.percentile(support[support > 0], 95)))
    label = "images that show a place" if by_images else "DVL returns within reach"
    title, none = (
        ("Coverage by the cameras", "no image shows it")
        if by_images
        else ("Coverage by the DVL", "no return is near")
    )
    shading = Shading(colours="YlGnBu", low=0, high=most, label=label, extend="max")
    return [
        field_layer(
            "coverage", title, found, support, shading, view.extent, f"Without colour: {none}."
        )
    ]
