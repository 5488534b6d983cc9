# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.checking: one flipped bit anywhere is found and named."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path
from types import ModuleType

import pytest

from hullrecon.artifacts.checking import check_workspace
from hullrecon.artifacts.workspace import Workspace

NAMES = ("read", "left", "right", "join")


@pytest.fixture
def ran(toy: ModuleType, package: Path, workspace: Workspace) -> Workspace:
    toy.run(package, workspace)
    return workspace


def flip(path: Path, bit: int) -> None:
    """Flips a bit as a failing disk does: size, time and inode stay."""
    status = path.stat()
    data = bytearray(path.read_bytes())
    data[bit // 8] ^= 1 << bit % 8
    path.write_bytes(data)
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def test_a_whole_workspace_has_no_damage(ran: Workspace) -> None:
    found = check_workspace(ran, NAMES, read_data=True)
    assert found.damaged == []
    # the package's file, deliver/ and three documents of the workspace too
    assert (found.artifacts, found.files) == (4, 12)


@pytest.mark.parametrize("trial", range(40))
def test_a_flipped_bit_in_any_file_is_found_and_named(
    trial: int, ran: Workspace, package: Path
) -> None:
    chance = random.Random(trial)
    files = [p for p in sorted(ran.root.rglob("*")) if p.is_file() and p.stat().st_size] + [
        package / "numbers.txt"
    ]
    path = files[trial % len(files)]
    bit = chance.randrange(8 * path.stat().st_size)
    flip(path, bit)
    found = check_workspace(ran, NAMES, read_data=True)
    assert len(found.damaged) == 1
    assert path.name in found.damaged[0]
    flip(path, bit)
    assert check_workspace(ran, NAMES, read_data=True).damaged == []


def test_check_without_data_finds_missing_and_resized_files(ran: Workspace) -> None:
    (ran.root / "left" / "raw.bin").unlink()
    (ran.root / "read" / "notes" / "words.txt").write_text("longer than before")
    assert check_workspace(ran, NAMES, read_data=False).damaged == [
        "read/notes/words.txt has 18 bytes, not 10", "left/raw.bin is missing",
    ]  # fmt: skip


def test_a_missing_file_of_the_package_is_found(ran: Workspace, package: Path) -> None:
    (package / "numbers.txt").unlink()
    assert check_workspace(ran, NAMES, read_data=False).damaged == []
    found = check_workspace(ran, NAMES, read_data=True).damaged
    assert found == [
        f"{package.resolve() / 'numbers.txt'} cannot be read: No such file or directory"
    ]


def test_a_deliverable_that_is_not_the_artifacts_is_found(ran: Workspace) -> None:
    (ran.root / "deliver" / "total.json").unlink()
    assert check_workspace(ran, NAMES, read_data=False).damaged == [
        "deliver/total.json is missing: `run --read-data` restores it"
    ]


def test_what_compare_left_is_checked_too(ran: Workspace) -> None:
    variant = ran.root / "compare" / "geva" / "left"
    shutil.copytree(ran.root / "left", variant)
    assert check_workspace(ran, NAMES, read_data=True).damaged == []
    flip(variant / "raw.bin", 9)
    (found,) = check_workspace(ran, NAMES, read_data=True).damaged
    assert found.startswith("compare/geva/left/raw.bin is altered: remove it")


def test_steps_that_were_never_run_are_no_damage(workspace: Workspace) -> None:
    found = check_workspace(workspace, NAMES, read_data=True)
    assert (found.artifacts, found.damaged) == (0, [])
