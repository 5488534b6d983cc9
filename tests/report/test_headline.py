# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The sentences on top of the page."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from msgspec.structs import replace as replace_struct

from hullrecon.records.deliverables import RejectedRegion, ReportedObject
from hullrecon.records.solution import Solution
from hullrecon.records.surface import DeviationSplit
from hullrecon.report.content.headline import (
    headline,
    key_figures,
    path_length_m,
    verdict,
    weak_sentences,
)
from hullrecon.report.export.summary import counts
from hullrecon.report.survey import (
    AdjustSummary,
    LogFindings,
    Mosaic,
    MosaicFacts,
    Mosaics,
    PositionFacts,
    Provenance,
    StepRun,
    StereoContradictionFacts,
    Survey,
)


def line_with(survey: Survey, text: str) -> str:
    """The one sentence that holds a text."""
    (line,) = [line for line in headline(survey) if text in line]
    return line


def with_objects(survey: Survey, *objects: ReportedObject) -> Survey:
    return replace(survey, findings=replace(survey.findings, objects=objects))


def test_the_path_is_as_long_as_its_steps_together(survey: Survey) -> None:
    assert path_length_m(survey) == pytest.approx(2.0)


@pytest.mark.parametrize("length_m", [4.4751, 4.4749, 4.4849, 2.0051])
def test_the_path_is_as_long_in_the_sentence_as_in_the_files(bare: Survey, length_m: float) -> None:
    track = bare.track
    stretched = replace(track.poses, translation=track.poses.translation * length_m / 2.0)
    survey = replace(bare, track=replace(track, poses=stretched))
    assert f"{counts(survey)['path_m']:.2f} m of path" in headline(survey)[0]


def test_a_dive_without_a_camera_says_so(bare: Survey) -> None:
    assert (
        headline(bare)[0]
        == "Dive bare on the vessel: 4 s, 2.00 m of path, 5 poses, without a camera."
    )


def test_dead_reckoning_is_named_as_such(bare: Survey) -> None:
    assert "dead reckoned in a local frame (g)" in headline(bare)[1]


def test_an_adjusted_dive_names_method_and_frame(survey: Survey) -> None:
    assert "adjusted by method maxmix and given in the ship's frame (M)" in headline(survey)[1]


def test_positions_from_outside_have_their_distance_to_the_path(
    survey: Survey,
) -> None:
    assert survey.adjusted is not None
    facts = PositionFacts(count=40, span_s=200.0, sigma_m=0.5, rms_sigmas=1.04, outliers=2)
    bounded = replace(
        survey.adjusted, summary=replace_struct(survey.adjusted.summary, positions=facts)
    )
    assert line_with(replace(survey, adjusted=bounded), "from outside").endswith(
        "bound its drift; they lie 1.0 sigmas (rms, 2 outliers apart) from the path."
    )
    assert not any("from outside" in line for line in headline(survey))


def test_a_stereo_calibration_that_does_not_hold_is_said_on_top(survey: Survey) -> None:
    assert survey.adjusted is not None
    said = "The stereo calibration does not hold: the images fit with the bottom camera turned"
    said += " by 0.10 degrees from it."
    for sentence, lines in ((said, 1), (None, 0)):
        summary = AdjustSummary(stereo_contradiction=StereoContradictionFacts(sentence=sentence))
        doubted = replace(survey, adjusted=replace(survey.adjusted, summary=summary))
        assert headline(doubted)[:4].count(said) == lines
        assert "" not in headline(doubted)


def test_an_adjusted_dive_without_a_cad_model_is_in_g(survey: Survey, solution: Solution) -> None:
    assert survey.adjusted is not None
    free = replace(solution, hull_pose=None)
    in_g = replace(survey, track=free.track(), adjusted=replace(survey.adjusted, solution=free))
    assert "a local frame (g), as there is no CAD model" in headline(in_g)[1]
    assert line_with(in_g, "landmarks were") == "3 landmarks were measured in the images."


def test_a_cad_model_that_was_left_out_is_not_said_to_be_none(
    survey: Survey, solution: Solution
) -> None:
    assert survey.adjusted is not None
    free = replace(solution, hull_pose=None)
    refused = replace(
        survey.adjusted,
        solution=free,
        summary=AdjustSummary(cad_model_refused="it is another ship's"),
    )
    in_g = replace(survey, track=free.track(), adjusted=refused)
    assert (
        "a local frame (g), as the CAD model was left out, see warnings; median"
        in headline(in_g)[1]
    )
    assert in_g.origin_in_words.startswith(
        "The CAD model was left out: positions are relative to the start of the dive"
    )
    assert replace(in_g, adjusted=None).origin_in_words.startswith(
        "There is no CAD model to align with"
    )


def test_landmarks_on_the_hull_are_a_share_of_all(survey: Survey) -> None:
    assert line_with(survey, "landmarks were") == (
        "3 landmarks were measured in the images, "
        "66.7 % of them taken to lie on the CAD model's surface."
    )


def test_only_the_first_two_uncertain_directions_are_on_top(survey: Survey) -> None:
    assert survey.adjusted is not None
    weak = tuple({"sentence": f"Direction {k} is uncertain."} for k in range(4))
    many = replace(survey, adjusted=replace(survey.adjusted, weak_directions=weak))
    assert len(weak_sentences(many)) == 4
    assert sum("is uncertain" in line for line in headline(many)) == 2


