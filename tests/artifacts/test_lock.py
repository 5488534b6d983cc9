# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.lock: one writer, and no lock outlives its holder."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from hullrecon.artifacts.workspace import hold_lock
from hullrecon.errors import LockedError, StorageError

HOLD = """
import sys, time
from pathlib import Path
from hullrecon.artifacts.workspace import hold_lock
with hold_lock(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def test_a_second_writer_is_refused_with_the_holders_number(tmp_path: Path) -> None:
    path = tmp_path / "dive" / ".hullrecon" / "lock"
    with (
        hold_lock(path),
        pytest.raises(LockedError, match=f"process {os.getpid()}") as caught,
        hold_lock(path),
    ):
        pytest.fail("two writers at once")
    assert caught.value.exit_code == 5
    assert caught.value.where == str(tmp_path / "dive")


def test_the_lock_is_free_after_use_and_after_an_error(tmp_path: Path) -> None:
    for _ in range(2):
        with pytest.raises(RuntimeError), hold_lock(tmp_path / "lock"):
            raise RuntimeError
    with hold_lock(tmp_path / "lock"):
        assert (tmp_path / "lock").read_text() == f"{os.getpid()}\n"


def test_a_writer_that_waits_gets_its_turn(tmp_path: Path) -> None:
    release = threading.Event()
    held = threading.Event()

    def hold() -> None:
        with hold_lock(tmp_path / "lock"):
            held.set()
            release.wait(30)

    holder = threading.Thread(target=hold)
    holder.start()
    held.wait(30)
    threading.Timer(0.3, release.set).start()
    with hold_lock(tmp_path / "lock", wait_s=30):
        assert release.is_set()
    holder.join()


def test_a_killed_holder_leaves_no_lock(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        with pytest.raises(LockedError, match=f"process {process.pid}"), hold_lock(path):
            pytest.fail("two writers at once")
        process.send_signal(signal.SIGKILL)
        process.wait()
        with hold_lock(path):
            assert path.read_text() == f"{os.getpid()}\n"


def test_a_place_without_permission_is_a_storage_error(read_only_folder: Path) -> None:
    with (
        pytest.raises(StorageError, match="cannot write"),
        hold_lock(read_only_folder / "dive" / "lock"),
    ):
        pytest.fail("locked where nothing can be written")


def test_an_error_in_a_removed_folder_is_told_as_that(tmp_path: Path) -> None:
    folder = tmp_path / "dive"

    def work() -> None:
        with hold_lock(folder / ".hullrecon" / "lock") as is_held:
            assert is_held()
            shutil.rmtree(folder)
            assert not is_held()
            (folder / "file").write_text("")

    with pytest.raises(StorageError, match="removed while it was worked on") as caught:
        work()
    assert caught.value.exit_code == 6
