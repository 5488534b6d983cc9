# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""diff over runs: what is written and printed."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from hullrecon_cli.commands.results import diff as command
from report.change.conftest import T_NS, hull_change, object_change

from hullrecon.api import change as api
from hullrecon.errors import StorageError
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.steps.change import FinishedRun

BOX = np.array([[x, y, z] for x in (0.0, 10) for y in (-1.0, 1) for z in (0.0, 2)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7]], np.int32)


def finished(name: str, mesh: Mesh) -> FinishedRun:
    chart = PlaneChart(np.array([0.0, 1.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))
    found = SimpleNamespace(
        vertices=np.array([[30.0, 1, 4], [33, 1, 5], [32, 1, 6]]), support=np.ones(3)
    )
    survey = SimpleNamespace(name=name, chart=chart, as_found=found)
    return FinishedRun(survey=survey, cad_model=mesh, frame_spacing_m=0.6, last_t_ns=T_NS)


@pytest.fixture
def found() -> api.RunComparison:
    mesh = Mesh(BOX, FACES)
    change = hull_change([object_change("new", None, 5, 31.2, 0.0, 0.09)])
    return api.RunComparison(
        change=change, first=finished("may", mesh), second=finished("june", mesh)
    )


def test_the_files_are_written_and_may_be_written_again(
    found: api.RunComparison, tmp_path: Path
) -> None:
    names = api.write_change(tmp_path / "out", found)
    assert sorted(names) == sorted(p.name for p in (tmp_path / "out").iterdir())
    api.write_change(tmp_path / "out", found)


def test_a_folder_with_anything_else_in_it_is_left_alone(
    found: api.RunComparison, tmp_path: Path
) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(StorageError, match="not empty"):
        api.write_change(tmp_path, found)
    assert api.write_change(tmp_path / "new", found)


def test_the_command_prints_the_verdict_first(
    found: api.RunComparison, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(api, "diff", lambda first, second: found)
    result = CliRunner().invoke(
        command, ["may", "june", "--out", str(tmp_path / "out")], catch_exceptions=False
    )
    lines = result.stdout.splitlines()
    assert lines[0].startswith("may to june: 1 new; 7.6 m² compared")
    assert lines[1] == "new: object 5 at frame 52, port, height 90 ± 4 mm"
    assert lines[-1] == f"files: {tmp_path / 'out'}"
    assert json.loads((tmp_path / "out" / "change.json").read_text())["verdict"] == lines[0]


def test_a_notebook_has_the_same_function(
    found: api.RunComparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    import hullrecon

    monkeypatch.setattr(api, "diff", lambda first, second: found)
    assert hullrecon.diff("may", "june").change.first == "may"
