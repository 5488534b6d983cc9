# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Quality of the data as tables in words: overlap, residuals, calibration, time of each step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.records.links import NodePairs
from hullrecon.report.content.phrases import count, duration, error_with_sigma, with_sigma
from hullrecon.report.survey import AdjustSummary, FactorResiduals, SensorErrors, Survey


@dataclass(frozen=True, kw_only=True)
class WordTable:
    """A table of texts. The first cell of a row names the row."""

    name: str
    caption: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]


def quality_tables(survey: Survey) -> list[WordTable]:
    """Make the tables of overlap, residuals, calibration and times, without empty ones."""
    tables = (_overlap(survey), _residuals(survey), _calibration(survey), _times(survey))
    return [table for table in tables if table.rows]


def _overlap(survey: Survey) -> WordTable:
    """Tabulate how many pairs of images were compared and matched, and how much they overlap."""
    pairs, rows = survey.facts.node_pairs, list[tuple[str, ...]]()
    if pairs is not None:
        rows.append(_overlap_row(pairs, "Neighbours along the track", across=False))
        rows.append(_overlap_row(pairs, "Images of other legs", across=True))
    return WordTable(
        name="overlap",
        caption="Overlap of images: median of the matched ones and 5th to 95th percentile, "
        "on the path known by then",
        headings=("Images compared", "Pairs", "Matched", "Overlap"),
        rows=[row for row in rows if row],
    )


def _overlap_row(pairs: NodePairs, name: str, across: bool) -> tuple[str, ...]:
    """Summarise the pairs across legs or along the track. Empty if there are none."""
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
    """Tabulate the residuals of features, ranges and positions in their units."""
    summary = survey.adjusted.summary if survey.adjusted is not None else AdjustSummary()
    pixel, metre, positions = summary.sigmas.pixel_px, summary.sigmas.range_m, summary.positions
    kinds = (  # residuals, name, one sigma in the unit
        ("stereo", "Features seen by both cameras", pixel, "px"),
        ("mono", "Features seen by one camera", pixel, "px"),
        ("range", "DVL ranges", None if metre is None else 1000 * metre, "mm"),
        (
            "position",
            "Positions from outside, north and east",
            None if positions is None else positions.sigma_m,
            "m",
        ),
    )
    found = summary.residuals_after
    return WordTable(
        name="residuals-px",
        caption="Residuals after the adjustment: median-based sigma, root mean square, "
        "and how many lie beyond three sigmas",
        headings=("Measured", "Residuals", "Robust sigma", "RMS", "Beyond 3 sigmas"),
        rows=[
            _residual_row(found[key], name, sigma, unit)
            for key, name, sigma, unit in kinds
            if sigma is not None and key in found
        ],
    )


def _residual_row(
    found: FactorResiduals, name: str, unit_sigma: float, unit: str
) -> tuple[str, ...]:
    """Write a row of the residuals. unit_sigma: one sigma in `unit`, by which they are scaled."""
    robust = "–" if found.robust_sigma is None else f"{unit_sigma * found.robust_sigma:.2g} {unit}"
    beyond = "–" if found.share_beyond_3 is None else f"{100 * found.share_beyond_3:.1f} %"
    return name, f"{int(found.count):,}", robust, f"{unit_sigma * found.rms:.2g} {unit}", beyond


def _calibration(survey: Survey) -> WordTable:
    """Tabulate the estimated errors of navigation's sensors and the refined intrinsics."""
    summary = survey.adjusted.summary if survey.adjusted is not None else AdjustSummary()
    rows = list[tuple[str, str]]()
    if summary.navigation is not None:
        rows += _sensor_errors(survey, summary.navigation, summary.navigation_sigma)
    for camera, parameters in summary.intrinsics.items():
        for name, p in parameters.items():
            found = with_sigma(p.found, p.sigma, "").strip()
            rows.append((f"Camera {camera}, {name}", f"{found} (calibrated {p.calibrated:.6g})"))
    return WordTable(
        name="calibration",
        caption="Errors of the sensors (measured less true) as the adjustment estimated and took "
        "them out; without ± the sigma is not known",
        headings=("Sensor", "Estimate"),
        rows=rows,
    )


def _sensor_errors(
    survey: Survey, found: SensorErrors, sigma: SensorErrors
) -> list[tuple[str, str]]:
    """Tabulate the error of each navigation sensor that was carried.

    Scale and drift were estimated as corrections, so the sensor's error has the opposite sign. The
    tray's backlash is left out: in simulation its error exceeds its sigma.
    """
    facts, degree = survey.facts, math.degrees(1.0)
    dvl, attitude, depth = facts.dvl is not None, facts.has_attitude, facts.has_depth
    errors = (  # whether it was carried, name, field, factor from that to the error in its unit
        (dvl, "Scale error of the DVL's velocities", "dvl_scale", -100, " %"),
        (attitude, "Drift of the heading", "heading_drift_rad_s", -3600 * degree, "° per hour"),
        (attitude, "Bias of roll", "roll_bias_rad", degree, "°"),
        (attitude, "Bias of pitch", "pitch_bias_rad", degree, "°"),
        (depth, "Bias of the depth", "depth_bias_m", 1000, " mm"),
    )
    rows = list[tuple[str, str]]()
    for carried, name, field, factor, unit in errors:
        if carried:
            error, one_sigma = (factor * getattr(values, field) for values in (found, sigma))
            rows.append((name, error_with_sigma(error, abs(one_sigma), unit)))
    return rows


def _times(survey: Survey) -> WordTable:
    """Tabulate time and memory of each step."""
    rows, spans = [], []
    for step in survey.provenance.steps:
        begun, seconds = step.run.get("started"), step.run.get("seconds")
        memory = step.run.get("peak_rss_bytes")
        if isinstance(begun, int | float) and isinstance(seconds, int | float):
            spans.append((begun, begun + seconds))
            held = f"{memory / 1e6:,.0f} MB" if isinstance(memory, int | float) else "–"
            rows.append((step.name, duration(float(seconds)), held))
    caption = (
        f"Time and memory by step: {duration(_covered(spans))} for {count(len(rows), 'step')}, "
        "this report's own not counted"
    )
    headings = ("Step", "Time", "Most memory held")
    return WordTable(name="times", caption=caption, headings=headings, rows=rows)


def _covered(spans: Sequence[tuple[float, float]]) -> float:
    """Sum the time that spans cover: that of steps beside each other counts once."""
    total, until = 0.0, 0.0
    for begin, end in sorted(spans):
        total += max(0.0, end - max(begin, until))
        until = max(until, end)
    return total
