# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.workspace: artifacts in sight, damaged ones set apart, deliverables shown."""

from __future__ import annotations

import os
from pathlib import Path
from types import ModuleType

import pytest

from hullrecon.artifacts import workspace as module
from hullrecon.artifacts.documents import DamagedArtifactError
from hullrecon.artifacts.manifest import HashCache
from hullrecon.artifacts.workspace import Workspace, damaged_files


@pytest.fixture
def ran(toy: ModuleType, package: Path, workspace: Workspace) -> Workspace:
    toy.run(package, workspace)
    return workspace


def test_a_workspace_that_was_never_run_holds_nothing(workspace: Workspace) -> None:
    assert not workspace.exists()
    assert workspace.manifest("read") is None
    assert workspace.package is None


def test_a_run_remembers_its_package(ran: Workspace, package: Path) -> None:
    assert ran.exists()
    assert ran.package == package.resolve()


def test_a_folder_without_manifest_is_damaged(ran: Workspace) -> None:
    (ran.root / "read" / "manifest.json").unlink()
    with pytest.raises(DamagedArtifactError, match="manifest is missing"):
        ran.manifest("read")


def test_a_manifest_of_another_kind_is_damaged(ran: Workspace) -> None:
    (ran.root / "read" / "manifest.json").write_bytes(module.seal({"schema": 9}))
    with pytest.raises(DamagedArtifactError, match="of another kind"):
        ran.manifest("read")


def test_damage_names_each_file(ran: Workspace) -> None:
    folder, manifest = ran.artifact("left"), ran.manifest("left")
    assert manifest is not None
    assert damaged_files(folder, manifest, HashCache()) == []
    (folder / "raw.bin").write_bytes(bytes(256))
    (folder / "side.npz").write_bytes(b"short")
    (folder / "stray.txt").touch()
    assert damaged_files(folder, manifest, HashCache()) == [
        "raw.bin is altered",
        f"side.npz has 5 bytes, not {manifest.outputs['side.npz'].size}",
        "stray.txt does not belong there",
    ]
    (folder / "raw.bin").unlink()
    assert damaged_files(folder, manifest, HashCache())[0] == "raw.bin is missing"


def test_quarantine_never_overwrites(ran: Workspace, package: Path, toy: ModuleType) -> None:
    first = ran.quarantine("left")
    toy.run(package, ran)
    second = ran.quarantine("left")
    assert [first.name, second.name] == ["left-1", "left-2"]
    assert (
        (first / "raw.bin").read_bytes() == (second / "raw.bin").read_bytes() == bytes(range(256))
    )
    assert not ran.artifact("left").exists()


def test_removing_an_artifact_removes_what_it_showed(ran: Workspace) -> None:
    assert ran.remove("join")
    assert not ran.remove("join")
    assert not (ran.root / "deliver").exists()
    assert ran.artifact("left").exists()


def test_tidying_ends_what_was_half_done(ran: Workspace) -> None:
    ran.build_folder("left").mkdir(parents=True)
    os.rename(ran.root / "right", ran.root / ".old-right")
    ran.tidy(["read", "left", "right", "join"])
    assert not ran.build_folder("left").exists()
    assert ran.manifest("right") is not None
    assert not (ran.root / ".old-right").exists()
