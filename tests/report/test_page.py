# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The page, from a whole survey and from a bare one."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np

from hullrecon.report.content.headline import area, summary_lines, weak_sentences
from hullrecon.report.content.page import render
from hullrecon.report.content.page_context import coverage_rows, page_view
from hullrecon.report.content.survey import Mosaic, Survey
from hullrecon.report.export.summary import summary_json
from hullrecon.report.figures.gallery import all_plots

FILES = {"trajectory.csv": {"bytes": 1234, "sha256": "ab" * 32}}


class Reader(HTMLParser):
    """Collects tags with their attributes, ids and text; checks that tags are closed."""

    VOID = frozenset(("meta", "link", "img", "br", "hr", "input"))

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] not in ("style", "script"):
            self.text += data

    def with_attribute(self, name: str) -> list[str]:
        return [a[name] or "" for _, a in self.tags if name in a]


def page_of(survey: Survey, plots: bool = False) -> Reader:
    return Reader(render(page_view(survey, all_plots(survey) if plots else [], FILES)))


def test_the_page_needs_no_network(survey: Survey) -> None:
    page = page_of(survey, plots=True)
    addresses = page.with_attribute("src") + page.with_attribute("href")
    assert all(a.startswith(("data:image/", "#", "../")) for a in addresses)
    assert "link" not in [t for t, _ in page.tags]


def test_every_tag_is_closed_and_every_link_inside_the_page_leads_somewhere(survey: Survey) -> None:
    page = page_of(survey)
    assert page.open == []
    ids = page.with_attribute("id")
    assert len(ids) == len(set(ids))
    assert {h[1:] for h in page.with_attribute("href") if h.startswith("#")} <= set(ids)


def test_every_picture_has_words_instead(survey: Survey) -> None:
    page = page_of(survey, plots=True)
    assert all(a.get("alt") for t, a in page.tags if t == "img")
    assert all(a.get("aria-label") for t, a in page.tags if t == "svg")


def test_the_page_says_what_was_found_and_how_sure_it_is(survey: Survey) -> None:
    text = re.sub(r"\s+", " ", page_of(survey).text)
    for said in (
        "Hull survey: plate-1", "0.100 ± 0.004 m", "frame 3 + 0.2 m, port", "6 views", "< 0.0001",
        "The position along the hull is uncertain by 0.50 m.", "adjust: two rays missed",
        "no DVL from 31.0 s to 34.2 s of the log",
        "frame 4, 0.20 m²", "adjust.rounds", "ab" * 32, "2026-05-04 09:30:02.468 UTC",
    ):  # fmt: skip
        assert said in text, said


def test_the_card_shows_its_outline_on_the_image_that_it_names(survey: Survey) -> None:
    (card,) = page_view(survey, [], FILES)["cards"]
    crop = card["crop"]["crop"]
    assert (crop.camera, crop.row) == ("camera_top", 2)
    center = crop.outline.mean(axis=0)
    np.testing.assert_allclose(np.ptp(crop.outline[:, 0]), 0.2 * 500 / 1.0, rtol=0.03)  # 1 m away, 500 px a metre
    assert 0 < center[0] < crop.width
    assert 0 < center[1] < crop.height


def test_text_from_the_package_cannot_become_markup(survey: Survey) -> None:
    evil = replace(survey, dive=replace_name(survey, "<script>x</script>"), findings={"lost": ["<b>topic</b>"]})
    page = page_of(evil)
    assert "script" not in [t for t, _ in page.tags]
    assert "b" not in [t for t, _ in page.tags]


def replace_name(survey: Survey, vessel: str) -> Any:
    return type(survey.dive)(name=survey.dive.name, vessel=vessel, date=survey.dive.date)


def test_a_bare_dive_gets_the_whole_page_with_reasons(bare: Survey) -> None:
    page = page_of(bare)
    assert page.open == []
    assert "no camera was carried" in page.text
    assert "dead reckon" in page.text
    assert {"summary", "plan", "objects", "position", "left-out", "record"} <= set(page.with_attribute("id"))


def test_the_same_survey_gives_the_same_bytes(survey: Survey) -> None:
    first, second = (render(page_view(survey, all_plots(survey), FILES)) for _ in range(2))
    assert first == second


