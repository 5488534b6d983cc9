# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""RUNS/index.html: states, what stands out, links; nothing old looks current, and no name of a file
becomes markup.
"""

from __future__ import annotations

import json
import re
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest

from hullrecon.api.fleet.index_page import FleetIndex, IndexRow, read_findings, render_index
from hullrecon.api.fleet.outcome import FleetDive, State

OBJECTS = [
    {"id": 1, "height": 0.02, "height_sigma": 0.004, "address": "frame 3, port"},
    {"id": 2, "height": -0.11, "height_sigma": 0.01, "address": "frame 9, starboard", "more": [1]},
]


def fleet_dive(
    name: str, state: State = "up to date", reason: str = "", *, delivered: bool | None = None
) -> FleetDive:
    code = {"failed": 4, "to do": None}.get(state, 0)
    return FleetDive(
        package=Path("/dives") / name,
        name=name,
        state=state,
        exit_code=code,
        reason=reason,
        ran=False,
        known=True,
        files=(),
        log=None,
        delivered=state == "up to date" if delivered is None else delivered,
    )


def result(
    runs: Path, name: str, objects: object = OBJECTS, absent: object = None, weak: object = ()
) -> Path:
    deliver = runs / name / "deliver"
    (deliver / "report").mkdir(parents=True)
    (deliver / "report" / "index.html").write_text("report")
    summary = {
        "dive": {"vessel": "MV Kestrel", "date": "2026-05-04T09:30:00+00:00"},
        "absent": absent or {},
        "lost": [],
    }
    (deliver / "summary.json").write_text(json.dumps(summary))
    (deliver / "objects.json").write_text(json.dumps({"objects": objects}))
    (deliver / "alignment.json").write_text(json.dumps({"weak_directions": weak}))
    return deliver


class Table(HTMLParser):
    """The rows of a page as texts, and its links."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[str] = []
        self.links: list[str] = []
        self.tags: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag == "tr":
            self.rows.append("")
        self.links += [value or "" for key, value in attrs if key == "href"]

    def handle_data(self, data: str) -> None:
        if self.rows:
            self.rows[-1] += f" {data.strip()}" if data.strip() else ""


def table(runs: Path) -> Table:
    return Table((runs / "index.html").read_text())


def test_the_largest_object_stands_out_with_its_sigma_and_place(tmp_path: Path) -> None:
    found = read_findings(result(tmp_path, "a"))
    assert found is not None
    assert found.about == "MV Kestrel · 2026-05-04"
    assert found.sentences == (
        "2 objects, the largest no. 2: depth 0.110 ± 0.010 m, frame 9, starboard.",
    )
    assert found.largest_m == 0.11


def test_findings_begin_with_a_refused_cad_model(
    tmp_path: Path,
) -> None:
    reason = {"alignment.json": "the CAD model does not fit the survey and was left out"}
    weak = [
        {"kind": "position", "sigma": 0.2, "sentence": "Along is uncertain by 0.20 m."},
        {"kind": "position", "sigma": 0.5, "sentence": "Up is uncertain by 0.50 m."},
        {"kind": "position", "sigma": 0.05, "sentence": "Not worth a word."},
        {"kind": "attitude", "sigma": 9.0, "sentence": "Heading."},
    ]
    found = read_findings(result(tmp_path, "a", objects=[], absent=reason, weak=weak))
    assert found is not None
    assert found.sentences == (
        "The CAD model was refused: it does not fit the survey.",
        "No object was found.",
        "Up is uncertain by 0.50 m.",
    )


def test_index_shows_deliveries_beside_a_failed_step(tmp_path: Path) -> None:
    result(tmp_path, "a")
    FleetIndex(tmp_path).write(
        [fleet_dive("a", "failed", "no sonar mosaic: no ping meets the surface", delivered=True)]
    )
    (row,) = table(tmp_path).rows[1:]
    assert "delivered, but for a step that failed no sonar mosaic: no ping meets the surface" in row
    assert "depth 0.110" in row
    assert row.endswith(" report")


