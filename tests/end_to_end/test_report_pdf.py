# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The demo's report.pdf holds what its page and files hold: every object, deliverable and parameter, on numbered pages."""

import json
import re

import pytest
from pypdf import PdfReader

pytestmark = pytest.mark.slow


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


def test_every_object_every_deliverable_and_every_parameter_is_on_paper(deliver, pages):
    text = joined(pages)
    summary = json.loads((deliver / "summary.json").read_text())
    for found in json.loads((deliver / "objects.json").read_text())["objects"]:
        assert text.count(joined(f"{found['id']} · ")) >= 1
        assert text.count(joined(found["address"])) >= 2  # its card and the annex
    for name, entry in summary["deliverables"].items():
        if not name.startswith("report/"):
            assert name in text
            assert entry["sha256"] in text
    page = (deliver / "report" / "index.html").read_text()
    keys = re.findall(r"<tr><td>(\w+\.[\w.]+)</td>", page)
    assert len(keys) > 100
    assert [key for key in keys if key not in text] == []


def test_sentences_and_pictures_are_there_and_no_code_shows(deliver, pages):
    text = joined(pages)
    summary = json.loads((deliver / "summary.json").read_text())
    assert [line for line in summary["summary"] if joined(line) not in text] == []
    assert not re.search(r"\('|None|\{\{|<svg|&lt;|nan\b", " ".join(pages))
    pictures = sum(len(page.images) for page in PdfReader(deliver / "report" / "report.pdf").pages)
    assert pictures >= 10  # ship, map, photos, deviation, mosaics, plots


def test_the_paper_is_light_enough_to_be_mailed(deliver):
    assert (deliver / "report" / "report.pdf").stat().st_size < 10_000_000
