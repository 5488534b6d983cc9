# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The words of the report's page, statement by statement, as a reader sees them."""

import re
from dataclasses import dataclass
from html.parser import HTMLParser

ENDS = {
    "p",
    "li",
    "tr",
    "h1",
    "h2",
    "h3",
    "caption",
    "figcaption",
    "div",
    "dt",
    "svg",
    "summary",
    "footer",
    "output",
    "label",
}
CELLS = {"td", "th", "text", "title", "dd", "small"}
UNSEEN = {"script", "style"}
RECORD = {"record", "appendix"}  # hashes and plots


@dataclass(frozen=True)
class Statement:
    """Words of one paragraph, item, row (cells parted by |) or drawing; section and object: where
    on the page.
    """

    words: str
    section: str
    object: int | None


class _Statements(HTMLParser):
    def __init__(self):
        super().__init__()
        self.found, self.words, self.section, self.object, self.unseen = [], [], "", None, 0

    def flush(self):
        words = re.sub(r"\s+", " ", "".join(self.words)).strip(" |")
        words = re.sub(r"( \|)+(?= \|)", "", words)
        if words and self.section not in RECORD:
            self.found.append(Statement(words, self.section, self.object))
        self.words = []

    def handle_starttag(self, tag, attrs):
        name = dict(attrs).get("id") or ""
        if tag in ENDS:
            self.flush()
        if tag == "section":
            self.section = name
        if tag in ("article", "tr") and (number := re.fullmatch(r"(?:object|row)-(\d+)", name)):
            self.object = int(number[1])
        self.unseen += tag in UNSEEN

    def handle_endtag(self, tag):
        if tag in ENDS or tag in ("article", "table"):
            self.flush()
        if tag in ("article", "table"):
            self.object = None if tag == "article" else self.object
        if tag in CELLS:
            self.words.append(" | ")
        self.unseen -= tag in UNSEEN

    def handle_data(self, data):
        if not self.unseen:
            self.words.append(data)


def statements(page):
    """All statements of a page, in their order."""
    reader = _Statements()
    reader.feed(page)
    reader.close()
    reader.flush()
    return reader.found
