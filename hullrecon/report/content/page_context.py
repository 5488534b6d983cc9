# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the page's template is given: every number already a text, every picture already a data URI."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

import numpy as np

from hullrecon.geometry.charts.axis_chart import AxisChart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.deliverables import Coverage, CoverageHole, RegionShare, ReportedObject
from hullrecon.report.content.deviation import deviation_figures, deviation_rows
from hullrecon.report.content.frame_words import frame_in_words, origin_in_words
from hullrecon.report.content.headline import (
    headline,
    key_figures,
    seen_words,
    verdict,
    weak_sentences,
)
from hullrecon.report.content.object_card import card_context, object_rows
from hullrecon.report.content.object_images import Crop, jpeg_uri
from hullrecon.report.content.page_data import image_id, image_uri, page_data, script_json
from hullrecon.report.content.phrases import area_words, count, length, with_sigma
from hullrecon.report.content.quality import quality_tables
from hullrecon.report.content.rejected import rejected_groups, settings_rows
from hullrecon.report.figures.chart_map import form_png, ground_png
from hullrecon.report.figures.plan_view import Mark, Plan, SigmaEllipse, plan_svg
from hullrecon.report.figures.ship_view import ship_svg
from hullrecon.report.figures.style import Plot
from hullrecon.report.figures.survey_map import (
    ChartView,
    chart_view,
    object_ellipses,
    survey_layers,
)
from hullrecon.report.scene.scene_data import BLOCK, make_scene
from hullrecon.report.survey import Mosaic, Survey
from hullrecon.typing import Array, Pixels
from hullrecon.version import version

PageContext = Mapping[str, object]
SECTIONS = (
    ("plan", "Map of the hull"),
    ("view", "The hull in 3-D"),
    ("objects", "Objects on the hull"),
    ("change", "Change"),
    ("deviation", "Deviation from the CAD model"),
    ("mosaics", "Mosaics"),
    ("coverage", "Coverage"),
    ("position", "Position uncertainty"),
    ("quality", "Quality of the data"),
    ("rejected", "Rejected data and warnings"),
    ("record", "Record"),
    ("appendix", "Appendix: plots"),
)


def page_context(
    survey: Survey,
    plots: Sequence[Plot],
    deliverables: Mapping[str, object],
    photos: Mapping[int, Crop],
) -> PageContext:
    """Return the template's variables; deliverables: entries with bytes and sha256 by name; photos:
    of the objects.
    """
    view = chart_view(survey)
    layers = survey_layers(survey, view) if view else []
    ellipses = object_ellipses(survey.findings.objects or (), view.chart) if view else []
    dive = survey.facts.dive
    coverage = survey.findings.coverage
    figures = deviation_figures(survey)
    scene = make_scene(survey, view)
    data = {**page_data(survey, view, layers, ellipses), "scene": scene and scene.document}
    quality, mosaics = quality_tables(survey), survey.mosaics.named()
    has = {
        "deviation": survey.is_in_hull_frame,
        "view": data["scene"],
        "mosaics": mosaics,
        "coverage": coverage_rows(coverage),
        "change": survey.change,
        "appendix": plots,
        "plan": view is not None,
        "objects": survey.findings.objects is not None,
        "quality": quality,
    }
    absent = {name for name, there in has.items() if not there}
    sections = [
        (name, title + _since(survey) * (name == "change"))
        for name, title in SECTIONS
        if name not in absent
    ]
    return {
        "sections": sections,
        "number": {name: k for k, (name, _) in enumerate(sections, start=1)},
        "frame_words": frame_in_words(survey),
        "on_ship": survey.is_in_hull_frame,
        "origin_words": origin_in_words(survey),
        "deviation_rows": deviation_rows(figures),
        "offset_words": figures.offset_words if figures is not None else "",
        "position": describe_position(survey),
        "survey": survey,
        "title": f"Hull survey: {dive.name}",
        "about": survey.facts.about,
        "logo": png_uri(survey.facts.about.logo) if survey.facts.about.logo else None,
        "ship": draw_ship(survey),
        "verdict": verdict(survey),
        "figures": key_figures(survey),
        "quality": {table.name: table for table in quality},
        "layers": [(image_id(layer), image_uri(layer)) for layer in layers]
        + ([(BLOCK, scene.block)] if scene else []),
        "table": object_rows(survey),
        "address_of": {o.id: o.address for o in survey.findings.objects or ()},
        "date": _date_words(dive.date) if dive.date is not None else "",
        "lines": headline(survey),
        "weak": weak_sentences(survey),
        "plan": draw_plan(survey, view) if view else None,
        "deviation_map": deviation_map(survey, view) if view else None,
        "mosaics": [mosaic_context(name, m) for name, m in mosaics.items()],
        "cards": [card_context(o, survey, photos.get(o.id)) for o in survey.findings.objects or ()],
        "gaps": any(m.facts.gap_area_m2 > 0 for m in mosaics.values()),
        **_coverage_context(survey),
        **_change_context(survey),
        "plots": {
            p.name: {
                "title": p.title,
                "alt": p.alt,
                "src": png_uri(p.png),
                "csv": f"plots/{p.name}.csv",
            }
            for p in plots
        },
        "rejected": rejected_groups(survey),
        "settings": settings_rows(survey.provenance.steps),
        "steps": survey.provenance.steps,
        "missing": survey.provenance.missing,
        "deliverables": deliverables,
        "data": script_json(data),
        "has_scene": data["scene"] is not None,
        "version": version(),
    }


