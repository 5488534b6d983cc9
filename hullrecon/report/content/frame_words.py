# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The frame of the results in words: of what was measured, and of nothing else."""

from __future__ import annotations

from hullrecon.report.survey import Survey


def frame_in_words(survey: Survey) -> str:
    """Return what frame positions are given in, and where its axes point as far as sensors tell."""
    if survey.is_in_hull_frame:
        return "the hull frame: that of the CAD model's file"
    level = (
        "local level"
        if survey.facts.has_attitude
        else "local, level where the vehicle was at the first pose"
    )
    zero = (
        "at the water surface"
        if survey.facts.has_depth
        else "at the depth of the first pose, which was not measured"
    )
    return f"{level}: z down, z = 0 {zero}"


def origin_in_words(survey: Survey) -> str:
    """Return what positions without a CAD model are counted from."""
    heading = (
        "the heading is that of the first attitude"
        if survey.facts.has_attitude
        else "no heading was measured"
    )
    depth = (
        "depths are below the water surface" if survey.facts.has_depth else "no depth was measured"
    )
    refused = survey.adjusted is not None and survey.adjusted.cad_model_was_refused
    why = "The CAD model was left out" if refused else "There is no CAD model to align with"
    return f"{why}: positions are relative to the start of the dive; {heading}, and {depth}."
