# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""All plots that a survey gives, in the order of the page."""

from __future__ import annotations

from hullrecon.report.figures.deviation_histogram import deviation_histogram
from hullrecon.report.figures.plots import (
    convergence,
    depth_and_standoff,
    labels,
    residuals,
    sigmas,
)
from hullrecon.report.figures.style import Plot
from hullrecon.report.survey import Survey


def draw_all_plots(survey: Survey) -> list[Plot]:
    """Draw the plots whose numbers are there."""
    has_depth = survey.facts.has_depth
    depth = depth_and_standoff(
        survey.track.t_ns,
        survey.trajectory.translation[:, 2] if has_depth else None,
        survey.facts.dvl,
    )
    found = [sigmas(survey.track)] if depth is None else [depth, sigmas(survey.track)]
    adjusted = survey.adjusted
    if adjusted is not None:
        iterations, summary = adjusted.iterations, adjusted.summary
        if len(iterations.get("cost", ())):
            found.append(convergence(iterations))
            if {"on_surface", "label_changes"} <= set(iterations) and adjusted.has_cad_model:
                found.append(labels(iterations))
        if set(summary.residuals_before) & set(summary.residuals_after):
            found.append(residuals(summary.residuals_before, summary.residuals_after))
    histogram = None
    if survey.is_in_hull_frame:
        solution = adjusted.solution if adjusted is not None else None
        histogram = deviation_histogram(
            solution, survey.surfaces.as_found, survey.surfaces.deviation
        )
    return [*found, histogram] if histogram else found
