# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The ten lines on top of the page: what was done, what was found, and how sure it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.report.content.phrases import count, duration, join, length, with_sigma
from hullrecon.report.content.survey import Survey
from hullrecon.report.figures.chart_map import weighted_percentiles

_AXES = {
    "M": ("along x of the ship", "along y of the ship", "along z of the ship"),
    "g": ("in x of the level frame", "in y of the level frame", "in depth"),
}


def summary_lines(survey: Survey) -> list[str]:
    """At most ten sentences, the most important first."""
    lines = [_dive(survey), _position(survey), *_weak(survey), _objects(survey), _deviation(survey), _coverage(survey)]
    lines += [_landmarks(survey), _texture(survey), _complaints(survey)]
    return [line for line in lines if line][:10]


def path_length_m(survey: Survey) -> float:
    return float(np.linalg.norm(np.diff(survey.track.poses.translation, axis=0), axis=1).sum())


def _dive(survey: Survey) -> str:
    track = survey.track
    spent = duration(float(track.t_ns[-1] - track.t_ns[0]) * 1e-9)
    vessel = survey.dive.vessel or "the vessel"
    images = sum(int(eye.index.usable.sum()) for eye in survey.eyes)
    eyes = f", {count(images, 'image')} of {count(len(survey.eyes), 'camera')}" if images else ", without a camera"
    path = f"{length(path_length_m(survey))} of path, {count(len(track.t_ns), 'pose')}"
    return f"Dive {survey.dive.name} on {vessel}: {spent}, {path}{eyes}."


def _position(survey: Survey) -> str:
    sigma = np.median(survey.track.sigma[:, :3], axis=0)
    triple = " / ".join(length(s) for s in sigma)
    if survey.solution is None:
        return f"Positions are dead reckoned in a local level frame (g); median one sigma in x / y / z: {triple}."
    frame = "the ship's frame (M)" if survey.track.frame == "M" else "a local level frame (g), for there was no CAD model"
    return (
        f"All positions are adjusted by method {survey.method} and given in {frame}; median one sigma in x / y / z: {triple}."
    )


def weak_directions(survey: Survey) -> list[Mapping[str, Any]]:
    """As adjust.json has them."""
    return list(survey.adjust.get("weak_directions") or [])


def weak_sentences(survey: Survey, least_sigma_m: float = 0.05) -> list[str]:
    """Of the adjustment where it has any; else each axis of the position whose median sigma is beyond the least."""
    said = [str(w["sentence"]) for w in weak_directions(survey) if w.get("sentence")]
    if said:
        return said
    words = _AXES[survey.track.frame]
    sigma = np.median(survey.track.sigma[:, :3], axis=0)
    return [
        f"The position {words[k]} is uncertain by {length(sigma[k])} (one sigma)."
        for k in np.flatnonzero(sigma > least_sigma_m)
    ]


def _weak(survey: Survey) -> list[str]:
    return weak_sentences(survey)[:2]


def _objects(survey: Survey) -> str:
    if survey.objects is None:
        return ""
    if not survey.objects:
        return "No object was found that stands out of, or is let into, the hull beyond its uncertainty."
    raised = [o for o in survey.objects if o["height"] >= 0]
    recessed = len(survey.objects) - len(raised)
    highest = max(survey.objects, key=lambda o: abs(o["height"]))
    kinds = [count(len(raised), "protrusion")] if raised else []
    kinds += [count(recessed, "recess", "recesses")] if recessed else []
    size = with_sigma(highest["height"], highest.get("height_sigma"), "m")
    found = f"{count(len(survey.objects), 'object')} found on the hull ({join(kinds)})"
    return f"{found}; the largest, no. {highest['id']}, has a height of {size}."


def _deviation(survey: Survey) -> str:
    found = survey.as_found
    if found is None:
        return ""
    seen = (found.support > 0) & np.isfinite(found.deviation)
    weight = vertex_areas(found.mesh())[seen]
    if not weight.sum() > 0:
        return ""
    low, middle, high = 1000 * weighted_percentiles(found.deviation[seen], weight, (5, 50, 95))
    side = "outside" if middle > 0 else "inside"
    return (
        f"Where it was seen the hull lies {abs(middle):.0f} mm {side} its CAD model in the median; "
        f"nine tenths of it between {low:+.0f} and {high:+.0f} mm."
    )


def area(coverage: Mapping[str, Any], sensor: str) -> float | None:
    """Square metres seen by "camera", "sonar" or "dvl"; None where that was not carried."""
    facts = coverage.get(sensor)
    return float(facts["area_m2"]) if isinstance(facts, Mapping) and "area_m2" in facts else None


def _coverage(survey: Survey) -> str:
    if survey.coverage is None:
        return ""
    areas = {s: area(survey.coverage, s) for s in ("camera", "sonar", "dvl")}
    names = {"camera": "by camera", "sonar": "by sonar", "dvl": "by DVL"}
    parts = [f"{value:.1f} m² {names[s]}" for s, value in areas.items() if value is not None and value > 0]
    holes = survey.coverage.get("holes") or []
    gaps = f"; {count(len(holes), 'hole')} in the coverage" if holes else ""
    return f"Hull seen: {join(parts)}{gaps}." if parts else ""


def _landmarks(survey: Survey) -> str:
    if survey.solution is None or not len(survey.solution.landmarks):
        return ""
    solution = survey.solution
    on = int((solution.landmarks.label == 1).sum())
    text = f"{count(len(solution.landmarks), 'landmark')} were measured in the images"
    return (
        f"{text}, {100 * on / len(solution.landmarks.label):.1f} % of them on the hull's surface."
        if survey.track.frame == "M"
        else text + "."
    )


def _texture(survey: Survey) -> str:
    made = [(name, m.document) for name, m in (("optical", survey.optical), ("sonar", survey.sonar)) if m is not None]
    parts = [f"{name} at {1000 * d['resolution_m']:.1f} mm a pixel" for name, d in made if d.get("resolution_m")]
    return f"Mosaics of the hull's chart: {join(parts)}." if parts else ""


def _complaints(survey: Survey) -> str:
    lost, warned = list(survey.findings.get("lost") or []), survey.warnings()
    if not lost and not warned:
        return "The log was read whole and no step raised a warning."
    parts = [count(len(lost), "span of data was lost", "spans of data were lost")] if lost else []
    parts += [count(len(warned), "warning was raised", "warnings were raised")] if warned else []
    return f"{join(parts)[0].upper()}{join(parts)[1:]}; section 9 lists what was left out and why."
