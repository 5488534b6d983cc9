# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The demo's report.pdf holds what its page and files hold: every object, deliverable and
parameter, on numbered pages, and no number besides, so that what test_claims.py holds true of the
page is true of the paper.
"""

import json
import re

import pytest
from end_to_end.statements import statements
from pypdf import PdfReader

pytestmark = pytest.mark.slow

# numbers of lines, pages and objects, and what stands in the block and at the foot of each page
ON_PAPER_ALONE = (
    r"Vessel [^\n]*\n",
    r"Date \d\d \w+ \d{4}, \d\d:\d\d UTC",
    r"hullrecon \d+\.\d+\.\d+",
    r"(?m)^\d+\. *$",
    r"(?m)^\d\d?$",
    r"\d+ (?:·|protrusion\b|recess\b)",
    r"Objects, \d+ in all",
    r"< 0\.0001 \d+",
)
# what can be done there only, the run's times, which differ between equal runs, and numbers of
# sections
ON_THE_PAGE_ALONE = (
    r"\d+ of \d+ shown",
    r"objects of section \d+",
    r"^Object \d+ in an image of",
    r"this report's own not counted",
    r"^[\d,]+ (?:s|MB|min \d+ s)$",
    r"^\d+ [A-Z][A-Za-z -]+$",
)


@pytest.fixture(scope="module")
def deliver(demo_run):
    return demo_run / "deliver"


@pytest.fixture(scope="module")
def pages(deliver):
    return [page.extract_text() for page in PdfReader(deliver / "report" / "report.pdf").pages]


def joined(texts):
    return re.sub(r"\s+", "", "".join(texts))


def test_pages_are_numbered(pages):
    assert len(pages) > 5
    assert [k for k, text in enumerate(pages, start=1) if f"{k} of {len(pages)}" not in text] == []


def test_pdf_names_all_objects_deliverables_and_parameters(deliver, pages):
    text = joined(pages)
    summary = json.loads((deliver / "summary.json").read_text())
    for found in json.loads((deliver / "objects.json").read_text())["objects"]:
        assert text.count(joined(f"{found['id']} · ")) >= 1
        assert text.count(joined(found["address"])) >= 2  # its card and the annex
    for name, entry in summary["deliverables"].items():
        # the tileset stands for its tiles, of which there are thousands on a large hull
        if not name.startswith("report/") and not re.match(r"tiles/\w+/\d+/", name):
            assert name in text
            assert entry["sha256"] in text
    page = (deliver / "report" / "index.html").read_text()
    keys = re.findall(r"<tr><td>([\w-]+\.[\w.]+)</td>", page)
    assert {"dvl.mount", "adjust.max_iterations", "mosaic-optical.resolution_m"} <= set(keys)
    assert [key for key in keys if key not in text] == []


def test_sentences_and_pictures_are_there_and_no_code_shows(deliver, pages):
    text = joined(pages)
    summary = json.loads((deliver / "summary.json").read_text())
    assert [line for line in summary["summary"] if joined(line) not in text] == []
    assert not re.search(r"\('|None|\{\{|<svg|&lt;|nan\b", " ".join(pages))
    pictures = sum(len(page.images) for page in PdfReader(deliver / "report" / "report.pdf").pages)
    assert pictures >= 10  # ship, map, photos, deviation, mosaics, plots


def parts(said):
    """A statement of the page, its cells and their sentences, where they hold a number."""
    cells = said.words.split(" | ")
    sentences = [part for cell in cells for part in re.split(r"(?<=[.;:]) ", cell)]
    whole = said.words.replace(" | ", " ")
    return {part for part in (whole, *cells, *sentences) if re.search(r"\d", part)}


@pytest.fixture(scope="module")
def said(deliver):
    return statements((deliver / "report" / "index.html").read_text())


def uncovered(text, known, patterns):
    """Words with a number in a text from which patterns and known parts are taken away, the longest
    first.
    """
    for pattern in patterns:
        text = re.sub(pattern, " ", text)
    for part in sorted(known, key=len, reverse=True):
        if re.search(r"[^\W\d]|[±°%<]", part):  # a bare number would cover any
            words = r"\s*".join(map(re.escape, re.sub(r"\s+", "", part)))
            text = re.sub(rf"(?<![\d.,]){words}(?!\d)", " covered ", text)
    return re.findall(r"\S*\d\S*", text)


def test_every_number_on_paper_stands_on_the_page_as_well(pages, said):
    known = set().union(*map(parts, said))
    text = "\n".join(
        re.sub(rf"\b{k} of {len(pages)}$", "", page) for k, page in enumerate(pages, start=1)
    )
    titles = [
        match[1] for s in said if (match := re.fullmatch(r"\d+ (\D+)", s.words)) and not s.section
    ]
    for k, title in enumerate(titles, start=1):
        # in the contents, with its page
        number = re.search(rf"{k}\s+{title}[\s.]{{10,}}(\d+)", text)
        assert f"{k} {title}" in re.sub(r"\s+", " ", pages[int(number[1]) - 1])
        text = text.replace(number[0], " ")
        text = re.sub(rf"\b{k}\s+{title}", " ", text)
    shared, annex = (
        re.split(r"Deliverables\s+File\s+Bytes", text)[0],
        text.split("Annex: the numbers of all objects")[-1],
    )
    assert len(shared) > 5000
    assert uncovered(shared, known, ON_PAPER_ALONE) == []
    assert [
        words
        for words in uncovered(annex, known, ON_PAPER_ALONE)
        if not re.fullmatch(r"\d+", words)
    ] == []
    assert uncovered("The surveyed patch lies 7 mm outside it.", known, ON_PAPER_ALONE) == ["7"]


def test_what_the_page_says_in_numbers_is_on_paper_as_well(pages, said):
    text = joined(pages)
    lost = {
        part
        for found in said
        # the map's own words and the 3-D view's are the page's alone
        if found.section not in ("", "plan", "view")
        for cell in found.words.split(" | ")
        for part in re.split(r"(?<=[.;:]) ", re.sub(r"(Protrusion|Recess)(?=\w)", r"\1, ", cell))
        if re.search(r"\d", part) and joined(part) not in text
    }
    assert {
        part for part in lost if not any(re.search(pattern, part) for pattern in ON_THE_PAGE_ALONE)
    } == set()


def test_the_paper_is_light_enough_to_be_mailed(deliver):
    assert (deliver / "report" / "report.pdf").stat().st_size < 10_000_000
