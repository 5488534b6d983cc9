# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write index.html for a folder of studies: self-contained, pictures inside."""

from __future__ import annotations

import base64
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path

from hullrecon.artifacts.disk import write_file
from hullrecon.studies.catalogue import SOURCES, Part, Source
from hullrecon.studies.registry import STUDIES
from hullrecon.studies.results import KeptFigure, KeptStudy, read_results

PAGE = "index.html"
# studies that a part names without a figure of theirs: that part shows their numbers
_NAMED_WHOLE = frozenset(
    name for source in SOURCES for part in source.parts for name in part.studies if "/" not in name
)
_CODE = re.compile(r"`([^`]+)`")


@dataclass(frozen=True, kw_only=True)
class Shown:
    """What a part of a source shows of a study."""

    study: KeptStudy
    figures: Sequence[KeptFigure] = ()
    whole: bool = False  # show the study's numbers and its table too
    before: str = ""  # anchor of an earlier part that shows the study already


@dataclass(frozen=True, kw_only=True)
class Row:
    """A part of a source on the page."""

    anchor: str
    part: Part
    status: str
    shown: Sequence[Shown]
    missing: Sequence[str]  # studies that were not run in this folder


@dataclass
class _Placed:
    """Where figures and studies stand on the page, as each is shown once."""

    anchors: dict[str, str] = field(default_factory=dict)  # by id, or id/figure

    def is_first(self, name: str, anchor: str) -> bool:
        return self.anchors.setdefault(name, anchor) == anchor


def write_page(out: Path) -> Path:
    """Write the page of the sources with all that the folder holds."""
    kept = read_results(out, [study.id for study in STUDIES])
    page = out / PAGE
    write_file(page, render_page(kept, out).encode())
    return page


def render_page(kept: Mapping[str, KeptStudy], out: Path) -> str:
    """Render the sources part by part, with the results of studies and their pictures."""
    placed = _Placed()
    sources = [(source, list(_chapters(source, kept, placed))) for source in SOURCES]
    counts = Counter(row.status for _, parts in sources for _, rows in parts for row in rows)
    named = {name for source in SOURCES for part in source.parts for name in part.study_ids}
    return _render(
        {
            "sources": sources,
            "counts": dict(sorted(counts.items(), key=lambda item: -item[1])),
            "parts": counts.total(),
            "studies": list(kept.values()),
            "unplaced": [study for study in kept.values() if study.id not in named],
            "finished": sum(not study.failure for study in kept.values()),
            "seconds": sum(study.seconds for study in kept.values()),
            "known": len(STUDIES),
            "anchors": placed.anchors,
            "picture": lambda study, name: _data_uri(out / study / f"{name}.png", "image/png"),
            "film": lambda study, name: _data_uri(out / study / f"{name}.webm", "video/webm"),
            "number": show_number,
        }
    )


def _chapters(
    source: Source, kept: Mapping[str, KeptStudy], placed: _Placed
) -> Iterator[tuple[str, list[Row]]]:
    """Yield each chapter's title with its rows."""
    number = 0
    for chapter in source.chapters:
        rows = []
        for part in chapter.parts:
            number += 1
            rows.append(_row(part, f"{source.key}-{number}", kept, placed))
        yield chapter.title, rows


def _row(part: Part, anchor: str, kept: Mapping[str, KeptStudy], placed: _Placed) -> Row:
    """Make the row of a part of a source, with the studies that were run for it.

    A study or figure that an earlier row shows is linked instead.
    """
    shown = []
    for name in part.studies:
        study_id, _, figure = name.partition("/")
        study = kept.get(study_id)
        if study is None:
            continue
        if not placed.is_first(name, anchor):
            shown.append(Shown(study=study, before=placed.anchors[name]))
            continue
        whole = not figure or (study_id not in _NAMED_WHOLE and placed.is_first(study_id, anchor))
        figures = [
            f
            for f in study.figures
            if (not figure or f.name == figure)
            and (figure or placed.is_first(f"{study_id}/{f.name}", anchor))
        ]
        shown.append(Shown(study=study, figures=figures, whole=whole))
    return Row(
        anchor=anchor,
        part=part,
        status=str(part.absent or part.status),
        shown=shown,
        missing=sorted(part.study_ids - set(kept)),
    )


def show_number(value: float | None) -> str:
    """Show a number with four digits, a dash for none."""
    if value is None:
        return "–"
    return f"{value:,.0f}" if abs(value) >= 1e4 else f"{value:.4g}"


def _data_uri(file: Path, kind: str) -> str:
    """Read a picture or a film as an address that holds its bytes, "" where it is gone."""
    if not file.is_file():
        return ""
    return f"data:{kind};base64," + base64.b64encode(file.read_bytes()).decode()


def _render(variables: Mapping[str, object]) -> str:
    """Render page.html. Texts are escaped, and names in backticks become code."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined
    from markupsafe import Markup, escape

    def prose(text: str) -> Markup:
        """Set names in backticks as code."""
        return Markup(_CODE.sub(r"<code>\1</code>", str(escape(text))))

    def read(name: str) -> str:
        file = resources.files("hullrecon.studies.page") / name
        return file.read_text(encoding="utf-8")

    environment = Environment(
        loader=FunctionLoader(read),
        autoescape=lambda file: file is not None and file.endswith(".html"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["prose"] = prose
    return environment.get_template("page.html").render(variables)
