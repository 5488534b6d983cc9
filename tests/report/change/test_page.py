# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from report.change.conftest import hull_change

from hullrecon.records.change import HullChange
from hullrecon.report.change.chapter import verdict
from hullrecon.report.change.files import change_page

PNG = b"\x89PNG not really"


class Outline(HTMLParser):
    """The headings, the table's cells and what is referred to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: dict[str, list[str]] = {}
        self.links: list[str] = []
        self._in = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._in = tag
        self.links += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_data(self, data: str) -> None:
        if data.strip():
            self.found.setdefault(self._in, []).append(data.strip())


@pytest.fixture
def page(change: HullChange) -> str:
    return change_page(change, PNG)


def test_the_page_says_the_verdict_first(page: str, change: HullChange) -> None:
    assert Outline(page).found["h1"] == ["Change from may to june"]
    assert verdict(change) in page


def test_the_page_needs_no_other_file(page: str) -> None:
    links = Outline(page).links
    assert any(link.startswith("data:image/png;base64,") for link in links)
    assert [link for link in links if not link.startswith(("data:", "#"))] == []
    assert "<script" not in page


def test_each_object_has_a_row_with_its_numbers_in_both_dives(page: str) -> None:
    rows = re.findall(r"<tr><th scope=\"row\">(.*?)</tr>", page)
    assert len(rows) == 6
    assert "<strong>gone</strong>" in rows[0]
    assert (
        '<td class="number">110 ± 3</td><td class="number">141 ± 4</td>'
        '<td class="number">31 ± 4</td>' in rows[3]
    )
    assert rows[4].count("–") >= 3
    assert "<strong>" not in rows[5]


def test_bare_hull_that_moved_has_its_own_section(page: str) -> None:
    assert "0.36 m² of bare hull at frame 53, port, −12 ± 3 mm" in page


def test_without_changes_the_page_says_so() -> None:
    page = change_page(hull_change(), PNG)
    assert "Neither dive found an object." in page
    assert (
        "No stretch of bare hull was found that moved by more than the errors of both dives "
        "explain." in page
    )


def test_names_of_dives_are_no_markup() -> None:
    page = change_page(replace(hull_change(), first="<b>x</b>"), PNG)
    assert "<b>x" not in page
