# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Citations of the literature resolve to docs/references.md."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CODE = ("hullrecon", "cli", "native", "benchmarks", "tests")
CITED = re.compile(r"\[([^\[\]\n]*\b[A-Z][A-Za-z]+(?:19|20)\d\d[a-z]?\b[^\[\]\n]*)\]")
KEY = re.compile(r"\b[A-Z][A-Za-z]+(?:19|20)\d\d[a-z]?\b")
ENTRY = re.compile(r"^- \*\*\[([A-Za-z0-9]+)\]\*\* ", re.MULTILINE)
PRIVATE = re.compile(
    r"\bO (?:\d|[A-D]\.\d|ch\.|Figs?\b|Table|Alg)|\bO's\b|\((?:O|K)\b[ :]|\bK [IV]+-|\b(?:METHODS|INPUTS|OUTPUTS|HOUSE)\b"
)


def test_every_key_cited_stands_in_the_references() -> None:
    known = set(ENTRY.findall((ROOT / "docs/references.md").read_text()))
    missing = [
        f"{where}: {key}"
        for where, text in _sources()
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
    "fine", ["[Ozog2016 4.12]", "O(n) work", "K_l, the inverse", "(n, 3)", "OUTPUT"]
)
def test_other_words_are_not_taken_for_one(fine: str) -> None:
    assert not PRIVATE.search(fine)


def test_no_comment_or_message_cites_a_document_that_is_not_here() -> None:
    words = [
        (p, w)
        for p in _files(".py", "hullrecon", "cli", "benchmarks", "tests")
        for w in _comments(p)
    ]
    words += [(p, w) for p in _files(".py", "hullrecon", "cli") for w in _strings(p)]
    words += [
        (p, w)
        for s in (".h", ".cpp")
        for p in _files(s, "native")
        for w in re.findall(r"//.*", p.read_text())
    ]
    found = {
        f"{p.relative_to(ROOT)}: {line.strip()}"
        for p, w in words
        for line in w.splitlines()
        if PRIVATE.search(line)
    }
    assert not found


def _sources() -> Iterator[tuple[str, str]]:
    suffixes = {".py", ".h", ".cpp", ".md"}
    for path in sorted(
        p for folder in (*CODE, "docs") for p in (ROOT / folder).rglob("*") if p.suffix in suffixes
    ):
        if "build" not in path.parts and path != Path(__file__).resolve():
            yield str(path.relative_to(ROOT)), path.read_text()


def _files(suffix: str, *folders: str) -> list[Path]:
    paths = sorted(p for folder in folders for p in (ROOT / folder).rglob(f"*{suffix}"))
    return [p for p in paths if p != Path(__file__).resolve()]


def _strings(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def _comments(path: Path) -> Iterator[str]:
    """Comments and docstrings of a module."""
    text = path.read_text()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.string
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield ast.get_docstring(node) or ""
