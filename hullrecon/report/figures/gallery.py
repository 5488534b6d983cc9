# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""All plots that a survey gives, in the order of the page."""

from __future__ import annotations

from hullrecon.report.content.survey import Survey
from hullrecon.report.figures.plots import convergence, depth_and_standoff, deviation_histogram, labels, residuals, sigmas
from hullrecon.report.figures.style import Plot


def all_plots(survey: Survey) -> list[Plot]:
    """Only those whose numbers are there."""
    found = [depth_and_standoff(survey.track.t_ns, survey.trajectory.translation[:, 2], survey.dvl), sigmas(survey.track)]
    if survey.iterations is not None and len(survey.iterations.get("cost", ())):
        found.append(convergence(survey.iterations))
        if {"on_surface", "label_changes"} <= set(survey.iterations) and survey.track.frame == "M":
            found.append(labels(survey.iterations))
    statistics = {when: survey.adjust.get(f"residuals_{when}") or {} for when in ("before", "after")}
    if set(statistics["before"]) & set(statistics["after"]):
        found.append(residuals(statistics))
    histogram = deviation_histogram(survey.solution, survey.as_found)
    return [*found, histogram] if histogram else found
