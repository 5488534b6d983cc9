# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Citations of the literature resolve to docs/references.md."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CODE = ("hullrecon", "cli", "native", "benchmarks", "tests")
CITED = re.compile(r"\[([^\[\]\n]*\b[A-Z][A-Za-z]+(?:19|20)\d\d[a-z]?\b[^\[\]\n]*)\]")
KEY = re.compile(r"\b[A-Z][A-Za-z]+(?:19|20)\d\d[a-z]?\b")
ENTRY = re.compile(r"^- \*\*\[([A-Za-z0-9]+)\]\*\* ", re.MULTILINE)
PRIVATE = re.compile(
    r"\bO (?:\d|[A-D]\.\d|ch\.|Figs?\b|Table|Alg)|\bO's\b|\((?:O|K)\b[ :]|\bK [IV]+-"
    r"|\b(?:METHODS|INPUTS|OUTPUTS|HOUSE)(?:\.md| \d| says)"
)


def test_every_key_cited_stands_in_the_references() -> None:
    known = set(ENTRY.findall((ROOT / "docs/references.md").read_text()))
    missing = [
        f"{where}: {key}"
        for where, text in _sources(*CODE, "docs")
        for c in CITED.findall(text)
        for key in KEY.findall(c)
        if key not in known
    ]
    assert not missing


def test_a_key_stands_in_the_references_once() -> None:
    keys = ENTRY.findall((ROOT / "docs/references.md").read_text())
    assert len(keys) > 40
    assert len(keys) == len(set(keys))


@pytest.mark.parametrize(
    "old", ["(O 4.12)", "O Fig. 4.10", "METHODS 5", "(K III-B)", "as INPUTS says", "O's weighting"]
)
def test_an_old_citation_is_recognised(old: str) -> None:
    assert PRIVATE.search(old)


@pytest.mark.parametrize(
    "fine", ["[Ozog2016 4.12]", "O(n) work", "K_l, the inverse", "(n, 3)", "METHODS = ()"]
)
def test_other_words_are_not_taken_for_one(fine: str) -> None:
    assert not PRIVATE.search(fine)


def test_no_file_cites_a_document_that_is_not_here() -> None:
    found = {
        f"{where}: {cited.group()}"
        for where, text in _sources(*CODE)
        for cited in PRIVATE.finditer(text)
    }
    assert not found


def _sources(*folders: str) -> Iterator[tuple[str, str]]:
    suffixes = {".py", ".h", ".cpp", ".md"}
    for path in sorted(
        p for folder in folders for p in (ROOT / folder).rglob("*") if p.suffix in suffixes
    ):
        if "build" not in path.parts and path != Path(__file__).resolve():
            yield str(path.relative_to(ROOT)), path.read_text()
