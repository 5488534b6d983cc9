# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the template is given, piece by piece."""

from __future__ import annotations

from dataclasses import replace
from html import unescape
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from hullrecon.records.deliverables import (
    Coverage,
    CoverageHole,
    RegionCoverage,
    RegionShare,
    ReportedObject,
    SensorCoverage,
)
from hullrecon.report.content.objects import card_context, object_crops
from hullrecon.report.content.page_context import (
    coverage_rows,
    hole_text,
    mosaic_context,
    percentile_text,
    position_sentence,
    region_rows,
)
from hullrecon.report.figures.hull_map import hull_map
from hullrecon.report.figures.map_pictures import form_drawing
from hullrecon.report.figures.plan_view import survey_plan
from hullrecon.report.survey import Mosaic, MosaicFacts, Survey


def preview(width: int) -> bytes:
    buffer = BytesIO()
    Image.fromarray(np.full((30, width, 3), 90, np.uint8)).save(buffer, format="PNG")
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("percentiles", "text"),
    [
        (
            {"p05": 0.0018, "p50": 0.002, "p95": 0.0025},
            "2 mm (5th to 95th percentile 1.8 to 2.5 mm)",
        ),
        ({"p05": 0.0018, "p95": 0.0025}, "5th to 95th percentile 1.8 to 2.5 mm"),
        ({"p50": 0.002}, "2 mm"),
    ],
)
def test_percentiles_are_named(percentiles: dict[str, float], text: str) -> None:
    assert percentile_text(percentiles, 1000.0, " mm") == text


def test_coverage_rows_are_by_sensor_in_its_order() -> None:
    coverage = Coverage(
        camera=SensorCoverage(
            area_m2=8.3, area_twice_m2=8.1, incidence_deg={"p05": 3.0, "p50": 15.0, "p95": 32.0}
        ),
        dvl=SensorCoverage(area_m2=10.7),
    )
    assert coverage_rows(coverage) == [
        ("Hull seen by camera", "8.3 m²"),
        ("Hull seen at least twice by camera", "8.1 m²"),
        ("Incidence angle of the best view, camera", "15° (5th to 95th percentile 3 to 32°)"),
        ("Hull seen by DVL", "10.7 m²"),
    ]
    assert coverage_rows(None) == []


def test_a_hole_without_an_address_is_named_all_the_same() -> None:
    assert hole_text(CoverageHole(area_m2=0.251)) == "at a point without an address, 0.25 m²"


def test_without_a_chart_there_is_no_plan(bare: Survey) -> None:
    assert hull_map(bare) is None


def test_the_plan_names_its_extent_and_its_objects(survey: Survey) -> None:
    view = hull_map(survey)
    assert view is not None
    svg = survey_plan(survey, view)
    assert "path of the vehicle, hull seen, 1 object." in svg
    assert "Object 1: height 0.100 ± 0.004 m, frame 3 + 0.2 m, port" in svg


def test_an_object_stands_at_its_centre_on_the_chart(survey: Survey, found: ReportedObject) -> None:
    view = hull_map(survey)
    assert view is not None
    (placed,) = view.objects
    assert placed.found is found
    np.testing.assert_allclose(placed.at, [1.0, -1.2])
    assert placed.ellipse is not None
    assert placed.ellipse.half_axes == pytest.approx((0.3, 0.02))


def test_without_a_cad_model_there_is_no_map_of_the_deviation(survey: Survey, bare: Survey) -> None:
    view = hull_map(survey)
    drawing = form_drawing(survey, view)
    assert drawing is not None
    assert drawing().startswith(b"\x89PNG")
    assert form_drawing(replace(survey, track=bare.track), view) is None


def test_a_recess_is_called_so(survey: Survey, found: ReportedObject) -> None:
    assert card_context(replace(found, height=-0.1), survey, None)["kind"] == "Recess"
    assert card_context(found, survey, None)["kind"] == "Protrusion"


def test_a_card_without_a_picture_has_none(survey: Survey, found: ReportedObject) -> None:
    assert object_crops(replace(survey, facts=replace(survey.facts, images={}))) == {}
    assert card_context(found, survey, None)["crop"] is None