def test_mosaics_are_shown_with_their_caption(survey: Survey) -> None:
    from io import BytesIO

    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(np.full((40, 60, 3), 90, np.uint8)).save(buffer, format="PNG")
    mosaic = Mosaic({"caption": "31 m² at 17.6 mm a pixel.", "resolution_m": 0.0176}, buffer.getvalue(), meshed=True)
    shown = replace(survey, sonar=mosaic)
    page = page_of(shown)
    assert "31 m² at 17.6 mm a pixel." in page.text
    assert {"../ortho_sonar.tif", "../mosaic_sonar.glb"} <= set(page.with_attribute("href"))
    bare = page_of(replace(survey, sonar=replace(mosaic, meshed=False)))
    assert "../mosaic_sonar.glb" not in bare.with_attribute("href")
    assert "sonar at 17.6 mm a pixel" in " ".join(summary_lines(shown))


def test_the_summary_has_at_most_ten_lines_and_begins_with_the_dive(survey: Survey) -> None:
    lines = summary_lines(survey)
    assert len(lines) <= 10
    assert lines[0] == "Dive plate-1 on MV Plate: 4 s, 2.00 m of path, 5 poses, 5 images of 1 camera."
    assert "The position along the hull is uncertain by 0.50 m." in lines
    assert "1 object found on the hull (1 protrusion); the largest, no. 1, has a height of 0.100 ± 0.004 m." in lines
    assert (
        "Where it was seen the hull lies 6 mm outside its CAD model in the median; nine tenths of it between +6 and +6 mm."
        in lines
    )


def test_without_the_adjustments_words_a_large_sigma_is_said_all_the_same(survey: Survey, bare: Survey) -> None:
    assert weak_sentences(replace(survey, adjust={})) == [
        "The position along x of the ship is uncertain by 0.50 m (one sigma)."
    ]
    assert [s.split(" is ")[0] for s in weak_sentences(bare)] == [
        "The position in x of the level frame", "The position in y of the level frame"]  # fmt: skip


def test_a_place_that_was_not_reported_is_named_with_its_reason(survey: Survey) -> None:
    refused = ({"center": [1.0, -1.2, 0.0], "height": 0.031, "reason": "seen from two views only"},)
    page = page_of(replace(survey, not_reported=refused))
    assert "seen from two views only (height 0.031 m at 1.00, -1.20, 0.00)" in page.text


def test_an_object_without_a_cad_model_has_no_distance_to_it(survey: Survey, found: dict[str, Any]) -> None:
    (card,) = page_view(replace(survey, objects=({**found, "deviation": None},)), [], FILES)["cards"]
    assert ("Largest distance to the CAD model", "–") in card["rows"]


def test_no_object_is_said_in_words(survey: Survey) -> None:
    assert any("No object was found" in line for line in summary_lines(replace(survey, objects=())))


def test_a_sensor_that_was_not_carried_saw_no_area() -> None:
    assert area({"camera": {"area_m2": 4.0}, "sonar": None}, "camera") == 4.0
    assert area({"camera": {"area_m2": 4.0}, "sonar": None}, "sonar") is None


def test_percentiles_of_the_coverage_are_in_words(survey: Survey) -> None:
    assert coverage_rows(survey) == [
        ("Hull seen by camera", "4.0 m²"),
        ("Ground sample distance, camera", "5 %: 1.8 mm, 95 %: 2.5 mm"),
    ]


def test_the_summary_document_counts_and_keeps_what_varies_apart(survey: Survey) -> None:
    document = summary_json(survey, FILES)
    assert document["frame"] == "M"
    assert document["counts"]["landmarks"] == 3
    assert document["counts"]["landmarks_on_surface"] == 2
    assert document["counts"]["path_m"] == 2.0
    assert document["counts"]["iterations"] == 2
    assert document["deliverables"] == FILES
    assert document["warnings"] == ["adjust: two rays missed"]
    assert document["run"] == {"steps": {"adjust": {"seconds": 7.5}}}


def test_the_summary_of_a_bare_dive_names_what_is_absent(bare: Survey) -> None:
    document = summary_json(bare, FILES)
    assert (document["frame"], document["method"]) == ("g", "dead reckoning")
    assert document["absent"]["objects.json"] == "no camera was carried"
