# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The page, from a whole survey and from a bare one."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise

import numpy as np
from report_pages import draw_all_plots, page_context

from hullrecon.dive.config.schema import Dive
from hullrecon.geometry.frames import Camera
from hullrecon.records.deliverables import (
    Coverage,
    RegionCoverage,
    RegionShare,
    RejectedRegion,
    ReportedObject,
    SensorCoverage,
)
from hullrecon.report.content.headline import headline, weak_sentences
from hullrecon.report.content.objects import object_crops, object_rows
from hullrecon.report.content.page_context import coverage_rows
from hullrecon.report.export.summary import FileEntry, counts, summary_document
from hullrecon.report.render import render_html, render_page
from hullrecon.report.survey import (
    AdjustSummary,
    LogFindings,
    Mosaic,
    MosaicFacts,
    Mosaics,
    Survey,
    SuspectFacts,
)

FILES = {"trajectory.csv": FileEntry(bytes=1234, sha256="ab" * 32)}


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
    return Reader(
        render_page(
            page_context(
                survey, draw_all_plots(survey) if plots else [], FILES, object_crops(survey)
            )
        )
    )


def test_the_page_needs_no_network(survey: Survey) -> None:
    page = page_of(survey, plots=True)
    addresses = page.with_attribute("src") + page.with_attribute("href")
    assert all(a.startswith(("data:image/", "#", "../")) for a in addresses)
    assert "link" not in [t for t, _ in page.tags]


def test_tags_are_closed_and_inner_links_lead_somewhere(survey: Survey) -> None:
    page = page_of(survey)
    assert page.open == []
    ids = page.with_attribute("id")
    assert len(ids) == len(set(ids))
    assert {h[1:] for h in page.with_attribute("href") if h.startswith("#")} <= set(ids)


def test_the_appendix_lists_who_was_suspected(survey: Survey) -> None:
    assert survey.adjusted is not None
    assert "left out, or freed" not in page_of(survey, plots=True).text
    facts = SuspectFacts(words="without the DVL's velocities", gain=123.4)
    summary = AdjustSummary(suspects=(facts,))
    suspected = replace(survey, adjusted=replace(survey.adjusted, summary=summary))
    assert "without the DVL's velocities: 123" in page_of(suspected, plots=True).text


def test_every_picture_has_words_instead(survey: Survey) -> None:
    page = page_of(survey, plots=True)
    assert all(a.get("alt") for t, a in page.tags if t == "img")
    assert all(a.get("aria-label") for t, a in page.tags if t == "svg")


def test_the_page_says_what_was_found_and_how_sure_it_is(survey: Survey) -> None:
    text = re.sub(r"\s+", " ", page_of(survey).text)
    for text_shown in (
        "Hull survey: plate-1", "0.100 ± 0.004 m", "frame 3 + 0.2 m, port", "6 views", "< 0.0001",
        "The position along the hull is uncertain by 0.50 m.", "adjust: two rays missed",
        "no DVL from 2026-05-04T09:30:31.000Z to 2026-05-04T09:30:34.200Z",
        "frame 4, 0.20 m²", "adjust.rounds", "ab" * 32, "2026-05-04 09:30:02.468 UTC",
    ):  # fmt: skip
        assert text_shown in text, text_shown


def test_the_card_shows_its_outline_on_the_image_that_it_names(survey: Survey) -> None:
    (card,) = page_context(survey, [], FILES, object_crops(survey))["cards"]
    crop = card["crop"]["crop"]
    assert (crop.camera, crop.row) == (Camera.TOP, 2)
    center = crop.outline.mean(axis=0)
    # 1 m away, 500 px a metre
    np.testing.assert_allclose(np.ptp(crop.outline[:, 0]), 0.2 * 500 / 1.0, rtol=0.03)
    assert 0 < center[0] < crop.width
    assert 0 < center[1] < crop.height


def test_text_from_the_package_cannot_become_markup(survey: Survey) -> None:
    evil_facts = replace(
        survey.facts,
        dive=Dive(name="plate-1", vessel="<script>x</script>"),
        log=LogFindings(lost=("<b>topic</b>",)),
    )
    evil = replace(survey, facts=evil_facts)
    page, tame = page_of(evil), page_of(survey)
    assert [t for t, _ in page.tags].count("script") == [t for t, _ in tame.tags].count("script")
    assert "b" not in [t for t, _ in page.tags]


def test_a_bare_dive_gets_the_whole_page_with_reasons(bare: Survey) -> None:
    page = page_of(bare)
    assert page.open == []
    assert "no camera was carried" in page.text
    assert "dead reckon" in page.text
    ids = set(page.with_attribute("id"))
    assert {"summary", "position", "rejected", "record"} <= ids
    assert not ids & {
        "plan",
        "map",
        "objects",
        "object-table",
        "deviation",
        "mosaics",
        "coverage",
        "view",
        "scene",
    }
    assert "Objects were not looked for: no camera was carried." in page.text


