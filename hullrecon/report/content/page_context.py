# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the page's template is given: numbers as texts, pictures as data URIs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from hullrecon.geometry.charts.axis_chart import AxisChart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.deliverables import Coverage, CoverageHole, RegionShare
from hullrecon.report.content.deviation import deviation_figures, deviation_rows
from hullrecon.report.content.headline import (
    headline,
    key_figures,
    seen_words,
    verdict,
    weak_sentences,
)
from hullrecon.report.content.objects import Crop, card_context, jpeg_uri, object_rows
from hullrecon.report.content.page_data import image_id, page_data, script_json
from hullrecon.report.content.phrases import area_words, length
from hullrecon.report.content.quality import quality_tables
from hullrecon.report.content.rejected import rejected_groups, settings_rows
from hullrecon.report.figures.hull_map import HullMap
from hullrecon.report.figures.map_pictures import survey_layers
from hullrecon.report.figures.map_tiles import index_tiles
from hullrecon.report.figures.plan_view import survey_plan
from hullrecon.report.figures.ship_view import ship_svg
from hullrecon.report.figures.style import Plot, picture_uri
from hullrecon.report.scene_view import BLOCK, make_scene
from hullrecon.report.survey import Mosaic, Survey
from hullrecon.typing import Pixels
from hullrecon.version import version

PageContext = Mapping[str, Any]
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


def print_context(
    survey: Survey,
    view: HullMap | None,
    plots: Sequence[Plot],
    form: bytes | None,
    deliverables: Mapping[str, object],
    photos: Mapping[int, Crop],
) -> PageContext:
    """Build the variables that page and PDF share.

    Parameters
    ----------
    survey
        All that the steps found.
    view
        The map of the hull.
    plots
        Plots of the appendix.
    form
        The map of the deviation's form, PNG.
    deliverables
        Files written so far, by name.
    photos
        Pictures of objects by the object's number.
    """
    quality, mosaics = quality_tables(survey), survey.mosaics.named()
    sections = _sections(
        survey,
        {
            "deviation": survey.is_in_hull_frame,
            "mosaics": mosaics,
            "coverage": coverage_rows(survey.findings.coverage),
            "change": survey.change,
            "appendix": plots,
            "plan": view is not None,
            "objects": survey.findings.objects is not None,
            "quality": quality,
        },
    )
    return {
        "sections": sections,
        "survey": survey,
        "plan": survey_plan(survey, view) if view else None,
        **_title_context(survey),
        **_frame_context(survey),
        **_objects_context(survey, photos),
        **_change_context(survey),
        **_deviation_context(survey),
        "deviation_map": picture_uri(form) if form is not None else None,
        "mosaics": [mosaic_context(name, m) for name, m in mosaics.items()],
        "gaps": any(m.facts.gap_area_m2 > 0 for m in mosaics.values()),
        **_coverage_context(survey),
        "quality": {table.name: table for table in quality},
        "rejected": rejected_groups(survey),
        "suspects": survey.adjusted.summary.suspects if survey.adjusted is not None else (),
        **_record_context(survey, deliverables),
        "plots": {p.name: _plot_context(p) for p in plots},
    }


def draw_page(
    survey: Survey, view: HullMap | None, deliverables: Mapping[str, object]
) -> PageContext:
    """Draw what only the page shows: the layers of its map, and the hull in 3-D.

    Most of it releases the interpreter's lock, so that another thread can work meanwhile. view: the
    map of the hull. deliverables: files written so far, of which the tiles of mosaics are shown.
    """
    tiles = index_tiles(survey, deliverables)
    layers = survey_layers(survey, view, tiles) if view else []
    scene = make_scene(survey, view)
    data = {**page_data(survey, view, layers, tiles), "scene": scene and scene.document}
    return {
        "data": script_json(data),
        "has_scene": scene is not None,
        "layers": [(image_id(layer), picture_uri(layer.webp, "webp")) for layer in layers]
        + ([(BLOCK, scene.block)] if scene else []),
    }


