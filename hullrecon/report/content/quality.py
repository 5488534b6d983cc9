# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How well images overlapped and fit, what the adjustment found of the sensors, how long each step
took: tables in words.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.records.links import NodePairs
from hullrecon.report.content.phrases import count, duration, error_with_sigma, with_sigma
from hullrecon.report.step_documents import AdjustSummary, FactorResiduals, SensorErrors
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
    pairs = survey.facts.node_pairs
    kinds = (("Neighbours along the track", False), ("Images of other legs", True))
    rows = (
        [_overlap_row(pairs, name, across) for name, across in kinds] if pairs is not None else []
    )
    return WordTable(
        name="overlap",
        caption="Overlap of images: median of the matched ones and 5th to 95th percentile, on the path known by then",
        headings=("Images compared", "Pairs", "Matched", "Overlap"),
        rows=[row for row in rows if row],
    )


def _overlap_row(pairs: NodePairs, name: str, across: bool) -> tuple[str, ...]:
    """Return a row of the pairs across legs, or of the others; empty where there is none."""
    of_kind = pairs.across == across
    matched = of_kind & pairs.joined
    overlap = 100 * pairs.overlap[matched & np.isfinite(pairs.overlap)]
    if not of_kind.any():
        return ()
    share = "–"
    if len(overlap):
        low, middle, high = np.percentile(overlap, (5, 50, 95))
        share = f"{middle:.0f} % ({low:.0f} to {high:.0f} %)"
    return name, f"{int(of_kind.sum()):,}", f"{int(matched.sum()):,}", share


def _residuals(survey: Survey) -> WordTable:
    rows: list[tuple[str, ...]] = []
    summary = survey.adjusted.summary if survey.adjusted is not None else None
    if summary is not None and summary.sigmas.pixel_px is not None:
        rows += [_residual_row(summary.residuals_after[key], name, summary.sigmas.pixel_px, "px")
                 for key, name in IMAGE_FACTORS.items() if key in summary.residuals_after]  # fmt: skip
    if (
        summary is not None
        and summary.sigmas.range_m is not None
        and "range" in summary.residuals_after
    ):
        rows.append(
            _residual_row(
                summary.residuals_after["range"], "DVL ranges", 1000 * summary.sigmas.range_m, "mm"
            )
        )
    if (
        summary is not None
        and summary.positions is not None
        and "position" in summary.residuals_after
    ):
        name = "Positions from outside, north and east"
        rows.append(
            _residual_row(summary.residuals_after["position"], name, summary.positions.sigma_m, "m")
        )
    return WordTable(
        name="residuals-px",
        caption="Residuals after the adjustment: median-based sigma, root mean square, and how many lie beyond three sigmas",
        headings=("Measured", "Residuals", "Robust sigma", "RMS", "Beyond 3 sigmas"),
        rows=rows,
    )


def _residual_row(
    found: FactorResiduals, name: str, unit_sigma: float, unit: str
) -> tuple[str, ...]:
    robust = "–" if found.robust_sigma is None else f"{unit_sigma * found.robust_sigma:.2g} {unit}"
    beyond = "–" if found.share_beyond_3 is None else f"{100 * found.share_beyond_3:.1f} %"
    return name, f"{int(found.count):,}", robust, f"{unit_sigma * found.rms:.2g} {unit}", beyond


def _calibration(survey: Survey) -> WordTable:
    summary = survey.adjusted.summary if survey.adjusted is not None else AdjustSummary()
    rows = (
        []
        if summary.navigation is None
        else _sensor_errors(survey, summary.navigation, summary.navigation_sigma)
    )
    for camera, parameters in summary.intrinsics.items():
        rows += [
            (
                f"Camera {camera}, {name}",
                f"{with_sigma(p.found, p.sigma, '').strip()} (calibrated {p.calibrated:.6g})",
            )
            for name, p in parameters.items()
        ]
    return WordTable(
        name="calibration",
        caption="Errors of the sensors (measured less true) as the adjustment estimated and took them out; without ± the sigma "
        "is not known",
        headings=("Sensor", "Estimate"),
        rows=rows,
    )


def _sensor_errors(
    survey: Survey, found: SensorErrors, sigma: SensorErrors
) -> list[tuple[str, str]]:
    """Return a row for each error of a sensor that was carried. Scale and drift were estimated as
    what corrects the sensor: its error has the other sign. The tray's backlash is left out: its
    sigma does not hold against truth.
    """
    rows = []
    if survey.facts.dvl is not None:
        scale, scale_sigma = -100 * found.dvl_scale, 100 * sigma.dvl_scale
        rows.append(
            ("Scale error of the DVL's velocities", error_with_sigma(scale, scale_sigma, " %"))
        )
    if survey.facts.has_attitude:
        drift, drift_sigma = (
            3600 * math.degrees(v) for v in (-found.heading_drift_rad_s, sigma.heading_drift_rad_s)
        )
        rows += [
            ("Drift of the heading", error_with_sigma(drift, drift_sigma, "° per hour")),
            (
                "Bias of roll",
                error_with_sigma(
                    math.degrees(found.roll_bias_rad), math.degrees(sigma.roll_bias_rad), "°"
                ),
            ),
            (
                "Bias of pitch",
                error_with_sigma(
                    math.degrees(found.pitch_bias_rad), math.degrees(sigma.pitch_bias_rad), "°"
                ),
            ),
        ]
    if survey.facts.has_depth:
        rows.append(
            (
                "Bias of the depth",
                error_with_sigma(1000 * found.depth_bias_m, 1000 * sigma.depth_bias_m, " mm"),
            )
        )
    return rows


def _times(survey: Survey) -> WordTable:
    rows, total = [], 0.0
    for step in survey.provenance.steps:
        seconds, memory = step.run.get("seconds"), step.run.get("peak_rss_bytes")
        if isinstance(seconds, int | float):
            total += float(seconds)
            held = f"{memory / 1e6:,.0f} MB" if isinstance(memory, int | float) else "–"
            rows.append((step.name, duration(float(seconds)), held))
    caption = f"Time and memory by step: {duration(total)} for {count(len(rows), 'step')}, this report's own not counted"
    return WordTable(
        name="times", caption=caption, headings=("Step", "Time", "Most memory held"), rows=rows
    )