@pytest.mark.parametrize("text", ["", "{", "[]", '{"absent": 3}', "\x00"])
def test_a_damaged_summary_is_no_finding_and_ends_nothing(text: str, tmp_path: Path) -> None:
    deliver = result(tmp_path, "a")
    (deliver / "summary.json").write_text(text)
    assert read_findings(deliver) is None
    FleetIndex(tmp_path).write([fleet_dive("a")])
    assert "done" in table(tmp_path).rows[1]


def test_every_dive_has_its_state_and_failures_come_first(tmp_path: Path) -> None:
    result(tmp_path, "done")
    result(tmp_path, "late")
    dives = [
        fleet_dive("done"),
        fleet_dive("late", "to do", "the package changed"),
        fleet_dive("new", "to do", "new"),
        fleet_dive("bad", "failed", "hull.stl is missing"),
        fleet_dive("busy", "to do", "new"),
    ]
    FleetIndex(tmp_path).write(dives, {Path("/dives/busy")})
    page = table(tmp_path)
    rows = [" ".join(row.split()) for row in page.rows[1:]]
    assert [row.split()[0] for row in rows] == ["bad", "busy", "late", "new", "done"]
    assert rows[0] == "bad failed hull.stl is missing"
    assert rows[1].startswith("busy running")
    assert "out of date the package changed report of an earlier run" in rows[2]
    assert "depth 0.110" not in rows[2]  # what an earlier run found may not be so any more
    assert "not run yet" in rows[3]
    assert "depth 0.110 ± 0.010 m" in rows[4]
    assert (
        "5 dives: 1 failed, 1 running, 1 out of date, 1 not run yet, 1 done"
        in (tmp_path / "index.html").read_text()
    )


def test_dives_of_one_state_are_ordered_by_their_largest_object(tmp_path: Path) -> None:
    for name, height in (("a", 0.01), ("b", 0.3), ("c", -0.1)):
        result(tmp_path, name, objects=[{"id": 1, "height": height}])
    FleetIndex(tmp_path).write([fleet_dive(name) for name in "abc"])
    assert [row.split()[0] for row in table(tmp_path).rows[1:]] == ["b", "c", "a"]


def test_runs_that_are_not_of_this_fleet_are_listed_too(tmp_path: Path) -> None:
    result(tmp_path, "by-hand")
    (tmp_path / "no-result").mkdir()
    (tmp_path / ".fleet").mkdir()
    FleetIndex(tmp_path).write([])
    assert [row.split()[:2] for row in table(tmp_path).rows[1:]] == [["by-hand", "MV"]]
    assert "not of this fleet" in table(tmp_path).rows[1]


@pytest.mark.parametrize(
    "name", ["a b", "x<script>alert(1)</script>", "50%", "q?x#y", "Brücke", 'a"b']
)
def test_a_name_is_text_and_its_link_leads_to_its_report(name: str, tmp_path: Path) -> None:
    hostile = name.replace("/", "_")
    result(tmp_path, hostile)
    FleetIndex(tmp_path).write([fleet_dive(hostile, reason="<b>")])
    page = table(tmp_path)
    assert "script" not in page.tags
    assert [(tmp_path / unquote(link)).is_file() for link in page.links] == [True]
    assert name.split("<")[0] in page.rows[1]


def test_a_result_is_read_again_once_its_dive_has_ended(tmp_path: Path) -> None:
    index = FleetIndex(tmp_path)
    deliver = result(tmp_path, "a")
    index.write([fleet_dive("a")])
    (deliver / "objects.json").write_text(json.dumps({"objects": []}))
    index.write([fleet_dive("a")])
    assert "depth 0.110" in table(tmp_path).rows[1]
    index.forget("a")
    index.write([fleet_dive("a")])
    assert "No object was found." in table(tmp_path).rows[1]


def test_the_page_needs_no_script_and_nothing_from_outside() -> None:
    text = render_index(
        [IndexRow(name="a", kind="done", state="done", link="a/deliver/report/index.html")]
    )
    assert "<script" not in text
    assert not re.search(r"""(src|href)=["']?(https?:|//)""", unescape(text))
    assert '<html lang="en">' in text
