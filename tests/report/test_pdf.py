# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""report.pdf, read back: pages, headings, every object and every parameter."""

from __future__ import annotations

import io
import re
import sys
from dataclasses import replace

import pytest
from pypdf import PdfReader
from report_pages import draw_all_plots, page_context

from hullrecon import __version__
from hullrecon.dive.config.schema import Dive
from hullrecon.report.content.objects import object_crops
from hullrecon.report.export.summary import FileEntry
from hullrecon.report.options import ReportOptions
from hullrecon.report.render import render_html, render_pdf
from hullrecon.report.survey import Survey

FILES = {f"file-{k:02d}.csv": FileEntry(bytes=1000 + k, sha256=f"{k:02x}" * 32) for k in range(40)}
MANY, OPTIONS = 4, 40


def context_of(survey: Survey, plots: bool = False) -> dict[str, object]:
    drawn = draw_all_plots(survey) if plots else []
    return dict(page_context(survey, drawn, FILES, object_crops(survey)))


ABOUT = ReportOptions(
    client="Harbour Authority & Sons",
    operator="Divers <Ltd>",
    equipment=("ROV with DVL", "stereo rig"),
    water="visibility 3 m",
    conclusion="Nothing that hinders service.\n\nClean the intake.",
)


@pytest.fixture(scope="module")
def rendered() -> dict[str, tuple[dict[str, object], bytes]]:
    """What a test of this file rendered, for the others: a PDF takes seconds."""
    return {}


@pytest.fixture
def paper(
    survey: Survey, rendered: dict[str, tuple[dict[str, object], bytes]]
) -> tuple[dict[str, object], bytes]:
    """Context and PDF of a dive of many objects, with plots and the inspection."""
    if "paper" not in rendered:
        inspected = replace(crowded(survey), facts=replace(survey.facts, about=ABOUT))
        context = context_of(inspected, plots=True)
        rendered["paper"] = context, render_pdf(context)
    return rendered["paper"]


@pytest.fixture
def pdf(paper: tuple[dict[str, object], bytes]) -> bytes:
    return paper[1]


def pages_of(pdf: bytes) -> list[str]:
    return [page.extract_text() for page in PdfReader(io.BytesIO(pdf)).pages]


def crowded(survey: Survey) -> Survey:
    """The survey with many objects and a long table of parameters."""
    one = (survey.findings.objects or ())[0]
    objects = tuple(
        replace(one, id=k + 1, height=0.05 + 0.001 * k, address=f"frame {k + 1}, port")
        for k in range(MANY)
    )
    step = survey.provenance.steps[0]
    settings = {"adjust": {f"option_{k}": k * 1.5 for k in range(OPTIONS)}}
    return replace(
        survey,
        findings=replace(survey.findings, objects=objects),
        provenance=replace(survey.provenance, steps=(replace(step, settings=settings),)),
    )


def test_each_page_has_its_number_dive_and_software(pdf: bytes) -> None:
    pages = pages_of(pdf)
    assert len(pages) > 3
    for number, text in enumerate(pages, start=1):
        assert f"{number} of {len(pages)}" in text
        assert number == 1 or (
            "Hull survey: plate-1" in text and f"hullrecon {__version__}" in text
        )


def test_nothing_is_lost_on_the_way_to_paper(paper: tuple[dict[str, object], bytes]) -> None:
    context, pdf = paper
    pages = pages_of(pdf)
    text = re.sub(r"\s+", "", "".join(pages))
    for name, entry in FILES.items():
        assert name in text
        assert entry.sha256 in text
    for k in range(OPTIONS):
        assert f"adjust.option_{k}{k * 1.5}" in text
    for card in context["cards"]:  # type: ignore[attr-defined]
        for name, value in card["rows"]:
            assert re.sub(r"\s+", "", name + value) in text, name
    for line in context["lines"]:  # type: ignore[attr-defined]
        assert re.sub(r"\s+", "", line) in text
    _check_rows(re.sub(r"\s+", " ", " ".join(pages)))


def _check_rows(text: str) -> None:
    """Every object has its row in the list and in the annex."""
    listed, annex = (
        text.split("Objects, 4 in all")[1],
        text.split("Annex: the numbers of all objects")[-1],
    )
    for k in range(1, MANY + 1):
        assert re.search(rf"\b{k} protrusion {0.05 + 0.001 * (k - 1):.3f} ±", listed), k
        assert re.search(rf"\b{k} frame {k}, port", annex), k


