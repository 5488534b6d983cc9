# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write RUNS/index.html: every dive, its state, notable findings, and a link to its report."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TypeVar
from urllib.parse import quote

import msgspec

from hullrecon.api.fleet.outcome import FleetDive
from hullrecon.api.fleet.packages import as_utf8, one_line
from hullrecon.artifacts.disk import write_file
from hullrecon.artifacts.workspace import PUBLISHED

FILE = "index.html"
REPORT = Path(PUBLISHED) / "report" / "index.html"
REFUSED = "the CAD model does not fit"  # begins the reason of an absent alignment.json
MIN_WEAK_M = 0.1  # smallest sigma of the position that is listed
_LARGEST_BYTES = 1 << 26  # of a document that is read
Kind = TypeVar("Kind", bound=msgspec.Struct)
_WORDS = {  # words of each kind of row, in the order of the table
    "failed": "failed",
    "running": "running",
    "stale": "out of date",
    "waiting": "not run yet",
    "done": "done",
}


@dataclass(frozen=True, kw_only=True)
class IndexRow:
    """One dive in the table."""

    name: str
    kind: str  # a key of _WORDS, for order and colour
    state: str  # in words
    reason: str = ""  # why it failed or is to be run
    about: str = ""  # vessel and date
    findings: tuple[str, ...] = ()  # sentences
    largest_m: float = 0.0  # height of the largest object
    link: str = ""  # relative address of its report
    link_text: str = "report"


class FleetIndex:
    """The page of one folder of runs.

    The findings of a dive are read once, and again after the dive has ended.
    """

    def __init__(self, runs: Path) -> None:
        self._runs = runs
        self._known: dict[str, DiveFindings | None] = {}

    def forget(self, name: str | None) -> None:
        """Forget the result of a dive that has ended, so that it is read again."""
        self._known.pop(name or "", None)

    def exists(self) -> bool:
        """Test whether the page, or a dive of its name, is there."""
        return (self._runs / FILE).exists()

    def write(self, dives: Iterable[FleetDive], running: Collection[Path] = ()) -> None:
        """Write the page, durably. `running` holds the packages of the dives that run now."""
        dives = list(dives)
        rows = [self._row(dive, dive.package in running) for dive in dives]
        rows += self._others({dive.name for dive in dives})
        rows.sort(key=lambda row: (list(_WORDS).index(row.kind), -row.largest_m, row.name))
        if not (self._runs / FILE).is_dir():  # a dive may be called so
            write_file(self._runs / FILE, render_index(rows).encode())

    def _row(self, dive: FleetDive, running: bool) -> IndexRow:
        """Make the row of a dive of this fleet."""
        kind, state, current = _row_state(dive, running)
        name = dive.name or dive.package.name
        return self._make_row(
            name,
            kind,
            state,
            one_line(as_utf8(dive.reason)) if kind != "done" else "",
            current,
            dive.name,
        )

    def _others(self, names: Collection[str | None]) -> list[IndexRow]:
        """List the runs in the folder that belong to no dive of this fleet."""
        there = sorted(
            path.name for path in self._runs.iterdir()
            if path.name not in names and not path.name.startswith(".") and path.is_dir()
        )  # fmt: skip
        rows = [
            self._make_row(name, "done", "done, not of this fleet", "", True, name)
            for name in there
        ]
        return [row for row in rows if row.link]

    def _make_row(
        self, shown: str, kind: str, state: str, reason: str, current: bool, name: str | None
    ) -> IndexRow:
        """Make the row of a dive with the findings of its result.

        Parameters
        ----------
        shown
            Name in the table.
        kind, state, reason
            As in IndexRow.
        current
            Whether the result is of the present package. If not, it is linked, but its findings are
            left out.
        name
            Name of its folder in RUNS, None if unknown.
        """
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


def _row_state(dive: FleetDive, running: bool) -> tuple[str, str, bool]:
    """Choose the kind of a dive's row (a key of `_WORDS`), and word its state.

    Returns them and whether the dive's result is of the present package.
    """
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
    """Render the page, with the rows in their order and the number of dives of each kind."""
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


class _Dive(msgspec.Struct, frozen=True):
    """What the page takes of the member `dive` of summary.json."""

    vessel: str | None = None
    date: str | None = None


class _Summary(msgspec.Struct, frozen=True):
    """What the page takes of summary.json."""

    dive: _Dive = _Dive()
    absent: Mapping[str, str] = {}
    lost: tuple[str, ...] = ()


class _Object(msgspec.Struct, frozen=True):
    """What the page takes of an object of objects.json."""

    id: int
    height: float
    height_sigma: float | None = None
    address: str | None = None


class _Objects(msgspec.Struct, frozen=True):
    """What the page takes of objects.json."""

    objects: tuple[_Object, ...] = ()


class _WeakDirection(msgspec.Struct, frozen=True):
    """What the page takes of a weak direction of alignment.json."""

    kind: str = ""
    sigma: float = 0.0
    sentence: str = ""


class _Alignment(msgspec.Struct, frozen=True):
    """What the page takes of alignment.json."""

    weak_directions: tuple[_WeakDirection, ...] = ()


class DiveFindings(msgspec.Struct, frozen=True, kw_only=True):
    """The notable findings of one dive."""

    about: str = ""  # vessel and date
    sentences: tuple[str, ...] = ()  # the worst first
    largest_m: float = 0.0  # height of the largest object, 0 without objects


def read_findings(deliver: Path) -> DiveFindings | None:
    """Read the notable findings of a folder of deliverables. None without a readable summary."""
    summary = _read(deliver / "summary.json", _Summary)
    if summary is None:
        return None
    objects = _read(deliver / "objects.json", _Objects)
    alignment = _read(deliver / "alignment.json", _Alignment) or _Alignment()
    found = objects.objects if objects is not None else ()
    largest = max(found, key=lambda one: abs(one.height), default=None)
    sentences = []
    if summary.absent.get("alignment.json", "").startswith(REFUSED):
        sentences.append("The CAD model was refused: it does not fit the survey.")
    if largest is not None:
        sentences.append(_of_objects(len(found), largest))
    elif objects is not None:
        sentences.append("No object was found.")
    weak = [w for w in alignment.weak_directions if w.kind == "position" and w.sigma > MIN_WEAK_M]
    sentences += [w.sentence for w in sorted(weak, key=lambda w: -w.sigma)[:1]]
    if summary.lost:
        more = f" and {len(summary.lost) - 1} more" if summary.lost[1:] else ""
        sentences.append(f"Data were lost: {summary.lost[0]}{more}.")
    about = (summary.dive.vessel, (summary.dive.date or "")[:10])
    return DiveFindings(
        about=" · ".join(text for text in about if text),
        sentences=tuple(sentences),
        largest_m=0.0 if largest is None else abs(largest.height),
    )


def _of_objects(count: int, largest: _Object) -> str:
    """Write the sentence about the objects, with height and place of the largest."""
    sigma = "" if largest.height_sigma is None else f" ± {largest.height_sigma:.3f}"
    kind = "height" if largest.height >= 0 else "depth"
    where = f", {largest.address}" if largest.address else ""
    subject = "One object" if count == 1 else f"{count} objects, the largest no. {largest.id}"
    return f"{subject}: {kind} {abs(largest.height):.3f}{sigma} m{where}."


def _read(path: Path, kind: type[Kind]) -> Kind | None:
    """Read a JSON document. None if it is missing or cannot be read."""
    try:
        with path.open("rb") as file:
            return msgspec.json.decode(file.read(_LARGEST_BYTES), type=kind)
    except (OSError, msgspec.MsgspecError):
        return None
