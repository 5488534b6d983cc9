# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How well images overlapped and fit, what the adjustment found of the sensors, and how long each step took: tables in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.report.content.phrases import count, duration, with_sigma
from hullrecon.report.step_documents import FactorResiduals
from hullrecon.report.survey import Survey

IMAGE_FACTORS = {"stereo": "Features seen by both cameras", "mono": "Features seen by one camera"}


@dataclass(frozen=True, kw_only=True)
class WordTable:
    """A table of texts with headings; the first cell of a row names it."""

    name: str
    caption: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]


def quality_tables(survey: Survey) -> list[WordTable]:
    """Return the tables that have a row: overlap, residuals, calibration, times."""
    tables = (_overlap(survey), _residuals(survey), _calibration(survey), _times(survey))
    return [table for table in tables if table.rows]


def _overlap(survey: Survey) -> WordTable:
    pairs, rows = survey.facts.node_pairs, []
    for name, across in (("Neighbours along the track", False), ("Images of other legs", True)) if pairs is not None else ():
        of_kind = pairs.across == across
        if not of_kind.any():
            continue
        overlap = pairs.overlap[of_kind & pairs.joined]
        overlap = overlap[np.isfinite(overlap)]
        share = "{1:.0f} % ({0:.0f} to {2:.0f} %)".format(*np.percentile(100 * overlap, (5, 50, 95))) if len(overlap) else "–"
        rows.append((name, f"{int(of_kind.sum()):,}", f"{int((of_kind & pairs.joined).sum()):,}", share))
    return WordTable(
        name="overlap",
        caption="Overlap of images: the median of the matched ones, 5th to 95th percentile, from the path that was known by then",
        headings=("Images compared", "Pairs", "Matched", "Overlap"),
        rows=rows,
    )


def _residuals(survey: Survey) -> WordTable:
    rows: list[tuple[str, ...]] = []
    summary = survey.adjusted.summary if survey.adjusted is not None else None
    if summary is not None and summary.sigmas.pixel_px is not None:
        rows += [_residual_row(summary.residuals_after, key, name, summary.sigmas.pixel_px, "px")
                 for key, name in IMAGE_FACTORS.items() if key in summary.residuals_after]  # fmt: skip
    if summary is not None and summary.sigmas.range_m is not None and "range" in summary.residuals_after:
        rows.append(_residual_row(summary.residuals_after, "range", "DVL ranges", 1000 * summary.sigmas.range_m, "mm"))
    return WordTable(
        name="residuals-px",
        caption="Residuals after the adjustment: median-based sigma, root mean square, and how many lie beyond three sigmas",
        headings=("Measured", "Residuals", "Robust sigma", "RMS", "Beyond 3 sigmas"),
        rows=rows,
    )


def _residual_row(
    residuals: Mapping[str, FactorResiduals], key: str, name: str, unit_sigma: float, unit: str
) -> tuple[str, ...]:
    found = residuals[key]
    robust = "–" if found.robust_sigma is None else f"{unit_sigma * found.robust_sigma:.2g} {unit}"
    beyond = "–" if found.share_beyond_3 is None else f"{100 * found.share_beyond_3:.1f} %"
    return name, f"{int(found.count):,}", robust, f"{unit_sigma * found.rms:.2g} {unit}", beyond


def _calibration(survey: Survey) -> WordTable:
    facts, rows = survey.facts, []
    errors = survey.adjusted.summary.navigation if survey.adjusted is not None else None
    if errors is not None:
        if facts.dvl is not None:
            rows.append(("Scale of the DVL's velocities", f"{100 * errors.dvl_scale:+.2f} %"))
        if facts.has_attitude:
            drift = math.degrees(errors.heading_drift_rad_s) * 3600
            roll, pitch = (math.degrees(v) for v in (errors.roll_bias_rad, errors.pitch_bias_rad))
            rows += [
                ("Drift of the heading", f"{drift:+.2f}° per hour"),
                ("Bias of roll, pitch", f"{roll:+.2f}°, {pitch:+.2f}°"),
            ]
        if facts.has_depth:
            rows.append(("Bias of the depth", f"{1000 * errors.depth_bias_m:+.0f} mm"))
        if errors.tray_play_rad:
            rows.append(("Play of the tray", f"{math.degrees(errors.tray_play_rad):.2f}°"))
    for camera, parameters in survey.adjusted.summary.intrinsics.items() if survey.adjusted is not None else ():
        rows += [
            (f"Camera {camera}, {name}", f"{with_sigma(p.found, p.sigma, '').strip()} (calibrated {p.calibrated:.6g})")
            for name, p in parameters.items()
        ]
    return WordTable(
        name="calibration",
        caption="Errors of the sensors as the adjustment estimated and took them out; without ± the sigma is not known",
        headings=("Sensor", "Estimate"),
        rows=rows,
    )


def _times(survey: Survey) -> WordTable:
    rows, total = [], 0.0
    for step in survey.provenance.steps:
        seconds, memory = step.run.get("seconds"), step.run.get("peak_rss_bytes")
        if isinstance(seconds, int | float):
            total += float(seconds)
            held = f"{memory / 1e6:,.0f} MB" if isinstance(memory, int | float) else "–"
            rows.append((step.name, duration(float(seconds)), held))
    caption = f"Time and memory by step: {duration(total)} for {count(len(rows), 'step')}, this report's own not counted"
    return WordTable(name="times", caption=caption, headings=("Step", "Time", "Most memory held"), rows=rows)
