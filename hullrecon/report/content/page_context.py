# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the page's template is given: every number already a text, every picture already a data URI."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hullrecon import __version__
from hullrecon.geometry.charts.viewing_side import UP, flips
from hullrecon.report.content.headline import summary_lines, weak_sentences
from hullrecon.report.content.object_images import Crop, best_crop, jpeg_uri
from hullrecon.report.content.phrases import count, length, probability, with_sigma
from hullrecon.report.content.survey import Mosaic, Survey
from hullrecon.report.figures.chart_map import ChartedSurface, Extent, charted, deviation_png, extent_of, ground_png
from hullrecon.report.figures.plan_view import Mark, Plan, nice_below, plan_svg
from hullrecon.report.figures.style import Plot
from hullrecon.typing import Array


@dataclass(frozen=True)
class ChartView:
    """What is drawn on the chart: its extent, the vehicle's path (n, 2), the objects (k, 2) and the surface as found."""

    extent: Extent
    path: Array
    objects: Array
    found: ChartedSurface | None


def page_view(survey: Survey, plots: Sequence[Plot], deliverables: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The template's variables."""
    on_chart = chart_view(survey)
    return {
        "survey": survey,
        "title": f"Hull survey: {survey.dive.name}",
        "date": survey.dive.date.strftime("%d %B %Y, %H:%M UTC") if survey.dive.date else "",
        "lines": summary_lines(survey),
        "weak": weak_sentences(survey),
        "plan": plan_of(survey, on_chart) if on_chart else None,
        "deviation_map": deviation_map(survey, on_chart) if on_chart else None,
        "mosaics": [m for m in (mosaic_view("Optical", survey.optical), mosaic_view("Sonar", survey.sonar)) if m],
        "cards": [card(o, survey) for o in survey.objects or ()],
        "coverage": coverage_rows(survey),
        "holes": [hole_text(h) for h in (survey.coverage or {}).get("holes") or []],
        "plots": {p.name: {"title": p.title, "alt": p.alt, "src": png_uri(p.png), "csv": f"plots/{p.name}.csv"} for p in plots},
        "left_out": left_out(survey),
        "settings": settings_rows(survey),
        "steps": survey.steps,
        "deliverables": deliverables,
        "version": __version__,
    }


def png_uri(png: bytes) -> str:
    return "data:image/png;base64," + b64encode(png).decode()


def chart_view(survey: Survey) -> ChartView | None:
    """None without a chart, or when nothing of the dive lies on it."""
    if survey.chart is None:
        return None
    path = survey.chart.to_chart(survey.track.poses.translation)[:, :2]
    centers = np.array([o["center"] for o in survey.objects or ()], float).reshape(-1, 3)
    objects = survey.chart.to_chart(centers)[:, :2] if len(centers) else np.zeros((0, 2))
    surface = survey.as_found if survey.as_found is not None else survey.surface
    found = charted(surface, survey.chart) if surface is not None else None
    seen = found.at[found.surface.support > 0] if found is not None else np.zeros((0, 2))
    corners = np.vstack([path, objects, seen])
    if not np.isfinite(corners).all(axis=1).any():
        return None
    return ChartView(extent_of(corners, flips(survey.chart, path, UP[survey.track.frame])), path, objects, found)


def plan_of(survey: Survey, view: ChartView) -> str:
    sigma = path_sigma(survey)
    marks = [mark_of(o, at, sigma) for o, at in zip(survey.objects or (), view.objects, strict=True)]
    ground = ground_png(view.found, view.extent) if view.found is not None else None
    spacing = survey.hull.frame_spacing if survey.hull else None
    title = (
        f"Plan of the dive on the hull's chart, {view.extent.size[0]:.1f} m along by {view.extent.size[1]:.1f} m girth: "
        f"path of the vehicle, hull seen, {count(len(marks), 'object')}."
    )
    return plan_svg(Plan(view.extent, view.path, sigma, marks, ground, spacing), title)


def path_sigma(survey: Survey) -> tuple[float, float]:
    """Median one sigma of the vehicle along and in girth, by the chart's tangents below it."""
    chart = survey.chart
    if chart is None:
        return float("nan"), float("nan")
    at = chart.to_chart(survey.track.poses.translation)[:, :2]
    sigma = []
    for step in ((0.05, 0.0), (0.0, 0.05)):
        ahead, behind = chart.from_chart(at + step)[0], chart.from_chart(at - np.array(step))[0]
        tangent = (ahead - behind) / np.linalg.norm(ahead - behind, axis=1, keepdims=True)
        sigma.append(survey.track.sigma_towards(tangent))
    good = np.isfinite(sigma[0]) & np.isfinite(sigma[1])
    return (float(np.median(sigma[0][good])), float(np.median(sigma[1][good]))) if good.any() else (float("nan"), float("nan"))


def mark_of(found: Mapping[str, Any], at: Array, sigma: tuple[float, float]) -> Mark:
    height = with_sigma(found["height"], found.get("height_sigma"), "m")
    words = f"Object {found['id']}: height {height}, {found.get('address', '')}"
    return Mark(str(found["id"]), float(at[0]), float(at[1]), sigma, words)


def deviation_map(survey: Survey, view: ChartView) -> str | None:
    if survey.as_found is None or view.found is None or not np.isfinite(survey.as_found.deviation).any():
        return None
    marks = [(str(o["id"]), float(a[0]), float(a[1])) for o, a in zip(survey.objects or (), view.objects, strict=True)]
    return png_uri(deviation_png(view.found, view.extent, marks))


def mosaic_view(name: str, mosaic: Mosaic | None) -> dict[str, Any] | None:
    """Preview at most 1800 pixels wide, as JPEG, with what mosaic.json says."""
    if mosaic is None:
        return None
    import cv2

    picture = np.asarray(cv2.imdecode(np.frombuffer(mosaic.preview, np.uint8), cv2.IMREAD_COLOR_RGB), np.uint8)
    if picture.shape[1] > 1800:
        factor = 1800 / picture.shape[1]
        picture = np.asarray(cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA), np.uint8)
    src, stem = jpeg_uri(picture, 0, 86), name.lower()
    return {"name": name, "src": src, "document": mosaic.document, "stem": stem, "meshed": mosaic.meshed}


