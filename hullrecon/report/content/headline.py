# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The ten lines on top of the page: what was done, what was found, and how certain it is."""

from __future__ import annotations

import msgspec
import numpy as np

from hullrecon.report.content.deviation import deviation_figures
from hullrecon.report.content.phrases import (
    area_words,
    count,
    duration,
    join,
    length,
    lengths,
    signed_range,
    with_sigma,
)
from hullrecon.report.survey import AdjustedDive, DetectSettings, Survey

WEAK_SIGMA_M = 0.05  # sigma above which a position is called uncertain
_AXES = {
    "M": ("along x of the ship", "along y of the ship", "along z of the ship"),
    "g": ("in x of the local frame", "in y of the local frame", "in z of the local frame"),
}


def headline(survey: Survey) -> list[str]:
    """Summarise the dive in at most ten sentences, the most important first.

    Each function below writes one of them, "" where the dive has nothing to say of it.
    """
    lines = (
        _dive_sentence(survey),
        _position(survey),
        _stereo_calibration(survey.adjusted),
        _position_fixes(survey.adjusted),
        *weak_sentences(survey)[:2],
        _objects(survey),
        _change(survey),
        _deviation(survey),
        _coverage(survey),
        _landmarks(survey.adjusted),
        _mosaics(survey),
        _losses(survey),
    )
    return [line for line in lines if line][:10]


def verdict(survey: Survey) -> str:
    """Answer a reader's first question: what is on the hull."""
    if survey.findings.objects is None:
        reason = survey.provenance.missing.get("objects.json", "the step did not run")
        return f"Objects were not looked for: {reason}."
    return _objects(survey)


def key_figures(survey: Survey) -> list[tuple[str, str, str]]:
    """Collect the key figures on top of the page that the dive gives: name, value and remark."""
    found, coverage = survey.findings.objects, survey.findings.coverage
    figures, rows = deviation_figures(survey), list[tuple[str, str, str]]()
    seen = coverage.camera if coverage is not None else None
    if found is not None:
        rows.append(("Objects" if len(found) != 1 else "Object", str(len(found)), "on the hull"))
    if seen is not None and seen.area_m2:
        rows.append((seen_words(survey), f"{seen.area_m2:.1f} m²", "by camera"))
    if survey.surfaces.chart is not None:
        along, girth = survey.track.sigma_on_chart(survey.surfaces.chart)
        if np.isfinite(along + girth):
            across = "in girth" if survey.is_in_hull_frame else "across"
            remark = f"± {length(girth)} {across}, one sigma"
            rows.append(("Vehicle, along the hull", f"± {length(along)}", remark))
    if figures is not None:
        low, _, high = 1000 * figures.form
        form = f"{signed_range(low, high)}\N{NO-BREAK SPACE}mm"
        sigma = f"one sigma {1000 * figures.form_sigma:.1f} mm"
        rows.append(("Form off the CAD model", form, sigma))
    return rows


def path_length_m(survey: Survey) -> float:
    """Measure the length of the vehicle's path, rounded to a millimetre for texts and files."""
    steps = np.diff(survey.track.poses.translation, axis=0)
    return round(float(np.linalg.norm(steps, axis=1).sum()), 3)


def _dive_sentence(survey: Survey) -> str:
    """Name dive and vessel, with the time, the length of the path and the number of images."""
    track, dive = survey.track, survey.facts.dive
    spent = duration(float(track.t_ns[-1] - track.t_ns[0]) * 1e-9)
    images = sum(int(source.index.usable.sum()) for source in survey.facts.images.values())
    cameras = count(len(survey.facts.images), "camera")
    seen = f", {count(images, 'image')} from {cameras}" if images else ", without a camera"
    path = f"{length(path_length_m(survey))} of path, {count(len(track.t_ns), 'pose')}"
    return f"Dive {dive.name} on {dive.vessel or 'the vessel'}: {spent}, {path}{seen}."


def _position(survey: Survey) -> str:
    """Say how positions were found, in which frame they are, and their median sigmas."""
    sigma = lengths(np.median(survey.track.sigma[:, :3], axis=0).tolist())
    known = f"median one sigma in x / y / z: {sigma}."
    if survey.adjusted is None:
        return f"Positions are dead reckoned in a local frame (g); {known}"
    frame = "the ship's frame (M)"
    if not survey.is_in_hull_frame:
        refused = survey.adjusted.cad_model_was_refused
        why = "the CAD model was left out, see warnings" if refused else "there is no CAD model"
        frame = f"a local frame (g), as {why}"
    return f"Positions are adjusted by method {survey.method} and given in {frame}; {known}"


def _stereo_calibration(adjusted: AdjustedDive | None) -> str:
    found = adjusted.summary.stereo_contradiction if adjusted is not None else None
    return (found.sentence or "") if found is not None else ""


def _position_fixes(adjusted: AdjustedDive | None) -> str:
    """Say how many position fixes (USBL, GNSS) bound the drift, and how well they fit the path."""
    found = adjusted.summary.positions if adjusted is not None else None
    if found is None:
        return ""
    outliers = f", {count(found.outliers, 'outlier')} apart" if found.outliers else ""
    return (
        f"{count(found.count, 'position')} from outside (USBL or GPS) over {duration(found.span_s)}"
        f", sigma {length(found.sigma_m)}, bound its drift; they lie {found.rms_sigmas:.1f} sigmas "
        f"(rms{outliers}) from the path."
    )


