# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A run as another dive is compared with it: what is refused."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from steps.two_dives import write_run

from hullrecon.artifacts.manifest import Manifest, Recipe, write_manifest
from hullrecon.errors import InputError
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.steps import change as change_step
from hullrecon.steps.change import FinishedRun, compare_runs, read_run
from hullrecon.steps.finished_run import HULL_SURVEY_FILES

BOX = np.array([[x, y, z] for x in (0.0, 10) for y in (-1.0, 1) for z in (0.0, 2)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7]], np.int32)


def manifests(folder: Path, **inputs: dict[str, str]) -> Path:
    """A run's folder with manifests of those steps, nothing else."""
    (folder / ".hullrecon").mkdir(parents=True)
    for name, of in inputs.items():
        (folder / name).mkdir()
        recipe = Recipe(stage=name, version=1, settings={}, inputs=of)
        write_manifest(folder / name, Manifest(recipe=recipe, key="k", outputs={}))
    return folder


def finished(name: str, mesh: Mesh) -> FinishedRun:
    survey: Any = SimpleNamespace(name=name, chart=None)
    return FinishedRun(survey=survey, cad_model=mesh, frame_spacing_m=0.6, last_t_ns=0)


def test_a_folder_that_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="this is no run"):
        read_run(tmp_path / "nothing")
    assert read_run(write_run(tmp_path / "may")).survey.name == "may"


def test_a_run_that_did_not_come_to_its_objects_is_not_finished(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not finished: it has no step surface"):
        read_run(manifests(tmp_path / "may", ingest={}, adjust={}))
    assert read_run(write_run(tmp_path / "finished")).survey.name == "finished"


def test_a_run_whose_adjustment_was_rerun_alone_is_not_finished(tmp_path: Path) -> None:
    left = manifests(
        tmp_path / "may", ingest={}, adjust={}, surface={}, detect={"adjust": "another content"}
    )
    with pytest.raises(InputError, match="adjust was rerun and detect was not"):
        read_run(left)


def test_a_damaged_step_is_named(tmp_path: Path) -> None:
    damaged = manifests(tmp_path / "may", ingest={}, adjust={})
    (damaged / "adjust" / "manifest.json").write_text("{}")
    with pytest.raises(InputError, match="the step adjust is damaged"):
        read_run(damaged)


@pytest.mark.parametrize(
    "file", ["adjust/solution.npz", "detect/objects.json", "surface/chart.npz"]
)
def test_a_damaged_file_is_named(tmp_path: Path, file: str) -> None:
    run = write_run(tmp_path / "may")
    data = bytearray((run / file).read_bytes())
    data[len(data) // 2] ^= 1
    (run / file).write_bytes(data)
    with pytest.raises(InputError, match=f"{file} is damaged"):
        read_run(run)


def test_a_file_that_is_gone_is_damage_too(tmp_path: Path) -> None:
    run = write_run(tmp_path / "may")
    (run / "detect" / "deviation.npz").unlink()
    with pytest.raises(InputError, match=r"detect/deviation\.npz is damaged"):
        read_run(run)
    shutil.rmtree(run)
    assert read_run(write_run(tmp_path / "may")).survey.name == "may"


def test_run_is_read_from_listed_files_only(tmp_path: Path) -> None:
    run = write_run(tmp_path / "may")
    for step in HULL_SURVEY_FILES:
        (run / step / "more.npz").write_bytes(b"no archive")
    found = read_run(run)
    assert (found.survey.name, len(found.survey.objects)) == ("may", 4)
    assert read_run(run / "deliver").survey.name == "may"


def test_a_run_without_a_cad_model_cannot_be_compared(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no CAD model that fits"):
        read_run(write_run(tmp_path / "may", cad_model=False))
    assert read_run(write_run(tmp_path / "june")).survey.name == "june"


def test_different_cad_models_are_refused_by_geometry() -> None:
    with pytest.raises(InputError, match=r"of different hulls: they lie up to 0\.5 m apart"):
        compare_runs(
            finished("may", Mesh(BOX, FACES)), finished("june", Mesh(BOX * [1, 1.5, 1], FACES))
        )


@pytest.mark.parametrize(("shift_m", "refused"), [(0.001, False), (0.004, True)])
def test_cad_models_of_one_hull_may_differ_by_rounding(
    shift_m: float, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(change_step, "compare_surveys", lambda *_: "compared")
    pair = (
        finished("may", Mesh(BOX, FACES)),
        finished("june", Mesh(BOX + np.array([shift_m, 0, 0]), FACES)),
    )
    if refused:
        with pytest.raises(InputError, match="different hulls"):
            compare_runs(*pair)
    else:
        assert compare_runs(*pair) == "compared"
