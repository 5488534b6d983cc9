# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The writer crashed at each of its calls, and killed at random times: only the old artifact or the
new one is found.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO

import pytest

from hullrecon.artifacts import disk
from hullrecon.artifacts.checking import check_workspace
from hullrecon.artifacts.disk import existing_folder
from hullrecon.artifacts.manifest import read_manifest
from hullrecon.artifacts.workspace import Workspace

pytestmark = pytest.mark.slow
NAMES = ("read", "left", "right", "join")
PAUSE_S = 0.1
CALLS = (
    "fsync",
    "replace",
    "rename",
    "link",
    "unlink",
    "rmdir",
    "mkdir",
    "truncate",
    "pwrite",
    "copy_file_range",
)


class Crash(BaseException):
    """The process has died: no handler may do anything after it."""


class Countdown:
    """Lets a number of calls that change the disk pass; the next, and all after it, do not happen.
    A write may half happen.
    """

    def __init__(self, calls: int) -> None:
        self.left = calls

    def guard(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def guarded(*arguments: Any, **named: Any) -> Any:
            self.step()
            return function(*arguments, **named)

        return guarded

    def step(self) -> None:
        self.left -= 1
        if self.left < 0:
            raise Crash

    def open(self, path: Path, mode: str) -> BinaryIO:
        """A file whose writes are counted, unbuffered so that what was written before the crash is
        on the disk.
        """
        self.step()
        file: Any = open(path, mode, buffering=0)  # noqa: SIM115
        return Half(file, self)  # type: ignore[return-value]


class Half:
    def __init__(self, file: Any, countdown: Countdown) -> None:
        self._file, self._countdown = file, countdown

    def write(self, data: bytes) -> int:
        if self._countdown.left == 0:
            self._file.write(memoryview(data).cast("B")[: len(data) // 2])
        self._countdown.step()
        return int(self._file.write(data))

    def __enter__(self) -> Half:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def contents(workspace: Workspace) -> dict[str, str]:
    """Content hash by step; fails when any is damaged. What is shown in deliver/ may still be that
    of the run before.
    """
    damaged = check_workspace(workspace, NAMES, read_data=True).damaged
    assert [sentence for sentence in damaged if not sentence.startswith("deliver/")] == []
    found = {name: read_manifest(workspace.artifact(name)) for name in NAMES}
    return {name: manifest.content_hash for name, manifest in found.items() if manifest is not None}


def snapshot(workspace: Workspace) -> dict[str, bytes]:
    """Every file that a run leaves, without what differs between equal runs."""
    files = {}
    for path in sorted(workspace.root.rglob("*")):
        if path.is_file() and ".hullrecon" not in path.parts:
            files[path.relative_to(workspace.root).as_posix()] = _lasting(path)
    return files


def _lasting(path: Path) -> bytes:
    if path.name != "manifest.json":
        return path.read_bytes()
    document = json.loads(path.read_bytes())
    del document["run"], document["seal"]
    return json.dumps(document).encode()


@pytest.mark.parametrize("can_swap", [True, False])
def test_a_crash_at_any_call_leaves_the_old_or_the_new_artifact(
    can_swap: bool, toy: ModuleType, package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # the order is tested elsewhere; here no power fails
    monkeypatch.setattr(os, "fsync", lambda descriptor: None)
    before, expected = Workspace(tmp_path / "before"), Workspace(tmp_path / "expected")
    toy.run(package, before)
    squared = {"left": toy.Options(power=2)}
    toy.run(package, expected, **squared)
    old, new, totals = contents(before), contents(expected), {12.0, 14.0 + 6.0}
    ended, calls = False, 0
    while not ended:
        workspace = Workspace(Path(shutil.copytree(before.root, tmp_path / f"crash-{calls}")))
        ended = _run_with_crash(
            calls, can_swap, lambda w=workspace: toy.run(package, w, **squared), monkeypatch
        )
        assert (
            json.loads((existing_folder(workspace.root / "deliver") / "total.json").read_text())[
                "total"
            ]
            in totals
        )
        for name, content in contents(workspace).items():
            assert content in (old[name], new[name])
        toy.run(package, workspace, **squared)
        assert snapshot(workspace) == snapshot(expected)
        calls += 1
    assert calls > 50


def _run_with_crash(
    calls: int, can_swap: bool, run: Callable[[], object], monkeypatch: pytest.MonkeyPatch
) -> bool:
    """True when the run ended before the crash came."""
    countdown = Countdown(calls)
    with monkeypatch.context() as patch:
        for name in CALLS:
            patch.setattr(os, name, countdown.guard(getattr(os, name)))
        patch.setattr(disk, "open", countdown.open, raising=False)
        patch.setattr(
            disk,
            "exchange",
            countdown.guard(disk.exchange) if can_swap else lambda first, second: False,
        )
        try:
            run()
        except Crash:
            return False
    return True


def test_a_run_killed_at_random_times_ends_with_the_same_bytes(
    toy: ModuleType, package: Path, tmp_path: Path
) -> None:
    pause = {"left": toy.Options(pause_s=PAUSE_S), "right": toy.Options(pause_s=PAUSE_S)}
    whole = Workspace(tmp_path / "whole")
    toy.run(package, whole, **pause)
    chance = random.Random(7)
    killed = 0
    for trial in range(10):
        workspace = Workspace(tmp_path / f"killed-{trial}")
        killed += _kill_while_it_runs(
            Path(toy.__file__ or ""), package, workspace, chance.uniform(0.0, 3 * PAUSE_S)
        )
        assert contents(workspace).items() <= contents(whole).items()
        toy.run(package, workspace, **pause)
        assert snapshot(workspace) == snapshot(whole)
    assert killed >= 5


def _kill_while_it_runs(script: Path, package: Path, workspace: Workspace, after_s: float) -> bool:
    """Kills the run that long after it has begun to write; False when it had ended before."""
    with subprocess.Popen(
        [sys.executable, str(script), str(package), str(workspace.root), str(PAUSE_S)]
    ) as process:
        while not workspace.root.exists() and process.poll() is None:
            time.sleep(0.001)
        time.sleep(after_s)
        process.kill()
        return process.wait() == -signal.SIGKILL