def weak_sentences(survey: Survey) -> list[str]:
    """Name the directions in which the position is uncertain.

    These are the adjustment's sentences, if it has any, else one for each axis whose median sigma
    exceeds WEAK_SIGMA_M. Empty if there is none.
    """
    directions = survey.adjusted.weak_directions if survey.adjusted is not None else ()
    sentences = [str(w["sentence"]) for w in directions if w.get("sentence")]
    if sentences:
        return sentences
    axes = _AXES[survey.track.frame]
    sigma = np.median(survey.track.sigma[:, :3], axis=0)
    return [
        f"The position {axes[k]} is uncertain by {length(sigma[k])} (one sigma)."
        for k in np.flatnonzero(sigma > WEAK_SIGMA_M)
    ]


def _objects(survey: Survey) -> str:
    """Say how many objects were found, of which kind, and how high the largest is."""
    objects = survey.findings.objects
    if objects is None:
        return ""
    if not objects:
        return " ".join(["No object was found.", *_thresholds(survey), *_regions_examined(survey)])
    recessed = sum(o.height < 0 for o in objects)
    protruding = len(objects) - recessed
    highest = max(objects, key=lambda o: abs(o.height))
    kinds = [count(protruding, "protrusion")] if protruding else []
    kinds += [count(recessed, "recess", "recesses")] if recessed else []
    size = with_sigma(highest.height, highest.height_sigma, "m")
    found = f"{count(len(objects), 'object')} found on the hull ({join(kinds)})"
    return f"{found}; the largest, no. {highest.id}, has a height of {size}."


def _thresholds(survey: Survey) -> list[str]:
    """Say from which thresholds on something counts as an object. Empty without the settings."""
    settings = survey.provenance.settings_of("detect")
    if not settings:
        return []
    options = msgspec.convert(settings, DetectSettings)
    return [
        f"Looked for: what is at least {1000 * options.min_height_m:g} mm high or deep, "
        f"{1e4 * options.min_area_m2:g} cm² large, shown by {count(options.min_views, 'image')}, "
        f"and bare hull with a probability below {options.max_p_value:g}."
    ]


def _regions_examined(survey: Survey) -> list[str]:
    examined = len(survey.findings.not_reported)
    return [f"{count(examined, 'region')} examined and not reported."] if examined else []


def _change(survey: Survey) -> str:
    chapter = survey.change.chapter if survey.change is not None else None
    return f"Change since {chapter.first}: {chapter.outcome}." if chapter is not None else ""


def _deviation(survey: Survey) -> str:
    """Say by how much the surveyed patch departs from the CAD model, in form and as a whole."""
    figures = deviation_figures(survey)
    if figures is None:
        return ""
    return (
        "Within the surveyed patch the hull's form departs from its CAD model by "
        f"{figures.form_words}; as a whole the patch lies {figures.offset_words}."
    )


def seen_words(survey: Survey) -> str:
    """Name the area that the coverage is counted on: the hull, without a CAD model the surface."""
    return "Hull seen" if survey.is_in_hull_frame else "Measured surface seen"


def _coverage(survey: Survey) -> str:
    """Say how much each sensor saw, and how many holes are left."""
    coverage = survey.findings.coverage
    if coverage is None:
        return ""
    sensors = {"camera": coverage.camera, "sonar": coverage.sonar, "DVL": coverage.dvl}
    parts = [
        f"{area_words(seen.area_m2, seen.area_sigma_m2)} by {name}"
        for name, seen in sensors.items()
        if seen is not None and seen.area_m2
    ]
    holes, least = count(len(coverage.holes), "hole"), coverage.min_hole_m2
    gaps = f"; {holes} of more than {least:g} m² in the coverage" if coverage.holes else ""
    return f"{seen_words(survey)}: {join(parts)}{gaps}." if parts else ""


def _landmarks(adjusted: AdjustedDive | None) -> str:
    """Say how many landmarks were measured, and which share lies on the CAD model."""
    if adjusted is None or not len(adjusted.solution.landmarks):
        return ""
    label = adjusted.solution.landmarks.label
    text = f"{count(len(label), 'landmark was', 'landmarks were')} measured in the images"
    share = 100 * float(np.mean(label == 1))
    if adjusted.has_cad_model:
        text += f", {share:.1f} % of them taken to lie on the CAD model's surface"
    return f"{text}."


def _mosaics(survey: Survey) -> str:
    """Name the mosaics with their resolution. "" without any."""
    resolutions = {name: m.facts.resolution_m for name, m in survey.mosaics.named().items()}
    parts = [
        f"{name} at {1000 * step:.1f} mm per pixel" for name, step in resolutions.items() if step
    ]
    return f"Mosaics of the hull: {join(parts)}." if parts else ""


def _losses(survey: Survey) -> str:
    """Say how much data was lost, and how many warnings there are."""
    lost, warnings = survey.facts.log.lost, survey.provenance.warnings()
    if not lost and not warnings:
        return "The log was read completely and no step raised a warning."
    parts = []
    if lost:
        parts.append(count(len(lost), "span of data was lost", "spans of data were lost"))
    if warnings:
        parts.append(count(len(warnings), "warning was raised", "warnings were raised"))
    return f"{join(parts)[0].upper()}{join(parts)[1:]}; see rejected data and warnings."
