# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/sources.md, every part of the sources and where it is here, from the catalogue in
hullrecon/studies/catalogue: python docs/generate_sources.py
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence, Set
from pathlib import Path

from hullrecon.studies.catalogue import SOURCES, Absence, Part, Source, Status
from hullrecon.studies.catalogue.part import Misprint, Survey

_RANGE = re.compile(r"(\(?)([A-E\d]\.(?:\d+\.)*)(\d+)(\)?) to \(?\2(\d+)\)?")
_FIGURES = re.compile(r"Figs ((?:(?:[A-E\d]+\.)?\d+(?:\(\w\))?(?!\.?\d)(?:, )?)+)")
HEAD = """# Sources

Every part of the three works that this system implements: where it is here, what reproduces it,
what differs and why. `hullrecon study run all --out FOLDER` runs the studies and sets print and
ours side by side on one page, `hullrecon study list` names them. This page is generated from the
catalogue in `hullrecon/studies/catalogue` (`python docs/generate_sources.py`), and a test holds it
to the code.

To find a part, go to its source by the first column below (sources share numbers), and search from
there for `Fig. 4.12`, also where the source prints Figure 4.12, for `Table 2.2`, `(3.13)` or
`Algorithm 5`. Every figure, table, algorithm and numbered equation is in a row; the equations of
[KimEustice2009] have no numbers, and are in the rows of their sections (`II-B`). A section is in a
row that begins with its number (`| 4.2.6`) or names it further on, else in the row of the section
that it belongs to (`4.2.6.1`: `4.2.6`); sections that only introduce, review the literature or
conclude have none.
Where several files are named, the first is the method or begins it; the others are its further
parts, and the form that it has in the product.
"""


def text() -> str:
    """Return the whole page."""
    return "\n".join([HEAD, *_counts(), *(line for source in SOURCES for line in _source(source))])


def _counts() -> Iterator[str]:
    heads = [*(status for status in Status if status is not Status.ABSENT), *Absence]
    yield from _table(
        ["source", *heads],
        (
            [f"[[{s.key}]]({_anchor(_head(s))})", *(str(count[head]) for head in heads)]
            for s, count in _counted()
        ),
    )


def _counted() -> Iterator[tuple[Source, Counter[str]]]:
    for source in SOURCES:
        yield source, Counter(str(part.absent or part.status) for part in source.parts)


def _source(source: Source) -> Iterator[str]:
    yield f"## {_head(source)}\n"
    reprinted = {survey.number for survey in source.surveys}
    for chapter in source.chapters:
        yield f"### {chapter.title}\n"
        yield from _table(
            ["part", "what it is", "printed", "here", "reproduced by", "what differs, and why"],
            (_row(part, reprinted) for part in chapter.parts),
        )
    yield "### Misprints\n"
    yield from _table(
        ["where", "print", "right", "held by"], (_misprint(slip) for slip in source.misprints)
    )
    for survey in source.surveys:
        yield from _survey(survey)


def _head(source: Source) -> str:
    return f"[{source.key}] {source.title}"


def _anchor(head: str) -> str:
    """Link to a heading of this page by the name that GitHub and mkdocs give it."""
    return "#" + re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-")


def _row(part: Part, reprinted: Set[str]) -> list[str]:
    return [
        f"[{part.number}]({_anchor(part.number)})"
        if part.number in reprinted
        else _spelled_out(part.number),
        part.what,
        part.printed,
        "<br>".join(_place(place) for place in part.code),
        "<br>".join(_shown(part)),
        part.differs,
    ]


def _spelled_out(number: str) -> str:
    """Name every number of a range and every figure, so that a search finds it: `Fig. 4.6`."""
    return _FIGURES.sub(_each_figure, _RANGE.sub(_each, number))


def _each_figure(found: re.Match[str]) -> str:
    ends = ", " if found[1].endswith(", ") else ""
    return ", ".join(f"Fig. {number}" for number in found[1].split(", ") if number) + ends


def _each(found: re.Match[str]) -> str:
    opened, chapter, first, closed, last = found.groups()
    return ", ".join(f"{opened}{chapter}{k}{closed}" for k in range(int(first), int(last) + 1))


def _shown(part: Part) -> Iterator[str]:
    if part.absent is not None:
        yield part.absent
        return
    if part.studies:
        yield "study " + ", ".join(f"`{name}`" for name in sorted(part.study_ids))
    if part.delivered:
        yield "a run: " + ", ".join(f"`{name}`" for name in part.delivered)
    yield from (_place(file) for file in part.benchmarks)
    yield from (_place(test) for test in part.tests)


def _misprint(slip: Misprint) -> list[str]:
    held = [_place(test) for test in slip.tests] + ([slip.checked] if slip.checked else [])
    return [slip.where, slip.printed, slip.right, "<br>".join(held)]


def _survey(survey: Survey) -> Iterator[str]:
    yield f"### {survey.number}\n\n{survey.about}.\n"
    ours = [f"**{cell}**" for cell in survey.ours]
    yield from _table(survey.heads, [*survey.rows, ours])


def _place(place: str) -> str:
    """Link a file, with the name in it that is meant."""
    file, _, name = place.replace("::", ":").partition(":")
    target = file if file.startswith("docs/") else f"../{file}"
    return f"[{file}]({target.removeprefix('docs/')})" + (f" `{name}`" if name else "")


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(heads)} |"
    yield "|---" * len(heads) + "|"
    for row in rows:
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |"
    yield ""


if __name__ == "__main__":
    (Path(__file__).parent / "sources.md").write_text(text(), encoding="utf-8")