def test_every_measured_number_of_a_card_has_its_sigma(
    survey: Survey, found: ReportedObject
) -> None:
    rows = dict(card_context(found, survey, None)["rows"])  # type: ignore[call-overload]
    counted = (
        "More than half of its top seen in",
        "False-alarm probability, anywhere in the survey",
    )
    assert all("±" in text for name, text in rows.items() if name not in counted)
    assert rows["Largest distance to the CAD model"] == "0.10 ± 0.02 m"
    assert rows["Along, girth"] == "1.0 ± 0.3 m, −1.20 ± 0.02 m"
    assert rows["Centre (x, y, z)"] == "1.0 ± 0.3, −1.20 ± 0.02, −0.10 ± 0.05 m in M"


def test_a_card_says_where_the_survey_cut_its_object_off(
    survey: Survey, found: ReportedObject
) -> None:
    name = "Outline beyond which nothing was measured"
    assert name not in dict(card_context(found, survey, None)["rows"])  # type: ignore[call-overload]
    rows = dict(card_context(replace(found, open_edge=0.287), survey, None)["rows"])  # type: ignore[call-overload]
    assert rows[name] == "29 %: it may be larger, as the sigmas of its size say"


def test_without_a_pressure_sensor_a_card_has_no_depth(
    survey: Survey, found: ReportedObject
) -> None:
    rows = dict(card_context(replace(found, depth=None), survey, None)["rows"])  # type: ignore[call-overload]
    assert not any("epth" in name for name in rows)


def test_the_place_of_the_whole_survey_is_told_with_its_sigma(survey: Survey, bare: Survey) -> None:
    assert (
        position_sentence(survey)
        == "Its position as a whole is known to 0.50 m along the hull and 20 mm in girth "
        "(one sigma, median)."
    )
    assert position_sentence(bare) == ""


def test_a_wide_mosaic_is_reduced_for_the_page() -> None:
    from base64 import b64decode

    def width(pixels: int) -> int:
        mosaic = Mosaic(facts=MosaicFacts(caption="c"), preview=preview(pixels), has_mesh=True)
        data = str(mosaic_context("optical", mosaic)["src"]).split(",")[1]
        with Image.open(BytesIO(b64decode(data))) as picture:
            return picture.width

    assert width(600) == 600
    assert width(2400) == 1800


def test_a_mosaic_is_named_by_its_sensor() -> None:
    shown = mosaic_context(
        "sonar", Mosaic(facts=MosaicFacts(caption="c"), preview=preview(20), has_mesh=False)
    )
    assert (shown["name"], shown["stem"], shown["caption"], shown["has_mesh"]) == (
        "Sonar",
        "sonar",
        "c",
        False,
    )


def test_frames_are_numbered_on_the_ship_alone(survey: Survey, bare: Survey) -> None:
    """A CAD model that was left out leaves its frame spacing in dive.toml."""
    in_g = replace(
        bare, facts=replace(bare.facts, hull=survey.facts.hull), surfaces=survey.surfaces
    )
    on_ship, off_ship = (survey_plan(dive, hull_map(dive)) for dive in (survey, in_g))
    assert ">fr " in on_ship
    assert ">fr " not in off_ship
    assert "on the hull's chart" in unescape(on_ship)
    assert "on the survey's own chart" in unescape(off_ship)


def test_regions_are_rows_of_limits_and_of_what_each_sensor_saw() -> None:
    share = RegionShare(area_m2=2.04, area_sigma_m2=0.21, share=0.255, share_sigma=0.026)
    region = RegionCoverage(
        name="bow", along=(30.0, 34.5), girth=None, area_m2=8.0, camera=share, dvl=None, sonar=share
    )
    assert region_rows(Coverage(regions=(region,))) == [
        (
            "bow",
            "30 to 34.5 m",
            "whole",
            "8.0 m²",
            "2.0 ± 0.2 m² (26 ± 3 %)",
            "2.0 ± 0.2 m² (26 ± 3 %)",
            "not carried",
        )
    ]
    assert region_rows(Coverage()) == region_rows(None) == []