def test_many_objects_have_a_photo_line_and_their_numbers(
    survey: Survey, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hullrecon.report.render.MAX_CARDS", 3)
    context = context_of(crowded(survey))
    reader = PdfReader(io.BytesIO(render_pdf(context)))
    text = re.sub(r"\s+", "", "".join(page.extract_text() for page in reader.pages))
    for card in context["cards"]:  # type: ignore[attr-defined]
        height = dict(card["rows"])["Height above the hull around it"]
        assert f"{card['id']}·Protrusion,{height}".replace(" ", "") in text
    annex = text.split("Annex:thenumbersofallobjects")[-1]
    for card in context["cards"]:  # type: ignore[attr-defined]
        for _, value in card["rows"]:
            assert value.replace(" ", "") in annex
    assert sum(len(page.images) for page in reader.pages) >= MANY


def test_a_heading_never_ends_a_page(survey: Survey) -> None:
    import weasyprint

    from hullrecon.report.render import _fetch

    html = render_html(context_of(survey, plots=True))
    for page in weasyprint.HTML(string=html, url_fetcher=_fetch, base_url="font:").render().pages:
        lines = [
            (box.position_y, box.element_tag)
            for box in page._page_box.descendants()
            if getattr(box, "text", "").strip() and page.height - 75 > box.position_y > 70
        ]
        if lines:
            assert max(lines)[1] not in ("h1", "h2", "h3", "caption")


def test_the_same_context_gives_the_same_bytes(bare: Survey) -> None:
    context = context_of(bare)
    assert render_pdf(context) == render_pdf(context)


def test_a_bare_dive_has_its_reasons_on_paper(bare: Survey) -> None:
    text = " ".join(" ".join(pages_of(render_pdf(context_of(bare)))).split())
    assert "Objects were not looked for: no camera was carried." in text
    assert "Deviation from the CAD model" not in text


def test_names_in_foreign_letters_are_readable_and_no_markup(bare: Survey) -> None:
    dive = Dive(name="bare", vessel="Αθήνα & <b>Łódź</b>")
    survey = replace(bare, facts=replace(bare.facts, dive=dive))
    assert "Αθήνα & <b>Łódź</b>" in pages_of(render_pdf(context_of(survey)))[0]


def test_the_document_is_tagged_titled_and_has_bookmarks(pdf: bytes, survey: Survey) -> None:
    reader = PdfReader(io.BytesIO(pdf))
    assert reader.metadata is not None
    assert reader.metadata.title == "Hull survey: plate-1"
    assert reader.metadata.creation_date is None
    assert reader.trailer["/Root"]["/MarkInfo"]["/Marked"]  # type: ignore[index]
    assert any(str(entry.title).startswith("1 ") for entry in _flat(reader.outline))  # type: ignore[attr-defined]
    html = render_html(context_of(survey))
    assert (
        html.count("<svg")
        == len(re.findall(r"<svg[^>]*>(?:<style>[^<]*</style>)?<title>[^<]+</title>", html))
        > 0
    )
    assert html.count("<img") == len(re.findall(r'<img[^>]* alt="[^"]+"', html))


def _flat(outline: list[object]) -> list[object]:
    return [
        entry for item in outline for entry in (_flat(item) if isinstance(item, list) else [item])
    ]


def test_nothing_is_fetched_from_disk_or_network(survey: Survey) -> None:
    from hullrecon.report.render import _fetch

    for url in (
        "file:///etc/passwd",
        "https://example.com/logo.png",
        "font:../../../../etc/passwd",
    ):
        with pytest.raises((ValueError, FileNotFoundError)):
            _fetch(url)


def test_a_missing_library_is_a_reason_and_prints_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """WeasyPrint prints its advice on standard output, which carries results."""
    from hullrecon.report import render

    class Finder:
        @staticmethod
        def find_spec(name: str, path: object = None, target: object = None) -> None:
            if name == "weasyprint":
                print("could not import some external libraries")
                raise OSError("cannot load library 'libpango-1.0-0'")

    monkeypatch.delitem(sys.modules, "weasyprint", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Finder, *sys.meta_path])
    assert "libpango-1.0-0" in (render.why_no_pdf() or "")
    assert capsys.readouterr().out == ""


def test_the_inspection_stands_on_the_first_page(pdf: bytes) -> None:
    reader = PdfReader(io.BytesIO(pdf))
    text = " ".join(reader.pages[0].extract_text().split())
    for words in (
        "Client Harbour Authority & Sons",
        "Inspected by Divers <Ltd>",
        "ROV with DVL; stereo rig",
        "visibility 3 m",
        "Conclusion of the inspector",
        "Nothing that hinders service.",
        "Clean the intake.",
    ):
        assert words in text


def test_times_of_a_run_are_not_on_paper(survey: Survey) -> None:
    html = render_html(context_of(survey))
    assert "7.5 s" not in html
    assert "Quality of the data" in html


def test_a_dive_without_objects_has_no_annex(survey: Survey) -> None:
    empty = replace(survey, findings=replace(survey.findings, objects=()))
    html = render_html(context_of(empty))
    assert "Annex" not in html
    assert "No object was found." in html