def card(found: Mapping[str, Any], survey: Survey) -> dict[str, Any]:
    """Texts and picture of one object."""
    crop = best_crop(found, survey.track, survey.eyes, survey.tray_origin_m)
    sigma = found.get("height_sigma")
    kind = "Protrusion" if found["height"] >= 0 else "Recess"
    rows = [
        ("Height over the hull around it", with_sigma(found["height"], sigma, "m")),
        ("Extent along the hull's tangents", " × ".join(f"{e:.2f}" for e in found["extent"]) + " m"),
        ("Area, volume", f"{1e4 * found['area']:.0f} cm², {1000 * found['volume']:.2f} l"),
        ("Largest distance to the CAD model", with_sigma(_number(found.get("deviation")), None, "m")),
        ("Centre (x, y, z)", ", ".join(f"{c:.3f}" for c in found["center"]) + f" m in {survey.track.frame}"),
        ("Seen in", count(int(found["views"]), "view")),
        ("p-value (no object there)", probability(found.get("p_value"))),
    ]
    return {
        "id": found["id"],
        "kind": kind,
        "address": found.get("address") or "",
        "rows": rows,
        "crop": crop and crop_view(crop, found),
    }


def _number(value: Any) -> float:
    return float("nan") if value is None else float(value)


def crop_view(crop: Crop, found: Mapping[str, Any]) -> dict[str, Any]:
    seconds, rest = divmod(crop.t_ns, 10**9)
    stamp = str(np.datetime64(seconds, "s")).replace("T", " ")
    bar = nice_below(0.35 * crop.width / crop.pixels_per_m)
    return {
        "crop": crop,
        "points": " ".join(f"{u:.1f},{v:.1f}" for u, v in crop.outline),
        "bar_px": bar * crop.pixels_per_m,
        "bar": length(bar),
        "source": f"{crop.camera}, image {crop.row}, {stamp}.{rest // 10**6:03d} UTC",
        "alt": f"Object {found['id']} in an image of {crop.camera}, its outline drawn.",
    }