def _date_words(date: datetime) -> str:
    """Return a date in UTC; one that names no zone as it stands."""
    in_utc = date if date.tzinfo is None else date.astimezone(UTC)
    return f"{in_utc:%d %B %Y, %H:%M}{'' if date.tzinfo is None else ' UTC'}"


def _change_context(survey: Survey) -> PageContext:
    """Return the template's variables of what changed since an earlier dive; None where it was not
    compared with one.
    """
    found = survey.change
    return {"change": found and found.chapter, "change_map": found and png_uri(found.map)}


def _since(survey: Survey) -> str:
    """Return from which dive change is counted, the end of a section's title."""
    return f" since {survey.change.chapter.first}" if survey.change is not None else ""


def _coverage_context(survey: Survey) -> PageContext:
    """Return the template's variables of what was seen of the hull."""
    coverage = survey.findings.coverage
    return {
        "by_images": survey.surfaces.found_by_images,
        "coverage": coverage_rows(coverage, seen_words(survey)),
        "regions": region_rows(coverage),
        "min_hole": f"{coverage.min_hole_m2:g} m²" if coverage is not None else "",
        "holes": [hole_text(hole) for hole in coverage.holes] if coverage is not None else [],
    }


def draw_ship(survey: Survey) -> tuple[str, str] | None:
    """Return the ship with the surveyed patch on it as SVG, and which side it shows; None without a
    CAD model or where nothing of it was seen.
    """
    chart, surface = survey.surfaces.chart, survey.surfaces.as_found or survey.surfaces.surveyed
    if not isinstance(chart, AxisChart) or surface is None or not survey.is_in_hull_frame:
        return None
    seen = surface.faces[(surface.support[surface.faces] > 0).all(axis=1)]
    return ship_svg(chart.mesh, Mesh(surface.vertices @ chart.axes.T, seen)) if len(seen) else None


def png_uri(png: bytes) -> str:
    """Return a PNG as a data URI."""
    return "data:image/png;base64," + b64encode(png).decode()


def draw_plan(survey: Survey, view: ChartView) -> str:
    """Return the plan of the dive as SVG."""
    ellipses = object_ellipses(survey.findings.objects or (), view.chart)
    marks = [
        mark_of(o, at, e)
        for o, at, e in zip(survey.findings.objects or (), view.objects, ellipses, strict=True)
    ]
    chart = "the hull's chart" if survey.is_in_hull_frame else "the survey's own plane"
    across = "girth" if survey.is_in_hull_frame else "across"
    title = (
        f"Plan of the dive on {chart}, {view.extent.size[0]:.1f} m along by {view.extent.size[1]:.1f} m {across}: "
        f"path of the vehicle, hull seen, {count(len(marks), 'object')}."
    )
    plan = Plan(
        extent=view.extent,
        path=view.path,
        path_sigma=survey.track.sigma_on_chart(view.chart),
        marks=marks,
        ground=ground_png(view.found, view.extent) if view.found is not None else None,
        across=across,
        frame_spacing_m=survey.facts.hull.frame_spacing
        if survey.facts.hull and survey.is_in_hull_frame
        else None,
    )
    return plan_svg(plan, title)


def mark_of(found: ReportedObject, at: Array, ellipse: SigmaEllipse | None) -> Mark:
    """Return an object as a mark on the plan, at (along, girth)."""
    text = f"Object {found.id}: height {with_sigma(found.height, found.height_sigma, 'm')}, {found.address}"
    return Mark(
        label=str(found.id), along=float(at[0]), girth=float(at[1]), text=text, ellipse=ellipse
    )


