# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The commands as functions of the package."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import hullrecon
from hullrecon.api.dive_run import package_of
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import InputError, UsageError

ROOT = Path(__file__).resolve().parents[2]
DEMO = ROOT / "sample_data" / "demo"


def test_the_functions_of_the_commands_are_found_in_the_package() -> None:
    for name in (
        "run",
        "evaluate",
        "diff",
        "export_colmap",
        "open_dive",
    ):
        assert callable(getattr(hullrecon, name))


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no_such_thing"):
        hullrecon.no_such_thing  # noqa: B018


def test_importing_the_package_loads_neither_numpy_nor_a_step() -> None:
    heavy = ("numpy", "hullrecon.api", "hullrecon.steps")
    code = f"import sys, hullrecon; print([m for m in sys.modules if m in {heavy}])"
    said = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert said.strip() == "[]"


def test_a_package_is_opened_with_the_folder_of_its_run(tmp_path: Path) -> None:
    dive = hullrecon.open_dive(DEMO, tmp_path)
    assert dive.name == "demo"
    assert dive.workspace.root == tmp_path / "demo"
    assert dive.deliver == tmp_path / "demo" / "deliver"
    assert [stage.name for stage in dive.chain.stages][:2] == ["ingest", "navigate"]


def test_options_replace_those_of_the_package(tmp_path: Path) -> None:
    dive = hullrecon.open_dive(DEMO, tmp_path, ["adjust.rounds=2"])
    assert dive.chain.sections["adjust"].rounds == 2
    with pytest.raises(UsageError):
        hullrecon.open_dive(DEMO, tmp_path, ["adjust.rounds=gevva"])


def test_a_run_that_does_not_name_its_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not say which dive package"):
        package_of(Workspace(tmp_path))


def test_a_script_without_a_main_guard_is_told_of_it(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import multiprocessing, hullrecon\n"
        "if __name__ == '__main__':\n"
        "    worker = multiprocessing.get_context('spawn').Process(target=print)\n"
        "    worker.start(); worker.join(); raise SystemExit(worker.exitcode)\n"
        f"hullrecon.run({str(DEMO)!r}, {str(tmp_path)!r})\n"
    )
    ended = subprocess.run(
        [sys.executable, script],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert ended.returncode != 0
    assert 'below `if __name__ == "__main__":`' in ended.stderr
    assert not (tmp_path / "demo").exists()


def test_a_dive_is_run_up_to_a_step_and_opened_again_by_its_run(tmp_path: Path) -> None:
    dive = hullrecon.run(DEMO, tmp_path, last_step="ingest")
    assert (dive.workspace.artifact("ingest") / "dvl.npz").exists()
    assert not dive.workspace.artifact("navigate").exists()
    assert not dive.deliver.exists()
    again = hullrecon.open_dive(dive.workspace.root)
    assert again.name == "demo"
    assert again.chain.package.resolve() == DEMO


def test_the_example_runs_scores_and_prints_the_comparison(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The chain and the solves are stood in for: they have tests of their own; this one holds the
    example to the functions.
    """
    import runpy

    from hullrecon.studies import StudyResult

    figures = {
        "trajectory": {"rigid_rmse_m": 0.002},
        "as_found": {"aligned_rmse_m": 0.004},
        "objects": {"height_error_worst_m": 0.01},
    }
    monkeypatch.setattr("hullrecon.api.dive_run.run", hullrecon.open_dive)
    monkeypatch.setattr("hullrecon.api.dive_run.evaluate", lambda run, package: figures)
    comparison = StudyResult(heads=("method",), rows=(("maxmix as published",),))
    monkeypatch.setattr("hullrecon.studies.compare_methods", lambda dive: comparison)
    example = runpy.run_path(str(ROOT / "examples" / "compare_methods.py"))
    example["main"]([str(DEMO), str(tmp_path)])
    printed = capsys.readouterr().out
    assert "path, after rigid alignment: 2.0 mm" in printed
    assert "maxmix as published" in printed
