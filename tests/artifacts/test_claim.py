# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.claim: a run writes into folders of its own only, whatever lies in RUNS."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from types import ModuleType

import pytest

from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.manifest import HashCache
from hullrecon.artifacts.runner import RunContext, run_chain
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import StorageError, UsageError

PLACES = (
    "deliver",
    "left",
    "quarantine",
    "logs",
    "compare",
    ".old-left",
    ".hullrecon/building",
    ".hullrecon/lock",
    ".hullrecon/hashes.json",
    ".hullrecon/.tmp-hashes.json",
    "compare/geva",
    "compare/geva/.hullrecon",
)


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def victim(tmp_path: Path) -> Path:
    folder = tmp_path / "victim"
    (folder / "building").mkdir(parents=True)
    (folder / "building" / "precious.txt").write_text("precious")
    (folder / "hashes.json").write_text("{}")
    return folder


@pytest.mark.parametrize("place", PLACES)
def test_link_among_own_files_is_refused(
    place: str, toy: ModuleType, package: Path, workspace: Workspace, victim: Path
) -> None:
    toy.run(package, workspace)
    before, path = contents(victim), workspace.root / place
    if path.exists():
        path.rename(workspace.root / "aside") if path.is_dir() else path.unlink()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.symlink_to(
        victim / "hashes.json" if path.suffix == ".json" or path.name == "lock" else victim
    )
    with pytest.raises(UsageError, match="symbolic link lies among the run's own files"):
        toy.run(package, workspace, left=toy.Options(power=2))
    assert contents(victim) == before


def test_a_private_folder_that_is_a_link_is_refused(
    toy: ModuleType, package: Path, workspace: Workspace, victim: Path
) -> None:
    workspace.root.mkdir(parents=True)
    (workspace.root / ".hullrecon").symlink_to(victim)
    before = contents(victim)
    with pytest.raises(UsageError, match="symbolic link"):
        toy.run(package, workspace)
    assert contents(victim) == before


def test_a_run_folder_that_is_a_link_is_refused(
    toy: ModuleType, package: Path, workspace: Workspace, victim: Path
) -> None:
    workspace.root.parent.mkdir()
    workspace.root.symlink_to(victim)
    before = contents(victim)
    with pytest.raises(UsageError, match="the run's folder is a symbolic link"):
        toy.run(package, workspace)
    assert contents(victim) == before


def test_the_folder_of_all_runs_may_be_a_link(
    toy: ModuleType, package: Path, tmp_path: Path
) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "runs").symlink_to(tmp_path / "disk")
    toy.run(package, Workspace(tmp_path / "runs" / "dive"))
    assert (tmp_path / "disk" / "dive" / "deliver" / "total.json").exists()


def test_a_folder_of_somebody_else_is_not_adopted(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    workspace.root.mkdir(parents=True)
    (workspace.root / "thesis.tex").write_text("years of work")
    with pytest.raises(UsageError, match="not empty and holds no run"):
        toy.run(package, workspace)
    assert os.listdir(workspace.root) == ["thesis.tex"]
    assert toy.run(package, Workspace(workspace.root.parent / "other"))


def test_an_empty_folder_is_adopted(toy: ModuleType, package: Path, workspace: Workspace) -> None:
    workspace.root.mkdir(parents=True)
    assert toy.made(toy.run(package, workspace)) == ["read", "left", "right", "join"]


@pytest.mark.parametrize("inside", [".", "logs/package"])
def test_a_package_is_never_written_into(inside: str, toy: ModuleType, tmp_path: Path) -> None:
    root = tmp_path / "dive"
    (root / inside).parent.mkdir(parents=True, exist_ok=True)
    package = toy.make_package(root / inside)
    (root / ".hullrecon").mkdir()
    before = sorted(root.rglob("*"))
    with pytest.raises(UsageError, match=r"the run's folder (is|holds) the dive package"):
        toy.run(package, Workspace(root))
    assert sorted(root.rglob("*")) == before


def test_a_run_that_another_package_takes_over_is_said_to(
    toy: ModuleType, package: Path, workspace: Workspace, caplog: pytest.LogCaptureFixture
) -> None:
    toy.run(package, workspace)
    other = toy.make_package(package.parent / "other")
    assert workspace.other_package(other, ()) == package
    toy.run(other, workspace)
    said = [
        record.getMessage()
        for record in caplog.records
        if "another dive package" in record.getMessage()
    ]
    assert said == [
        f"{workspace.root} holds the results of another dive package, {package}:"
        " what differs is replaced"
    ]
    assert workspace.package == other
    assert workspace.other_package(other, ()) is None
    shutil.rmtree(other)
    assert workspace.other_package(package, ()) is None


def test_a_run_may_lie_inside_its_package(toy: ModuleType, package: Path) -> None:
    assert toy.made(toy.run(package, Workspace(package / "runs" / "dive"))) == [
        "read",
        "left",
        "right",
        "join",
    ]


def test_a_place_that_takes_no_folders_is_said(toy: ModuleType, package: Path) -> None:
    with pytest.raises(StorageError, match="cannot write"):
        toy.run(package, Workspace(Path("/proc/hullrecon/dive")))
    assert toy.run(package, Workspace(package.parent / "elsewhere" / "dive"))


def test_a_name_that_no_file_system_takes_is_said(
    toy: ModuleType, package: Path, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match="the name of the run's folder is too long"):
        run_chain(
            toy.chain(package),
            Workspace(tmp_path / ("x" * 300)),
            RunContext(HashCache(), Executor()),
        )


def test_a_lock_is_empty_when_nobody_holds_it(workspace: Workspace) -> None:
    with workspace.lock():
        assert (workspace.root / ".hullrecon" / "lock").read_text() == f"{os.getpid()}\n"
    assert (workspace.root / ".hullrecon" / "lock").read_text() == ""