def test_a_small_sigma_makes_no_sentence(bare: Survey) -> None:
    track = replace(bare.track, covariance=np.tile(np.eye(6) * 1e-4, (5, 1, 1)))
    assert weak_sentences(replace(bare, track=track)) == []


def test_protrusions_and_recesses_are_counted_apart(survey: Survey, found: ReportedObject) -> None:
    recess = replace(found, id=2, height=-0.2)
    line = line_with(
        with_objects(survey, found, recess, replace(found, id=3, height=-0.05)), "found on the hull"
    )
    assert line.startswith(
        "3 objects found on the hull (1 protrusion and 2 recesses); the largest, no. 2,"
    )


def test_objects_that_were_not_looked_for_are_not_mentioned(bare: Survey) -> None:
    assert not any("object" in line.lower() for line in headline(bare))


def test_form_and_offset_are_told_apart_each_with_its_sigma(survey: Survey) -> None:
    assert line_with(survey, "CAD model by") == (
        "Within the surveyed patch the hull's form departs from its CAD model by −3 to +3 mm "
        "(5th to 95th percentile; one sigma 2.0 mm); as a whole the patch lies 6 mm outside it "
        "(one sigma 20 mm, not significantly different from zero)."
    )


def test_an_offset_beyond_two_sigmas_is_a_finding(survey: Survey, split: DeviationSplit) -> None:
    far = replace(split, offset=np.asarray(-0.05))
    line = line_with(
        replace(survey, surfaces=replace(survey.surfaces, deviation=far)), "CAD model by"
    )
    assert line.endswith("as a whole the patch lies 50 mm inside it (one sigma 20 mm).")


def test_without_a_cad_model_no_sentence_speaks_of_a_deviation(
    survey: Survey, bare: Survey
) -> None:
    in_g = replace(survey, track=bare.track)
    assert not any("patch" in line or "deviat" in line for line in headline(in_g))


def test_holes_are_told_with_the_least_that_counts(survey: Survey) -> None:
    assert line_with(survey, "Hull seen").endswith("; 1 hole of more than 0.03 m² in the coverage.")


def test_a_dive_without_warnings_says_so(bare: Survey) -> None:
    quiet = replace(bare, provenance=Provenance())
    assert headline(quiet)[-1] == "The log was read completely and no step raised a warning."


def test_losses_and_warnings_are_counted(survey: Survey) -> None:
    facts = replace(survey.facts, log=LogFindings(lost=("a", "b")))
    line = line_with(replace(survey, facts=facts), "rejected data")
    assert (
        line
        == "2 spans of data were lost and 1 warning was raised; see rejected data and warnings."
    )


def test_a_mosaic_without_a_resolution_is_not_named(survey: Survey) -> None:
    unknown = Mosaic(facts=MosaicFacts(caption="x"), preview=b"", has_mesh=False)
    assert not any(
        "Mosaic" in line for line in headline(replace(survey, mosaics=Mosaics(optical=unknown)))
    )


def test_the_verdict_says_why_nothing_was_looked_for(survey: Survey, bare: Survey) -> None:
    assert verdict(bare) == "Objects were not looked for: no camera was carried."
    nothing = replace(bare, provenance=Provenance())
    assert verdict(nothing) == "Objects were not looked for: the step did not run."
    clean = replace(survey, findings=replace(survey.findings, objects=()))
    assert verdict(clean) == "No object was found."
    assert verdict(clean) in headline(clean)
    assert verdict(survey) in headline(survey)


def test_without_an_object_the_headline_says_what_was_sought(
    survey: Survey,
) -> None:
    options = {
        "min_height_m": 0.03,
        "min_area_m2": 0.0025,
        "min_views": 3,
        "max_p_value": 0.001,
        "fusion": "heights",
    }
    detect = StepRun(
        name="detect",
        version=1,
        settings={"detect": options, "hull.region": []},
        inputs={},
        warnings=(),
        run={},
    )
    region = RejectedRegion(
        center=(0.0, 0.0, 0.0),
        reason="only 0.025 m off the hull around it",
        height=0.025,
        height_sigma=0.003,
    )
    clean = replace(
        survey,
        findings=replace(survey.findings, objects=(), not_reported=(region,)),
        provenance=replace(survey.provenance, steps=(*survey.provenance.steps, detect)),
    )
    assert verdict(clean) == (
        "No object was found. Looked for: what is at least 30 mm high or deep, 25 cm² large, "
        "shown by 3 images, and bare hull"
        " with a probability below 0.001. 1 region examined and not reported."
    )


def test_a_figure_is_given_where_it_was_measured(survey: Survey, bare: Survey) -> None:
    assert [name for name, _, _ in key_figures(survey)] == [
        "Object",
        "Hull seen",
        "Vehicle, along the hull",
        "Form off the CAD model",
    ]
    assert key_figures(bare) == []
    blind = replace(survey, findings=replace(survey.findings, coverage=None, objects=None))
    assert [name for name, _, _ in key_figures(blind)] == [
        "Vehicle, along the hull",
        "Form off the CAD model",
    ]


def test_without_a_cad_model_the_place_is_along_and_across(survey: Survey, bare: Survey) -> None:
    in_g = replace(bare, surfaces=replace(survey.surfaces, deviation=None))
    ((name, value, remark),) = key_figures(in_g)
    assert (name, remark.endswith("across, one sigma")) == ("Vehicle, along the hull", True)
    assert value.startswith("± ")