def test_the_same_survey_gives_the_same_bytes(
    survey: Survey, pictures_drawn: dict[bytes, object]
) -> None:
    pages = []
    for _ in range(2):
        pictures_drawn.clear()
        plots, photos = draw_all_plots(survey), object_crops(survey)
        pages.append(render_page(page_context(survey, plots, FILES, photos)))
    assert pages[0] == pages[1]


def after(survey: Survey, seconds: float, peak_rss_bytes: int) -> list[str]:
    """The lines of the page of the same results from a run of another speed."""
    speed = {"started": 0.0, "seconds": seconds, "peak_rss_bytes": peak_rss_bytes}
    steps = tuple(replace(step, run={**step.run, **speed}) for step in survey.provenance.steps)
    again = replace(survey, provenance=replace(survey.provenance, steps=steps))
    return render_page(page_context(again, [], FILES, object_crops(again))).splitlines()


def test_runs_of_other_speed_differ_in_volatile_lines_only(
    survey: Survey,
) -> None:
    quick, slow = after(survey, 1.0, 10**8), after(survey, 9.0, 3 * 10**8)
    assert len([line for line in quick if "data-volatile" in line]) > len(survey.provenance.steps)
    assert quick != slow
    assert [a for a in quick if "data-volatile" not in a] == [
        b for b in slow if "data-volatile" not in b
    ]


def gray_png() -> bytes:
    from io import BytesIO

    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(np.full((40, 60, 3), 90, np.uint8)).save(buffer, format="PNG")
    return buffer.getvalue()


def test_mosaics_are_shown_with_their_caption(survey: Survey) -> None:
    mosaic = Mosaic(
        facts=MosaicFacts(caption="31 m² at 17.6 mm per pixel.", resolution_m=0.0176),
        preview=gray_png(),
        has_mesh=True,
    )
    shown = replace(survey, mosaics=Mosaics(sonar=mosaic))
    page = page_of(shown)
    assert "31 m² at 17.6 mm per pixel." in page.text
    assert {"../ortho_sonar.tif", "../mosaic_sonar.glb"} <= set(page.with_attribute("href"))
    bare = page_of(replace(survey, mosaics=Mosaics(sonar=replace(mosaic, has_mesh=False))))
    assert "../mosaic_sonar.glb" not in bare.with_attribute("href")
    assert "sonar at 17.6 mm per pixel" in " ".join(headline(shown))


def test_the_summary_has_ten_lines_and_begins_with_the_dive(survey: Survey) -> None:
    lines = headline(survey)
    assert len(lines) <= 10
    assert (
        lines[0]
        == "Dive plate-1 on MV Plate: 4 s, 2.00 m of path, 5 poses, 5 images from 1 camera."
    )
    assert "The position along the hull is uncertain by 0.50 m." in lines
    assert (
        "1 object found on the hull (1 protrusion); "
        "the largest, no. 1, has a height of 0.100 ± 0.004 m." in lines
    )
    assert any(
        line.startswith("Within the surveyed patch the hull's form departs from its CAD model by")
        for line in lines
    )


def test_a_large_sigma_is_said_without_adjusts_sentences(survey: Survey, bare: Survey) -> None:
    assert weak_sentences(
        replace(survey, adjusted=replace(survey.adjusted, weak_directions=()))
    ) == ["The position along x of the ship is uncertain by 0.50 m (one sigma)."]
    assert [s.split(" is ")[0] for s in weak_sentences(bare)] == [
        "The position in x of the local frame", "The position in y of the local frame"]  # fmt: skip


def test_a_place_that_was_not_reported_is_named_with_its_reason(survey: Survey) -> None:
    region = RejectedRegion(
        center=(1.0, -1.2, 0.0),
        height=0.031,
        reason="seen from two views only",
        address="frame 2, port",
    )
    page = page_of(replace(survey, findings=replace(survey.findings, not_reported=(region,))))
    assert "seen from two views only (height 0.031 m, frame 2, port)" in page.text


def test_an_object_without_a_cad_model_has_no_distance_to_it(
    survey: Survey, found: ReportedObject
) -> None:
    (card,) = page_context(with_objects(survey, replace(found, deviation=None)), [], FILES, {})[
        "cards"
    ]
    assert not any("CAD model" in name for name, _ in card["rows"])


def test_no_object_is_said_in_words(survey: Survey) -> None:
    assert any("No object was found" in line for line in headline(with_objects(survey)))


