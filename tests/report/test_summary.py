# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""summary.json: counts, and what differs between equal runs apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.report.export.summary import counts, summary_document
from hullrecon.report.survey import Survey


def test_a_bare_dive_counts_what_it_has(bare: Survey) -> None:
    assert counts(bare) == {
        "poses": 5,
        "path_m": 2.0,
        "duration_s": 4.0,
        "images": {},
        "images_unusable": {},
    }


def test_images_are_counted_by_camera(survey: Survey) -> None:
    found = counts(survey)
    assert (found["images"], found["images_unusable"]) == ({"camera_top": 5}, {"camera_top": 0})
    assert (found["objects"], found["dvl_pings"]) == (1, 3)


def test_starts_of_rounds_are_no_iterations(survey: Survey) -> None:
    assert survey.adjusted is not None
    rounds = {"cost": np.ones(5), "round": np.array([1, 1, 1, 2, 2])}
    assert (
        counts(replace(survey, adjusted=replace(survey.adjusted, iterations=rounds)))["iterations"]
        == 3
    )
    assert (
        counts(replace(survey, adjusted=replace(survey.adjusted, iterations={})))["iterations"]
        is None
    )


def test_clock_times_are_left_out_of_the_summary(survey: Survey) -> None:
    (step,) = survey.provenance.steps
    timed = replace(step, run={"seconds": 1.0, "times": {"iterations_s": [1, 2]}})
    document = summary_document(
        replace(survey, provenance=replace(survey.provenance, steps=(timed,))), {}
    )
    assert document["run"] == {"steps": {"adjust": {"seconds": 1.0}}}


def test_the_frame_is_said_in_words(survey: Survey, bare: Survey) -> None:
    assert str(summary_document(survey, {})["frame_in_words"]).startswith("the hull frame")
    assert str(summary_document(bare, {})["frame_in_words"]).startswith("local level")


def test_the_hosts_name_is_left_out_of_the_summary(survey: Survey) -> None:
    (step,) = survey.provenance.steps
    host = {"name": "bridge-laptop", "system": "Linux", "cores": 2}
    hosted = replace(step, run={"seconds": 1.0, "host": host})
    document = summary_document(
        replace(survey, provenance=replace(survey.provenance, steps=(hosted,))), {}
    )
    assert document["run"] == {
        "steps": {"adjust": {"seconds": 1.0, "host": {"system": "Linux", "cores": 2}}}
    }
    assert "bridge-laptop" not in str(document)
