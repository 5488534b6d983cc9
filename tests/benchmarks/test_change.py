# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from report.change.conftest import MOVE, hull_change, object_change

from benchmarks.change import score, true_changes
from hullrecon.geometry.poses import exp, identity

AT = {x: np.array([x, 4.5, 2.0]) for x in (30.0, 31.0, 32.0)}


def package(folder: Path, objects: dict[float, float]) -> Path:
    rows = [{"center": AT[x].tolist(), "height": h, "painted": False} for x, h in objects.items()]
    (folder / "truth").mkdir(parents=True)
    (folder / "truth" / "objects.json").write_text(json.dumps({"objects": rows}))
    return folder


def test_true_changes_are_those_between_two_truths(tmp_path: Path) -> None:
    truth = true_changes(
        package(tmp_path / "a", {30.0: 0.1, 31.0: 0.2}),
        package(tmp_path / "b", {30.0: 0.13, 32.0: 0.05}),
    )
    assert [(p.tolist(), h) for p, h in truth["gone"]] == [(AT[31.0].tolist(), -0.2)]
    assert [(p.tolist(), h) for p, h in truth["new"]] == [(AT[32.0].tolist(), 0.05)]
    assert truth["grown"][0][1] == pytest.approx(0.03)


def test_what_was_found_missed_and_false_is_counted() -> None:
    truth = {"new": [(AT[30.0], 0.1)], "gone": [(AT[32.0], -0.1)], "grown": []}
    found = hull_change(
        [object_change("new", None, 1, 30.05, 0, 0.1), object_change("new", None, 2, 31.0, 0, 0.1)],
        [MOVE],
    )
    figures = score(found, truth, identity())
    assert figures["found"] == 1
    assert [row["status"] for row in figures["missed"]] == ["gone"]
    assert [row["status"] for row in figures["false"]] == ["new", "surface moved"]


def test_a_change_is_looked_for_where_the_dive_reports_it() -> None:
    truth = {"new": [(AT[30.0], 0.1)], "gone": [], "grown": []}
    found = hull_change([object_change("new", None, 1, 30.6, 0, 0.1)])
    assert score(found, truth, identity())["found"] == 0
    assert score(found, truth, exp(np.array([[0.6, 0, 0, 0, 0, 0]])))["found"] == 1