def test_a_sensor_that_was_not_carried_saw_no_area(survey: Survey) -> None:
    assert "Hull seen: 4.0 m² by camera; 1 hole of more than 0.03 m² in the coverage." in headline(
        survey
    )
    with_dvl = replace(
        survey.findings, coverage=Coverage(camera=None, dvl=SensorCoverage(area_m2=2.0))
    )
    assert "Hull seen: 2.0 m² by DVL." in headline(replace(survey, findings=with_dvl))


def test_a_row_of_sigmas_has_one_unit(survey: Survey) -> None:
    assert any(
        "one sigma in x / y / z: 0.500 / 0.020 / 0.010 m." in line for line in headline(survey)
    )


def test_the_page_says_how_circular_the_comparison_is(survey: Survey, bare: Survey) -> None:
    assert "The comparison is partly circular." in page_of(survey).text
    in_g = replace(bare, surfaces=survey.surfaces)
    assert "circular" not in page_of(in_g).text


def test_without_a_cad_model_no_deviation_is_claimed(survey: Survey, bare: Survey) -> None:
    in_g = replace(bare, surfaces=replace(survey.surfaces, chart=None))
    assert not any("patch" in line for line in headline(in_g))
    text = page_of(in_g).text
    assert "Deviation from the CAD model" not in text
    numbers = [int(n) for n in re.findall(r"(?m)^(\d+) [A-Z]", text)]
    # without a gap for the section that is absent
    assert sorted(set(numbers)) == list(range(1, max(numbers) + 1))
    assert "deviation_histogram" not in [plot.name for plot in draw_all_plots(in_g)]


def test_what_was_not_measured_is_not_spoken_of(survey: Survey, bare: Survey) -> None:
    blind = replace(bare, facts=replace(bare.facts, has_depth=False, has_attitude=False))
    assert "water surface" not in blind.frame_in_words
    assert "z = 0 at the depth of the first pose, which was not measured" in blind.frame_in_words
    assert "local level" not in blind.frame_in_words
    assert bare.frame_in_words == "local level: z down, z = 0 at the water surface"
    page = page_of(blind).text
    assert "no heading was measured, and no depth was measured" in page
    assert "Neither depth nor distance to the hull was measured." in page
    assert "landmarks_on_surface" not in counts(blind)


def test_no_page_denies_holes_beside_a_mosaic_with_gaps(survey: Survey) -> None:
    whole = replace(
        survey,
        findings=replace(survey.findings, coverage=Coverage(camera=SensorCoverage(area_m2=4.0))),
    )
    assert (
        "No hole of more than 0.03 m² was found within the outline of what was seen."
        in page_of(whole).text
    )
    assert "a hole if a square of 0.2 m fits into it" in page_of(whole).text
    gappy = Mosaic(facts=MosaicFacts(gap_area_m2=0.4), preview=gray_png(), has_mesh=False)
    torn = replace(whole, mosaics=Mosaics(optical=gappy))
    assert "the mosaics have gaps that their captions name" in page_of(torn).text


def test_regions_of_dive_toml_have_a_table_of_coverage(survey: Survey) -> None:
    """On the page and in print; without regions neither has a word of them."""
    share = RegionShare(area_m2=2.0, area_sigma_m2=0.01, share=0.25, share_sigma=0.001)
    bow = RegionCoverage(
        name="<bow>", along=(30.0, 34.0), girth=(0.0, 2.0), area_m2=8.0, camera=share
    )
    coverage = replace(survey.findings.coverage, regions=(bow,))
    counted = replace(survey, findings=replace(survey.findings, coverage=coverage))
    for render in (render_page, render_html):
        text = Reader(render(page_context(counted, [], FILES, object_crops(counted)))).text
        assert all(
            words in text
            for words in (
                "Coverage by region",
                "<bow>",
                "30 to 34 m",
                "2.0 ± 0.1 m² (25 ± 1 %)",
                "not carried",
            )
        )
        assert (
            "by region"
            not in Reader(render(page_context(survey, [], FILES, object_crops(survey)))).text
        )


def test_rejected_observations_are_counted_out_of_all(survey: Survey) -> None:
    assert "2 of 100 image observations rejected as outliers" in page_of(survey).text


def with_objects(survey: Survey, *objects: ReportedObject) -> Survey:
    return replace(survey, findings=replace(survey.findings, objects=objects))


def test_percentiles_of_the_coverage_are_in_words(survey: Survey) -> None:
    assert coverage_rows(survey.findings.coverage) == [
        ("Hull seen by camera", "4.0 m²"),
        ("Ground sample distance, camera", "2 mm (5th to 95th percentile 1.8 to 2.5 mm)"),
    ]


