# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write RUNS/index.html: every dive, its state, what stands out, and the way to its report. A
static page, written whole.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from urllib.parse import quote

from hullrecon.api.fleet.findings import DiveFindings, read_findings
from hullrecon.api.fleet.outcome import FleetDive
from hullrecon.api.fleet.text import as_utf8, one_line
from hullrecon.artifacts.disk import write_file
from hullrecon.artifacts.workspace import PUBLISHED

FILE = "index.html"
REPORT = Path(PUBLISHED) / "report" / "index.html"
_WORDS = {
    "failed": "failed",
    "running": "running",
    "stale": "out of date",
    "waiting": "not run yet",
    "done": "done",
}


@dataclass(frozen=True, kw_only=True)
class IndexRow:
    """One dive in the table. kind: what the state is, for its colour; link: relative address of its
    report.
    """

    name: str
    kind: str
    state: str
    reason: str = ""
    about: str = ""
    findings: tuple[str, ...] = ()
    largest_m: float = 0.0
    link: str = ""
    link_text: str = "report"


class FleetIndex:
    """The page of one folder of runs. Results are read once, and again when their dive has ended."""

    def __init__(self, runs: Path) -> None:
        self._runs = runs
        self._known: dict[str, DiveFindings | None] = {}

    def forget(self, name: str | None) -> None:
        """Read the result of a dive again, which has ended."""
        self._known.pop(name or "", None)

    def exists(self) -> bool:
        """Return whether the page, or a dive of its name, is there."""
        return (self._runs / FILE).exists()

    def write(self, dives: Iterable[FleetDive], running: Collection[Path] = ()) -> None:
        """Write the page, durably and in one step. running: packages of the dives that are at work
        now.
        """
        dives = list(dives)
        rows = [self._row(dive, dive.package in running) for dive in dives]
        rows += self._others({dive.name for dive in dives})
        rows.sort(key=lambda row: (list(_WORDS).index(row.kind), -row.largest_m, row.name))
        if not (self._runs / FILE).is_dir():  # a dive may be called so
            write_file(self._runs / FILE, render_index(rows).encode())

    def _row(self, dive: FleetDive, running: bool) -> IndexRow:
        kind, state, current = _state(dive, running)
        name = dive.name or dive.package.name
        return self._with_result(
            name,
            kind,
            state,
            one_line(as_utf8(dive.reason)) if kind != "done" else "",
            current,
            dive.name,
        )

    def _others(self, names: Collection[str | None]) -> list[IndexRow]:
        """Return the runs that lie here and are none of this fleet's."""
        there = sorted(
            path.name for path in self._runs.iterdir()
            if path.name not in names and not path.name.startswith(".") and path.is_dir()
        )  # fmt: skip
        rows = [
            self._with_result(name, "done", "done, not of this fleet", "", True, name)
            for name in there
        ]
        return [row for row in rows if row.link]

    def _with_result(
        self, shown: str, kind: str, state: str, reason: str, current: bool, name: str | None
    ) -> IndexRow:
        found = None
        if name is not None:
            if name not in self._known:
                self._known[name] = read_findings(self._runs / name / PUBLISHED)
            found = self._known[name]
        has_report = name is not None and (self._runs / name / REPORT).is_file()
        shown_findings = (
            found
            if found is not None and current
            else DiveFindings(about=found.about if found else "")
        )
        return IndexRow(
            name=one_line(as_utf8(shown)),
            kind=kind,
            state=state,
            reason=reason,
            about=shown_findings.about,
            findings=shown_findings.sentences,
            largest_m=shown_findings.largest_m,
            link=f"{quote(name or '')}/{REPORT.as_posix()}" if has_report else "",
            link_text="report" if current else "report of an earlier run",
        )


def _state(dive: FleetDive, running: bool) -> tuple[str, str, bool]:
    """Return kind, words, and whether the dive's result is that of its package as it is."""
    if running:
        return "running", "running", False
    if dive.state == "failed":
        return (
            ("failed", "delivered, but for a step that failed", True)
            if dive.delivered
            else ("failed", "failed", False)
        )
    if dive.state == "to do":
        return (
            ("waiting", "not run yet", False)
            if dive.reason == "new"
            else ("stale", "out of date", False)
        )
    return "done", "done", True


def render_index(rows: Sequence[IndexRow]) -> str:
    """Return the page."""
    from jinja2 import Environment, StrictUndefined

    text = (resources.files("hullrecon.api.fleet") / "templates" / "index.html").read_text(
        encoding="utf-8"
    )
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    kinds = [(sum(row.kind == kind for row in rows), word) for kind, word in _WORDS.items()]
    counts = f"{len(rows)} dive{'s' if len(rows) != 1 else ''}: " + ", ".join(
        f"{n} {word}" for n, word in kinds if n
    )
    written = time.strftime("%d %B %Y, %H:%M UTC", time.gmtime())
    return environment.from_string(text).render(
        rows=rows, counts=counts if rows else "none", written=written
    )