def join_drawings(printed: PageContext, drawn: PageContext) -> PageContext:
    """Join the variables that page and PDF share with the drawings of the page.

    Without a 3-D scene the section "view" is left out, and those behind it are numbered anew.
    """
    sections = [
        section for section in printed["sections"] if section[0] != "view" or drawn["has_scene"]
    ]
    number = {name: k for k, (name, _) in enumerate(sections, start=1)}
    return {**printed, **drawn, "sections": sections, "number": number}


def _sections(survey: Survey, contents: Mapping[str, object]) -> list[tuple[str, str]]:
    """List name and title of the sections of the page, without those whose contents are empty."""
    since = f" since {survey.change.chapter.first}" if survey.change is not None else ""
    return [
        (name, title + since * (name == "change"))
        for name, title in SECTIONS
        if contents.get(name, True)
    ]


def _title_context(survey: Survey) -> PageContext:
    """Build the variables of the page's head: dive, ship, verdict, figures and main findings."""
    facts, dive = survey.facts, survey.facts.dive
    return {
        "title": f"Hull survey: {dive.name}",
        "about": facts.about,
        "logo": picture_uri(facts.logo) if facts.logo else None,
        "date": _date_words(dive.date) if dive.date is not None else "",
        "ship": draw_ship(survey),
        "verdict": verdict(survey),
        "figures": key_figures(survey),
        "lines": headline(survey),
        "weak": weak_sentences(survey),
    }


def _frame_context(survey: Survey) -> PageContext:
    """Build the variables that say in which frame positions are, and how well they are known."""
    return {
        "frame_words": survey.frame_in_words,
        "on_ship": survey.is_in_hull_frame,
        "origin_words": survey.origin_in_words,
        "position": position_sentence(survey),
    }


def _objects_context(survey: Survey, photos: Mapping[int, Crop]) -> PageContext:
    """Build the variables of the chapter on objects. photos: by the object's number."""
    objects = survey.findings.objects or ()
    return {
        "table": object_rows(survey),
        "address_of": {o.id: o.address for o in objects},
        "cards": [card_context(o, survey, photos.get(o.id)) for o in objects],
    }


def _deviation_context(survey: Survey) -> PageContext:
    """Build the variables of the chapter on deviation but for its map."""
    figures = deviation_figures(survey)
    return {
        "deviation_rows": deviation_rows(figures),
        "offset_words": figures.offset_words if figures is not None else "",
    }


def _record_context(survey: Survey, deliverables: Mapping[str, object]) -> PageContext:
    """Build the variables of the chapter on the record: settings, steps, files and version."""
    return {
        "settings": settings_rows(survey.provenance.steps),
        "steps": survey.provenance.steps,
        "missing": survey.provenance.missing,
        "deliverables": deliverables,
        "failed": {},
        "version": version(),
    }


def _plot_context(plot: Plot) -> PageContext:
    """Build the variables of a plot in the appendix."""
    return {
        "title": plot.title,
        "alt": plot.alt,
        "src": picture_uri(plot.png),
        "csv": f"plots/{plot.name}.csv",
    }


def _date_words(date: datetime) -> str:
    """Write a date in UTC. A date without a time zone is written as it is."""
    in_utc = date if date.tzinfo is None else date.astimezone(UTC)
    return f"{in_utc:%d %B %Y, %H:%M}{'' if date.tzinfo is None else ' UTC'}"


def _change_context(survey: Survey) -> PageContext:
    """Build the variables of the chapter on change, None without an earlier dive."""
    found = survey.change
    return {"change": found and found.chapter, "change_map": found and picture_uri(found.map)}


def _coverage_context(survey: Survey) -> PageContext:
    """Build the variables of the chapter on coverage."""
    coverage = survey.findings.coverage
    return {
        "by_images": survey.surfaces.found_by_images,
        "coverage": coverage_rows(coverage, seen_words(survey)),
        "regions": region_rows(coverage),
        "min_hole": f"{coverage.min_hole_m2:g} m²" if coverage is not None else "",
        "min_bay": f"{coverage.min_bay_m:g} m" if coverage is not None else "",
        "holes": [hole_text(hole) for hole in coverage.holes] if coverage is not None else [],
    }


