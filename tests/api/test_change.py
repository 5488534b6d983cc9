# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""diff over runs: what is refused, and what is written."""

from __future__ import annotations

import json
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from hullrecon_cli.commands.diff import diff as command
from report.change.conftest import T_NS, hull_change, object_change

from hullrecon.api import change as api
from hullrecon.artifacts.storage.manifest import Manifest, Recipe, write_manifest
from hullrecon.errors import InputError, StorageError
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.meshes.mesh import Mesh

BOX = np.array([[x, y, z] for x in (0.0, 10) for y in (-1.0, 1) for z in (0.0, 2)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7]], np.int32)


def run(folder: Path, **inputs: dict[str, str]) -> Path:
    """A run's folder with manifests of those steps, nothing else."""
    (folder / ".hullrecon").mkdir(parents=True)
    for name, of in inputs.items():
        (folder / name).mkdir()
        recipe = Recipe(stage=name, version=1, settings={}, inputs=of)
        write_manifest(folder / name, Manifest(recipe=recipe, key="k", outputs={}))
    return folder


def test_a_folder_that_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="this is no run"):
        api.diff(tmp_path / "nothing", tmp_path / "nothing")


def test_a_run_that_did_not_come_to_its_objects_is_not_finished(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not finished: it has no step surface"):
        api.read_run(run(tmp_path / "may", ingest={}, adjust={}))


def test_a_run_whose_adjustment_was_rerun_alone_is_not_finished(tmp_path: Path) -> None:
    stale = run(tmp_path / "may", ingest={}, adjust={}, surface={}, detect={"adjust": "another content"})
    with pytest.raises(InputError, match="adjust was rerun and detect was not"):
        api.read_run(stale)


def test_a_damaged_step_is_named(tmp_path: Path) -> None:
    damaged = run(tmp_path / "may", ingest={}, adjust={})
    (damaged / "adjust" / "manifest.json").write_text("{}")
    with pytest.raises(InputError, match="the step adjust is damaged"):
        api.read_run(damaged)


def finished(name: str, mesh: Mesh) -> api.FinishedRun:
    chart = PlaneChart(np.array([0.0, 1.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))
    found = SimpleNamespace(vertices=np.array([[30.0, 1, 4], [33, 1, 5], [32, 1, 6]]), support=np.ones(3))
    survey = SimpleNamespace(name=name, chart=chart, as_found=found)
    return api.FinishedRun(survey=survey, cad_model=mesh, frame_spacing_m=0.6, last_t_ns=T_NS)


def test_cad_models_of_different_hulls_are_refused_by_their_geometry() -> None:
    with pytest.raises(InputError, match=r"of different hulls: they lie up to 0\.5 m apart"):
        api._refuse_other_hull(finished("may", Mesh(BOX, FACES)), finished("june", Mesh(BOX * [1, 1.5, 1], FACES)))


def test_the_same_hull_meshed_otherwise_is_the_same_hull() -> None:
    """Quads split along the other diagonal, and one of them into four about its middle."""
    turned = np.array([[0, 1, 2], [1, 3, 2], [4, 6, 5], [6, 7, 5]], np.int32)
    fan = np.array([[0, 1, 8], [1, 3, 8], [3, 2, 8], [2, 0, 8], *FACES[2:]], np.int32)
    for other in (Mesh(BOX, turned), Mesh(np.vstack([BOX, BOX[:4].mean(axis=0)]), fan)):
        assert api.cad_model_gap(Mesh(BOX, FACES), other) == pytest.approx(0.0, abs=1e-6)


def test_the_gap_of_two_cad_models_is_the_same_from_both_sides() -> None:
    """A part that one of them lacks counts, although all of the other lies on it."""
    whole, half = Mesh(BOX, FACES), Mesh(BOX[:4], FACES[:2])
    assert api.cad_model_gap(whole, half) == pytest.approx(10.0)
    assert api.cad_model_gap(half, whole) == pytest.approx(10.0)


@pytest.mark.parametrize(("shift_m", "refused"), [(0.001, False), (0.004, True)])
def test_cad_models_of_one_hull_may_differ_by_rounding(shift_m: float, refused: bool) -> None:
    moved = Mesh(BOX + np.array([shift_m, 0, 0]), FACES)
    assert api.cad_model_gap(Mesh(BOX, FACES), moved) == pytest.approx(shift_m, rel=1e-3)
    with pytest.raises(InputError, match="different hulls") if refused else nullcontext():
        api._refuse_other_hull(finished("may", Mesh(BOX, FACES)), finished("june", moved))


@pytest.fixture
def found() -> api.RunComparison:
    mesh = Mesh(BOX, FACES)
    change = hull_change([object_change("new", None, 5, 31.2, 0.0, 0.09)])
    return api.RunComparison(change=change, first=finished("may", mesh), second=finished("june", mesh))


def test_the_files_are_written_and_may_be_written_again(found: api.RunComparison, tmp_path: Path) -> None:
    names = api.write_change(tmp_path / "out", found)
    assert sorted(names) == sorted(p.name for p in (tmp_path / "out").iterdir())
    api.write_change(tmp_path / "out", found)


def test_a_folder_with_anything_else_in_it_is_left_alone(found: api.RunComparison, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(StorageError, match="not empty"):
        api.write_change(tmp_path, found)


def test_the_command_prints_the_verdict_first(
    found: api.RunComparison, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(api, "diff", lambda first, second: found)
    result = CliRunner().invoke(command, ["may", "june", "--out", str(tmp_path / "out")], catch_exceptions=False)
    lines = result.stdout.splitlines()
    assert lines[0].startswith("may to june: 1 new; 7.6 m2 compared")
    assert lines[1] == "new: object 5 at frame 52, port, height 90 mm"
    assert lines[-1] == f"files: {tmp_path / 'out'}"
    assert json.loads((tmp_path / "out" / "change.json").read_text())["verdict"] == lines[0]


def test_a_notebook_has_the_same_function(found: api.RunComparison, monkeypatch: pytest.MonkeyPatch) -> None:
    import hullrecon

    monkeypatch.setattr(api, "diff", lambda first, second: found)
    assert hullrecon.diff("may", "june").change.first == "may"