def test_the_summary_document_counts_and_keeps_what_varies_apart(survey: Survey) -> None:
    document = summary_document(survey, FILES)
    assert document["frame"] == "M"
    assert document["counts"]["landmarks"] == 3
    assert document["counts"]["landmarks_on_surface"] == 2
    assert document["counts"]["path_m"] == 2.0
    assert document["counts"]["iterations"] == 2
    assert document["deliverables"] == {"trajectory.csv": {"bytes": 1234, "sha256": "ab" * 32}}
    assert document["warnings"] == ["adjust: two rays missed"]
    assert document["run"] == {"steps": {"adjust": {"started": 0.0, "seconds": 7.5}}}


def test_the_summary_of_a_bare_dive_names_what_is_absent(bare: Survey) -> None:
    document = summary_document(bare, FILES)
    assert (document["frame"], document["method"]) == ("g", "dead reckoning")
    assert document["absent"]["objects.json"] == "no camera was carried"


def test_the_page_links_only_rasters_that_are_delivered(survey: Survey) -> None:
    assert "../form.tif" not in page_of(survey).with_attribute("href")
    files = {**FILES, "form.tif": FILES["trajectory.csv"]}
    text = render_page(page_context(survey, [], files, {}))
    assert 'href="../form.tif"' in text
    assert "where images saw it" not in text


def test_what_a_reader_asks_first_is_on_top(survey: Survey) -> None:
    found = re.search(
        r'(?s)class="verdict">(.*?)</p>.*?class="tiles">(.*?)</dl>',
        render_page(page_context(survey, [], FILES, {})),
    )
    assert found is not None
    assert (
        found[1] == "1 object found on the hull (1 protrusion); "
        "the largest, no. 1, has a height of 0.100 ± 0.004 m."
    )
    words = re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", found[2])).strip()
    assert words == (
        "Object 1 on the hull Hull seen 4.0 m² by camera "
        "Vehicle, along the hull ± 0.50 m ± 20 mm in girth, one sigma "
        "Form off the CAD model −3 to +3 mm one sigma 2.0 mm"
    )


def test_the_table_has_a_row_an_object_that_leads_to_its_card(
    survey: Survey, found: ReportedObject
) -> None:
    recess = replace(found, id=2, height=-0.03, address="frame 9", p_value=None, depth=None)
    page = page_of(with_objects(survey, found, recess))
    assert {"row-1", "row-2", "object-1", "object-2"} <= set(page.with_attribute("id"))
    assert [
        a["data-object"] for t, a in page.tags if t == "a" and a.get("data-action") == "card"
    ] == ["1", "2"]
    table = object_rows(with_objects(survey, found, recess))
    assert table.headings == [
        "No.",
        "Kind",
        "Height",
        "Area",
        "Along",
        "Girth",
        "Depth",
        "False alarm",
    ]
    cells = dict(table.rows)[2]
    assert [cell.text for cell in cells] == [
        "2",
        "recess",
        "−0.030 ± 0.004 m",
        "250 ± 20 cm²",
        "1.0 ± 0.3 m",
        "−1.20 ± 0.02 m",
        "–",
        "–",
    ]
    assert [cell.value for cell in cells] == [2, None, -0.03, 0.025, 1.0, -1.2, None, None]


def test_a_column_that_no_object_fills_is_absent(
    survey: Survey, bare: Survey, found: ReportedObject
) -> None:
    dry = with_objects(survey, replace(found, depth=None, along=None))
    assert object_rows(dry).headings == ["No.", "Kind", "Height", "Area", "Girth", "False alarm"]
    assert "Across" in object_rows(with_objects(bare, found)).headings
    assert object_rows(bare).rows == []


def test_many_cards_are_folded_away_and_few_are_not(survey: Survey, found: ReportedObject) -> None:
    def folded(count: int) -> bool:
        many = with_objects(survey, *(replace(found, id=k + 1) for k in range(count)))
        return 'class="all-cards"><summary>' in render_page(page_context(many, [], FILES, {}))

    assert not folded(12)
    assert folded(13)


def test_headings_never_skip_a_level(survey: Survey) -> None:
    levels = [
        int(tag[1]) for tag, _ in page_of(survey, plots=True).tags if re.fullmatch(r"h[1-6]", tag)
    ]
    assert levels[0] == 1
    assert all(below <= above + 1 for above, below in pairwise(levels))


def test_all_controls_have_names(survey: Survey) -> None:
    page = page_of(survey)
    labelled = set(page.with_attribute("for"))
    for tag, attributes in page.tags:
        if tag == "input":
            assert attributes["id"] in labelled
        if attributes.get("role") == "region":
            assert attributes["aria-label"]
