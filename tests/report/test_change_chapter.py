# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The chapter on what changed since an earlier dive, on the page and on paper."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from html import unescape

import pytest
from pypdf import PdfReader
from report.change.conftest import MOVE, T_NS, hull_change, object_change
from report_pages import page_context

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.report.change.chapter import change_chapter
from hullrecon.report.change.files import change_files
from hullrecon.report.content.headline import headline
from hullrecon.report.render import render_html, render_page, render_pdf
from hullrecon.report.survey import EarlierComparison, Survey

CHANGE = hull_change(
    [
        object_change("gone", 4, None, 33.4, 0.14, 0.001),
        object_change("new", None, 5, 31.2, 0.0, 0.09),
        object_change("grown", 1, 1, 30.6, 0.11, 0.141),
        object_change("uncertain", 6, None, 31.0, 0.03, 0.0),
        object_change("unchanged", 2, 3, 31.8, 0.12, 0.121),
    ],
    [MOVE],
)
FILES = change_files(CHANGE, OutsideMap(x_sign=-1, y_sign=1, frame="M"), T_NS)
CHAPTER = change_chapter(CHANGE)


@pytest.fixture
def compared(survey: Survey) -> Survey:
    """The survey, compared with an earlier dive called may."""
    return replace(survey, change=EarlierComparison(chapter=CHAPTER, map=FILES["change.png"]))


def words(html: str) -> str:
    """What a reader sees of a page."""
    return " ".join(
        unescape(re.sub(r"<(style|script)\b.*?</\1>|<[^>]+>", " ", html, flags=re.S)).split()
    )


def page_of(survey: Survey) -> str:
    return render_page(page_context(survey, [], {}, {}))


def chapter_of(html: str) -> str:
    (found,) = re.findall(r'<section id="change".*?</section>', html, re.S)
    return found


def test_the_change_chapter_is_numbered_titled_and_listed(
    compared: Survey,
) -> None:
    for html in (page_of(compared), render_html(page_context(compared, [], {}, {}))):
        number = re.search(r"<h2>(\d+) Change since may</h2>", chapter_of(html))
        assert number
        assert re.search(rf'<a href="#change">{number[1]}\W+Change since may</a>', unescape(html))
        numbers = [int(n) for n in re.findall(r"<h2>(\d+) ", html)]
        assert numbers == list(range(1, len(numbers) + 1))


def test_the_page_has_verdict_map_and_a_row_for_each_object(compared: Survey) -> None:
    chapter = chapter_of(page_of(compared))
    seen = words(chapter)
    assert f"{CHAPTER.verdict}." in seen
    assert (
        len(
            re.findall(
                r'<img src="data:image/png;base64,[^"]{1000,}" alt="Map of the hull from outside',
                chapter,
            )
        )
        == 1
    )
    rows = [words(row) for row in re.findall(r"<tr><th scope=\"row\">.*?</tr>", chapter)]
    assert [row.split()[0] for row in rows] == ["gone", "new", "grown", "uncertain", "unchanged"]
    assert rows[2] == "grown 1 1 frame 51, port 110 ± 3 141 ± 4 31 ± 4 < 0.0001"
    assert (
        "moved: 0.36 m² of bare hull at frame 53, port, −12 ± 3 mm along the normal "
        "(chance of none: 0.0002)" in seen
    )
    assert "dashed: bare hull that moved" in seen
    assert set(re.findall(r'href="\.\./(change/[^"]+)"', chapter)) == {
        f"change/{n}" for n in FILES if n != "change.png"
    }


def test_a_legend_names_what_the_map_has(survey: Survey) -> None:
    still = replace(
        survey,
        change=EarlierComparison(chapter=change_chapter(hull_change()), map=FILES["change.png"]),
    )
    assert "dashed" not in words(chapter_of(page_of(still)))


def test_page_and_paper_say_the_same(compared: Survey) -> None:
    context = page_context(compared, [], {}, {})
    page, paper = (words(chapter_of(html)) for html in (render_page(context), render_html(context)))
    numberless = [re.sub(r"^\d+ |change/", "", text) for text in (page, paper)]
    assert numberless[0].replace(" ,", ",").replace(" .", ".") == numberless[1]


def test_the_pdf_has_the_chapter(compared: Survey) -> None:
    reader = PdfReader(io.BytesIO(render_pdf(page_context(compared, [], {}, {}))))
    text = re.sub(r"\s+", "", "".join(page.extract_text() for page in reader.pages))
    for line in (
        "Change since may",
        CHAPTER.verdict,
        *CHAPTER.lines,
        CHAPTER.offset,
        "grown11frame51,port110±3141±431±4<0.0001",
    ):
        assert re.sub(r"\s+", "", line) in text, line


def test_a_dive_that_was_not_compared_has_no_chapter(survey: Survey) -> None:
    html = page_of(survey)
    assert 'id="change"' not in html
    assert "Change since" not in words(html)
    assert not [line for line in headline(survey) if "Change" in line]


def test_the_change_is_among_the_sentences_on_top(compared: Survey) -> None:
    (line,) = [line for line in headline(compared) if line.startswith("Change since may: ")]
    assert line == f"Change since may: {CHAPTER.outcome}."
    assert line in words(page_of(compared))


def test_the_name_of_the_earlier_dive_is_no_markup(compared: Survey) -> None:
    assert compared.change is not None
    named = replace(compared.change, chapter=replace(CHAPTER, first="<b>may"))
    assert "<b>may" not in page_of(replace(compared, change=named))


def test_the_report_says_why_there_is_no_comparison(survey: Survey) -> None:
    missing = {"change/": "no comparison with an earlier dive: this is no run"}
    without = replace(survey, provenance=replace(survey.provenance, missing=missing))
    assert "no comparison with an earlier dive: this is no run" in words(page_of(without))