def coverage_rows(survey: Survey) -> list[tuple[str, str]]:
    """Areas and percentiles of coverage.json, in words."""
    document = survey.coverage or {}
    rows = []
    for sensor, name in (("camera", "camera"), ("sonar", "sonar"), ("dvl", "DVL")):
        facts = document.get(sensor)
        if not isinstance(facts, Mapping):
            continue
        rows += [(f"Hull {text} {name}", f"{facts[key]:.1f} m²") for key, text in _AREAS if key in facts]
        rows += [
            (f"{text}, {name}", _spread(facts[key], factor, unit)) for key, text, factor, unit in _SPREADS if facts.get(key)
        ]
    return rows


_AREAS = (("area_m2", "seen by"), ("area_twice_m2", "seen at least twice by"))
_SPREADS = (
    ("gsd_m", "Ground sample distance", 1000.0, " mm"),
    ("incidence_deg", "Incidence of the best view", 1.0, "°"),
    ("views", "Views of a place", 1.0, ""),
)


def _spread(percentiles: Mapping[str, float], factor: float, unit: str) -> str:
    """5 %: 1.8 mm, 50 %: 2 mm, 95 %: 2.4 mm."""
    order = sorted(percentiles.items(), key=lambda item: int(item[0][1:]))
    return ", ".join(f"{int(name[1:])} %: {factor * value:.3g}{unit}" for name, value in order)


def hole_text(hole: Mapping[str, Any]) -> str:
    return f"{hole.get('address') or 'a place without an address'}, {float(hole['area_m2']):.2f} m²"


def left_out(survey: Survey) -> list[tuple[str, list[str]]]:
    """What was lost, refused or not delivered, by heading."""
    failed = [f"{why}: {count(int(n), 'pair')}" for why, n in sorted((survey.pairs.get("failed") or {}).items())]
    outages = [f"no DVL from {a:.1f} s to {b:.1f} s of the log" for a, b in survey.navigation.get("outages_s") or []]
    gaps = [f"no attitude from {a:.1f} s to {b:.1f} s of the log" for a, b in survey.navigation.get("attitude_gaps_s") or []]
    groups = [
        ("Deliverables that this dive cannot give", [f"{name}: {why}" for name, why in survey.absent.items()]),
        ("Lost data", [str(x) for x in survey.findings.get("lost") or []]),
        ("The CAD model, as checked", [str(x) for x in survey.findings.get("hull") or []]),
        ("Navigation", [*outages, *gaps, *(str(x) for x in survey.navigation.get("remarks") or [])]),
        ("Image pairs that gave no geometry", failed),
        ("Observations", _observations(survey)),
        ("Places looked at and not reported as objects", [_refused(r) for r in survey.not_reported]),
        ("Warnings of the steps", survey.warnings()),
        ("Remarks on the log", [str(x) for x in survey.findings.get("remarks") or []]),
    ]
    return [(name, items) for name, items in groups if items]


def _observations(survey: Survey) -> list[str]:
    total, out = survey.adjust.get("observations"), survey.adjust.get("observations_left_out")
    if not total or not out:
        return []
    return [f"{out:,} observations in images were left out of the adjustment, {total:,} were used"]


def _refused(region: Mapping[str, Any]) -> str:
    place = ", ".join(f"{c:.2f}" for c in region["center"])
    return f"{region['reason']} (height {region['height']:.3f} m at {place})"


def settings_rows(survey: Survey) -> list[tuple[str, str]]:
    """Every resolved option, once, as section.key and value."""
    rows: dict[str, str] = {}
    for step in survey.steps:
        for section, values in step.settings.items():
            if isinstance(values, Mapping):
                rows.update({f"{section}.{key}": _value(value) for key, value in _flat(values)})
    return sorted(rows.items())


def _flat(values: Mapping[str, Any], above: str = "") -> list[tuple[str, Any]]:
    out: list[tuple[str, Any]] = []
    for key, value in values.items():
        out += _flat(value, f"{above}{key}.") if isinstance(value, Mapping) else [(above + key, value)]
    return out


def _value(value: Any) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else "not set" if value is None else str(value)