def draw_ship(survey: Survey) -> tuple[str, str] | None:
    """Draw the ship with the surveyed patch on it, and name the side that it shows.

    None without a CAD model, or if nothing of the hull was seen.
    """
    chart, surface = survey.surfaces.chart, survey.surfaces.as_found or survey.surfaces.surveyed
    if not isinstance(chart, AxisChart) or surface is None or not survey.is_in_hull_frame:
        return None
    seen = surface.faces[(surface.support[surface.faces] > 0).all(axis=1)]
    return ship_svg(chart.mesh, Mesh(surface.vertices @ chart.axes.T, seen)) if len(seen) else None


def position_sentence(survey: Survey) -> str:
    """Say how well the position of the whole survey on its chart is known. Empty if unknown."""
    chart = survey.surfaces.chart
    along, girth = survey.track.sigma_on_chart(chart) if chart is not None else (np.nan, np.nan)
    if not np.isfinite(along + girth):
        return ""
    places = f"{length(along)} along the survey and {length(girth)} across it"
    if survey.is_in_hull_frame:
        places = f"{length(along)} along the hull and {length(girth)} in girth"
    return f"Its position as a whole is known to {places} (one sigma, median)."


def mosaic_context(name: str, mosaic: Mosaic) -> PageContext:
    """Prepare a mosaic's preview, at most 1800 by 3600 pixels (wide, tall), and its caption."""
    import cv2

    encoded = np.frombuffer(mosaic.preview, np.uint8)
    picture: Pixels = np.asarray(cv2.imdecode(encoded, cv2.IMREAD_COLOR_RGB), np.uint8)
    shrink = max(picture.shape[1] / 1800, picture.shape[0] / 3600)
    if shrink > 1:
        factor = 1 / shrink
        picture = np.asarray(
            cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA), np.uint8
        )
    return {
        "name": name.title(),
        "src": jpeg_uri(picture, 0, 86),
        "caption": mosaic.facts.caption,
        "stem": name,
        "has_mesh": mosaic.has_mesh,
    }


def coverage_rows(coverage: Coverage | None, what: str = "Hull seen") -> list[tuple[str, str]]:
    """Tabulate areas and percentiles of coverage.json. `what` names the areas that are counted."""
    rows: list[tuple[str, str]] = []
    if coverage is None:
        return rows
    sensors = {"camera": coverage.camera, "sonar": coverage.sonar, "DVL": coverage.dvl}
    for name, seen in sensors.items():
        if seen is None:
            continue
        if seen.area_m2 is not None:
            rows.append((f"{what} by {name}", area_words(seen.area_m2, seen.area_sigma_m2)))
        if seen.area_twice_m2 is not None:
            rows.append((f"{what} at least twice by {name}", area_words(seen.area_twice_m2)))
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
    """Tabulate regions: name, limits, area, and what camera, sonar and DVL saw of it.

    The regions are those that dive.toml names. Empty without any.
    """

    def limits(pair: tuple[float, float] | None) -> str:
        """Write the limits of a region on one axis, m."""
        return "whole" if pair is None else f"{pair[0]:g} to {pair[1]:g} m"

    def seen(share: RegionShare | None) -> str:
        """Write the area that one sensor saw, and its share of the region."""
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
    """Write percentiles p05, p50, p95 as 2 mm (5th to 95th percentile 1.8 to 2.4 mm).

    factor: from the stored unit to the one that is written.
    """
    low, middle, high = (percentiles.get(name) for name in ("p05", "p50", "p95"))
    spread = ""
    if low is not None and high is not None:
        spread = f"5th to 95th percentile {factor * low:.3g} to {factor * high:.3g}{unit}"
    if middle is None:
        return spread
    return f"{factor * middle:.3g}{unit}" + (f" ({spread})" if spread else "")


def hole_text(hole: CoverageHole) -> str:
    """Describe a hole in the coverage."""
    return f"{hole.address or 'at a point without an address'}, {hole.area_m2:.2f} m²"
