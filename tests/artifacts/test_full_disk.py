# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A disk that is full from any one call on: one error of the right kind, nothing lost, the same
bytes when there is room.
"""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO

import pytest

from benchmarks.lasting_bytes import lasting_hashes
from hullrecon.artifacts import disk
from hullrecon.artifacts.checking import check_workspace
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import StorageError

pytestmark = pytest.mark.slow

NAMES = ("read", "left", "right", "join")
# with opening and writing files, those that take space
CALLS = ("mkdir", "copy_file_range", "pwrite")


class FullDisk:
    """Lets a number of calls that take space pass; from then on there is none."""

    def __init__(self, calls: int) -> None:
        self.left = calls

    def guard(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def guarded(*arguments: Any, **named: Any) -> Any:
            self.take()
            return function(*arguments, **named)

        return guarded

    def take(self) -> None:
        self.left -= 1
        if self.left < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def open(self, path: Path, mode: str) -> BinaryIO:
        """Open a file whose writes take space."""
        if mode == "rb":
            return open(path, "rb")
        self.take()
        return _Writing(open(path, mode, buffering=0), self)  # type: ignore[return-value]


class _Writing:
    def __init__(self, file: Any, full: FullDisk) -> None:
        self._file, self._full = file, full

    def write(self, data: bytes) -> int:
        self._full.take()
        return int(self._file.write(data))

    def __enter__(self) -> _Writing:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def _refusals(run: Callable[[], object]) -> list[str]:
    """Return what a run said that the disk refused, one line; nothing where it ended well."""
    try:
        run()
    except StorageError as error:
        return [line for line in error.line().splitlines() if "No space left on device" in line]
    return []


@pytest.mark.parametrize("before", ["nothing", "an older run"])
def test_a_disk_that_is_full_from_any_call_on_loses_nothing(
    before: str, toy: ModuleType, package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "fsync", lambda descriptor: None)
    old, expected = Workspace(tmp_path / "old"), Workspace(tmp_path / "expected")
    squared = {"left": toy.Options(power=2)}
    toy.run(package, old)
    toy.run(package, expected, **squared)
    calls, ended = 0, False
    while not ended:
        workspace = Workspace(tmp_path / f"full-{calls}")
        if before == "an older run":
            shutil.copytree(old.root, workspace.root)
        full = FullDisk(calls)
        with monkeypatch.context() as patch:
            for name in CALLS:
                patch.setattr(os, name, full.guard(getattr(os, name)))
            patch.setattr(disk, "open", full.open, raising=False)
            ended = not _refusals(lambda w=workspace: toy.run(package, w, **squared))
        damaged = [
            s
            for s in check_workspace(workspace, NAMES, read_data=True).damaged
            if not s.startswith("deliver/")
        ]
        assert damaged == []
        toy.run(package, workspace, **squared)
        assert lasting_hashes(workspace.root) == lasting_hashes(expected.root)
        calls += 1
    assert calls > 30