def deviation_map(survey: Survey, view: ChartView) -> str | None:
    """Return the map of the deviation's form as a data URI; None without a CAD model or a hull as
    found.
    """
    split = survey.surfaces.deviation
    if (
        split is None
        or not survey.is_in_hull_frame
        or view.found is None
        or not np.isfinite(split.form).any()
    ):
        return None
    objects = survey.findings.objects or ()
    marks = [
        (str(o.id), float(a[0]), float(a[1])) for o, a in zip(objects, view.objects, strict=True)
    ]
    return png_uri(form_png(view.found, split, view.extent, marks))


def describe_position(survey: Survey) -> str:
    """Return how well the survey as a whole lies on its chart, in a sentence; nothing where that is
    not known.
    """
    chart = survey.surfaces.chart
    along, girth = survey.track.sigma_on_chart(chart) if chart is not None else (np.nan, np.nan)
    if not np.isfinite(along + girth):
        return ""
    ways = (
        ("along the hull", "in girth")
        if survey.is_in_hull_frame
        else ("along the plane", "across it")
    )
    return f"Its position as a whole is known to {length(along)} {ways[0]} and {length(girth)} {ways[1]} (one sigma, median)."


def mosaic_context(name: str, mosaic: Mosaic) -> PageContext:
    """Return the preview, at most 1800 pixels wide and 3600 tall, as JPEG, with mosaic.json's words."""
    import cv2

    picture: Pixels = np.asarray(
        cv2.imdecode(np.frombuffer(mosaic.preview, np.uint8), cv2.IMREAD_COLOR_RGB), np.uint8
    )
    shrink = max(picture.shape[1] / 1800, picture.shape[0] / 3600)
    if shrink > 1:
        factor = 1 / shrink
        picture = np.asarray(
            cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA), np.uint8
        )
    src = jpeg_uri(picture, 0, 86)
    return {
        "name": name.title(),
        "src": src,
        "caption": mosaic.facts.caption,
        "stem": name,
        "has_mesh": mosaic.has_mesh,
    }


def coverage_rows(coverage: Coverage | None, what: str = "Hull seen") -> list[tuple[str, str]]:
    """Return areas and percentiles of coverage.json, in words; what: of what areas are counted."""
    rows: list[tuple[str, str]] = []
    if coverage is None:
        return rows
    for name, seen in (
        ("camera", coverage.camera),
        ("sonar", coverage.sonar),
        ("DVL", coverage.dvl),
    ):
        if seen is None:
            continue
        areas = (
            ("by", seen.area_m2, seen.area_sigma_m2),
            ("at least twice by", seen.area_twice_m2, None),
        )
        rows += [
            (f"{what} {text} {name}", area_words(area, sigma))
            for text, area, sigma in areas
            if area is not None
        ]
        spreads = (
            ("Ground sample distance", seen.gsd_m, 1000.0, " mm"),
            ("Incidence angle of the best view", seen.incidence_deg, 1.0, "°"),
            ("Views per point", seen.views, 1.0, ""),
        )
        rows += [
            (f"{text}, {name}", percentile_text(p, factor, unit))
            for text, p, factor, unit in spreads
            if p
        ]
    return rows


def region_rows(coverage: Coverage | None) -> list[tuple[str, ...]]:
    """Return a row of words for each region: name, limits, hull in it, and what camera, sonar and
    DVL saw of it.
    """

    def limits(pair: tuple[float, float] | None) -> str:
        return "whole" if pair is None else f"{pair[0]:g} to {pair[1]:g} m"

    def seen(share: RegionShare | None) -> str:
        if share is None:
            return "not carried"
        percent = f"{100 * share.share:.0f} ± {max(100 * share.share_sigma, 1):.0f} %"
        return f"{area_words(share.area_m2, share.area_sigma_m2)} ({percent})"

    return [
        (
            r.name,
            limits(r.along),
            limits(r.girth),
            f"{r.area_m2:.1f} m²",
            seen(r.camera),
            seen(r.sonar),
            seen(r.dvl),
        )
        for r in (coverage.regions if coverage is not None else ())
    ]


def percentile_text(percentiles: Mapping[str, float], factor: float, unit: str) -> str:
    """Return `2 mm (5th to 95th percentile 1.8 to 2.4 mm)` of members p05, p50, p95; those that are
    missing are left out.
    """
    low, middle, high = (percentiles.get(name) for name in ("p05", "p50", "p95"))
    spread = (
        ""
        if low is None or high is None
        else f"5th to 95th percentile {factor * low:.3g} to {factor * high:.3g}{unit}"
    )
    if middle is None:
        return spread
    return f"{factor * middle:.3g}{unit}" + (f" ({spread})" if spread else "")


def hole_text(hole: CoverageHole) -> str:
    """Return a hole in the coverage in words."""
    return f"{hole.address or 'at a point without an address'}, {hole.area_m2:.2f} m²"
