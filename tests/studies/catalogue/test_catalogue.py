# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the catalogue of the sources names is there, and every study is named by it."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from hullrecon.studies.catalogue import SOURCES, Absence, Part, Source, Status
from hullrecon.studies.registry import STUDIES

ROOT = Path(__file__).resolve().parents[3]
DELIVERED = re.findall(
    r"^\| `([^`]+)` \|", (ROOT / "docs/deliverables.md").read_text(encoding="utf-8"), re.MULTILINE
)
# figures by chapter, as the sources number them
FIGURES = {
    "Ozog2016": {"1.": 17, "2.": 23, "3.": 12, "4.": 19, "A.": 1, "B.": 2, "C.": 2, "D.": 4},
    "Aulinas2011": {"1.": 6, "2.": 10, "3.": 10, "4.": 23, "5.": 18, "A.": 1},
    "KimEustice2009": {"": 6},
}
TABLES = {
    "Ozog2016": {"1.1", "2.1", "2.2", "4.1"},
    "Aulinas2011": {"2.1", "2.2", "2.3", "2.4", "2.5", "3.1", "3.2", "3.3", "4.1", "4.2"},
}
ALGORITHMS = {"Ozog2016": 6, "Aulinas2011": 4}
# numbered equations by chapter
EQUATIONS = {
    "Ozog2016": {"1.": 5, "2.": 9, "3.": 3, "4.": 15, "B.": 1, "D.": 12},
    "Aulinas2011": {"3.": 22, "5.": 24, "A.": 6},
}
PARTS = [(source, part) for source in SOURCES for part in source.parts]
TESTS = sorted(
    {test for _, part in PARTS for test in part.tests}
    | {test for source in SOURCES for slip in source.misprints for test in slip.tests}
)


@cache
def functions(file: str) -> set[str]:
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("test", TESTS)
def test_a_test_that_is_named_is_there(test: str) -> None:
    file, _, function = test.partition("::")
    assert (ROOT / file).is_file()
    assert not function or function in functions(file)


@pytest.mark.parametrize("place", sorted({place for _, part in PARTS for place in part.code}))
def test_code_that_is_named_is_there(place: str) -> None:
    file, _, name = place.partition(":")
    text = (ROOT / file).read_text(encoding="utf-8")
    assert re.search(rf"\b{name}\b", text)


def test_files_and_benchmarks_that_are_named_are_there() -> None:
    assert {name for _, part in PARTS for name in part.delivered} <= set(DELIVERED)
    assert all((ROOT / file).is_file() for _, part in PARTS for file in part.benchmarks)


def test_every_study_stands_in_the_catalogue_and_no_other() -> None:
    named = {name for _, part in PARTS for name in part.study_ids}
    assert named == {study.id for study in STUDIES}


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.key)
def test_a_study_cites_no_figure_that_its_rows_do_not_have(source: Source) -> None:
    for study in STUDIES:
        words = [part for part in re.split(r"[;\[\]]", study.source) if source.key in part]
        rows = [part.number for part in source.parts if study.id in part.study_ids]
        cited, there = ({f for text in texts for f in figures(text)} for texts in (words, rows))
        assert cited <= there, study.id


def test_figures_that_are_named_are_drawn() -> None:
    code = "".join(path.read_text() for path in (ROOT / "hullrecon/studies").rglob("*.py"))
    named = {name.partition("/")[2] for _, part in PARTS for name in part.studies if "/" in name}
    assert [name for name in named if f'"{name}"' not in code] == []


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.key)
def test_a_part_stands_there_once(source: Source) -> None:
    numbers = [part.number for part in source.parts]
    assert sorted(set(numbers)) == sorted(numbers)


@pytest.mark.parametrize(
    "part",
    [part for _, part in PARTS if part.status is Status.ABSENT],
    ids=lambda part: part.number,
)
def test_what_is_absent_says_why(part: Part) -> None:
    assert part.absent is not None
    if part.absent in (Absence.NOT_BUILT, Absence.DATA):
        assert part.differs


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.key)
def test_every_figure_of_a_source_stands_in_the_catalogue(source: Source) -> None:
    chapters = FIGURES[source.key]
    there = {f"{chapter}{k}" for chapter, n in chapters.items() for k in range(1, n + 1)}
    assert {figure for part in source.parts for figure in figures(part.number)} == there


@pytest.mark.parametrize(("key", "chapters"), EQUATIONS.items())
def test_every_equation_of_a_source_stands_in_the_catalogue(
    key: str, chapters: dict[str, int]
) -> None:
    parts = next(source for source in SOURCES if source.key == key).parts
    there = {f"{chapter}{k}" for chapter, n in chapters.items() for k in range(1, n + 1)}
    assert there - {equation for part in parts for equation in equations(part.number)} == set()


@pytest.mark.parametrize(("source", "tables"), TABLES.items())
def test_every_table_of_a_source_stands_in_the_catalogue(source: str, tables: set[str]) -> None:
    parts = next(s for s in SOURCES if s.key == source).parts
    assert {t for part in parts for t in re.findall(r"Table (\S+?)(?:,|$)", part.number)} == tables


@pytest.mark.parametrize(("source", "count"), ALGORITHMS.items())
def test_every_algorithm_of_a_source_stands_in_the_catalogue(source: str, count: int) -> None:
    parts = next(s for s in SOURCES if s.key == source).parts
    named = {int(k) for part in parts for k in re.findall(r"Algorithm (\d)", part.number)}
    assert named == set(range(1, count + 1))


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: source.key)
def test_a_survey_has_a_row_of_ours(source: Source) -> None:
    for survey in source.surveys:
        assert {len(row) for row in (*survey.rows, survey.ours)} == {len(survey.heads)}
        assert survey.ours[0] == "hullrecon"


def figures(number: str) -> set[str]:
    """Find the figures that a part names: `Figs 1.1 to 1.6, 2.3` are seven of them."""
    found: set[str] = set()
    for text in re.findall(r"Figs?\.? ((?:(?:, | to )?[A-E]?[\d.]+(?:\([ab]\))?)+)", number):
        for item in text.split(", "):
            first, _, last = item.partition(" to ")
            chapter, _, start = first.split("(")[0].rpartition(".")
            end = last.rpartition(".")[2] or start
            found |= {f"{chapter}.{k}".lstrip(".") for k in range(int(start), int(end) + 1)}
    return found


def equations(number: str) -> set[str]:
    """Find the equations that a part names: `eqs (3.7) to (3.9), (3.11)` are four of them."""
    found: set[str] = set()
    for first, last in re.findall(r"\(([A-E\d]\.\d+)\)(?: to \(([A-E\d]\.\d+)\))?", number):
        chapter, _, start = first.rpartition(".")
        end = last.rpartition(".")[2] or start
        found |= {f"{chapter}.{k}" for k in range(int(start), int(end) + 1)}
    return found
