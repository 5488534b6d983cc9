# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.delivery: deliver/ is copies; what others change there harms no artifact, is said, kept
and restored.
"""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path
from types import ModuleType

import pytest

from hullrecon.artifacts.checking import check_workspace
from hullrecon.artifacts.disk import copy_file
from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.runner import RunContext, StepOutcome, run_chain
from hullrecon.artifacts.workspace import Workspace

NAMES = ("read", "left", "right", "join")


@pytest.fixture
def ran(toy: ModuleType, package: Path, workspace: Workspace) -> Workspace:
    toy.run(package, workspace)
    return workspace


def flip_quietly(path: Path) -> None:
    """Flips a bit as a failing disk does: size and time stay."""
    status = path.stat()
    path.write_bytes(bytes([path.read_bytes()[0] ^ 1]) + path.read_bytes()[1:])
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def run_and_read(toy: ModuleType, package: Path, workspace: Workspace) -> list[StepOutcome]:
    return run_chain(
        toy.chain(package), workspace, RunContext(workspace.hashes(trusting=False), Executor())
    )


def test_deliverables_are_copies_at_the_workspaces_top(ran: Workspace) -> None:
    inside, shown = ran.root / "join/deliver/total.json", ran.root / "deliver/total.json"
    assert shown.read_bytes() == inside.read_bytes()
    assert not (ran.root / "deliver").is_symlink()
    assert not os.path.samefile(inside, shown)


def test_edited_deliverable_is_kept_apart_and_restored(
    toy: ModuleType, package: Path, ran: Workspace, caplog: pytest.LogCaptureFixture
) -> None:
    shown = ran.root / "deliver" / "total.json"
    whole = shown.read_bytes()
    shown.write_text("mine")
    assert toy.made(toy.run(package, ran)) == []
    assert shown.read_bytes() == whole
    assert (ran.root / "quarantine" / "deliver-1" / "total.json").read_text() == "mine"
    assert "deliver/total.json has 4 bytes, not " in caplog.text
    assert f"restored, what lay there is in {ran.root / 'quarantine' / 'deliver-1'}" in caplog.text


def test_what_others_put_into_deliver_is_kept_apart(
    toy: ModuleType, package: Path, ran: Workspace
) -> None:
    (ran.root / "deliver" / "mine.txt").write_text("notes")
    toy.run(package, ran)
    assert os.listdir(ran.root / "deliver") == ["total.json"]
    assert (ran.root / "quarantine" / "deliver-1" / "mine.txt").read_text() == "notes"


def test_an_edit_is_kept_when_a_new_result_takes_its_place(
    toy: ModuleType, package: Path, ran: Workspace
) -> None:
    (ran.root / "deliver" / "total.json").write_text("mine")
    toy.run(package, ran, left=toy.Options(power=2))
    assert "20.0" in (ran.root / "deliver" / "total.json").read_text()
    assert (ran.root / "quarantine" / "deliver-1" / "total.json").read_text() == "mine"


def test_new_result_replaces_the_old_one_silently(
    toy: ModuleType, package: Path, ran: Workspace, caplog: pytest.LogCaptureFixture
) -> None:
    toy.run(package, ran, left=toy.Options(power=2))
    assert "restored" not in caplog.text
    assert not (ran.root / "quarantine").exists()


@pytest.mark.parametrize("lost", ["total.json", "."])
def test_a_removed_deliverable_comes_back(
    lost: str, toy: ModuleType, package: Path, ran: Workspace
) -> None:
    path = ran.root / "deliver" / lost
    shutil.rmtree(path) if path.is_dir() else path.unlink()
    toy.run(package, ran)
    assert os.listdir(ran.root / "deliver") == ["total.json"]
    assert not (ran.root / "quarantine").exists()


def test_flipped_bit_in_copied_deliver_is_healed(
    toy: ModuleType, package: Path, ran: Workspace, tmp_path: Path
) -> None:
    copied = Workspace(Path(shutil.copytree(ran.root, tmp_path / "copied")))
    shown = copied.root / "deliver" / "total.json"
    run_and_read(toy, package, copied)
    flip_quietly(shown)
    found = check_workspace(copied, NAMES, read_data=True).damaged
    assert found == ["deliver/total.json is altered: `run --read-data` restores it"]
    assert toy.made(run_and_read(toy, package, copied)) == []
    assert shown.read_bytes() == (ran.root / "deliver" / "total.json").read_bytes()
    assert check_workspace(copied, NAMES, read_data=True).damaged == []


@pytest.mark.parametrize("name", ["hashes.json", "workspace.json", "deliver.json"])
def test_flipped_bit_in_own_documents_is_healed(
    name: str, toy: ModuleType, package: Path, ran: Workspace
) -> None:
    flip_quietly(ran.root / ".hullrecon" / name)
    (found,) = check_workspace(ran, NAMES, read_data=True).damaged
    assert found.startswith(f".hullrecon/{name}: ")
    assert toy.made(run_and_read(toy, package, ran)) == []
    assert check_workspace(ran, NAMES, read_data=True).damaged == []


def test_hard_links_of_an_older_version_become_copies(
    toy: ModuleType, package: Path, ran: Workspace
) -> None:
    inside, shown = ran.root / "join/deliver/total.json", ran.root / "deliver/total.json"
    shown.unlink()
    os.link(inside, shown)
    toy.run(package, ran)
    assert not os.path.samefile(inside, shown)
    assert not (ran.root / "quarantine").exists()


def test_publishing_what_is_in_place_changes_nothing(ran: Workspace) -> None:
    before = (ran.root / "deliver").stat().st_ino
    assert ran.publish("join", ran.hashes()) is None
    assert ran.publish("left", ran.hashes()) is None
    assert (ran.root / "deliver").stat().st_ino == before


def test_a_pipe_in_deliver_does_not_hold_the_run_up(
    toy: ModuleType, package: Path, ran: Workspace
) -> None:
    (ran.root / "deliver" / "total.json").unlink()
    os.mkfifo(ran.root / "deliver" / "total.json")
    toy.run(package, ran)
    assert (ran.root / "deliver" / "total.json").is_file()


@pytest.mark.parametrize("number", [errno.EXDEV, errno.ENOSYS, errno.EOPNOTSUPP])
def test_copy_falls_back_without_copy_file_range(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*arguments: int) -> int:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "copy_file_range", refuse)
    (tmp_path / "one").write_bytes(bytes(range(256)) * 1000)
    copy_file(tmp_path / "one", tmp_path / "two")
    assert (tmp_path / "two").read_bytes() == (tmp_path / "one").read_bytes()


def test_a_copy_never_writes_into_a_file_that_is_there(tmp_path: Path) -> None:
    (tmp_path / "one").write_bytes(b"one")
    (tmp_path / "victim").write_bytes(b"victim")
    (tmp_path / "two").symlink_to(tmp_path / "victim")
    with pytest.raises(FileExistsError):
        copy_file(tmp_path / "one", tmp_path / "two")
    assert (tmp_path / "victim").read_bytes() == b"victim"
