# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.processes: the environment of processes, and what stands in their way."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hullrecon.artifacts import processes
from hullrecon.artifacts.processes import one_thread_each
from hullrecon.errors import StageError


def test_the_parents_environment_is_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    before = dict(os.environ)
    with one_thread_each():
        assert os.environ["MKL_NUM_THREADS"] == "1"
    assert dict(os.environ) == before


def test_processes_start_once_tmpdir_may_be_written(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as full:
        full.setattr(processes, "_choose_folder_of_sockets", refuse)
        with pytest.raises(StageError, match=r"No space left .*: TMPDIR must name a folder"):
            processes.clean_context()
    process = processes.clean_context().Process(target=print)
    process.start()
    process.join()
    assert process.exitcode == 0


def test_processes_start_where_the_path_of_tmpdir_is_too_long_for_a_socket(tmp_path: Path) -> None:
    folder = tmp_path / ("long" * 25)
    folder.mkdir()
    start = """
from hullrecon.artifacts.processes import clean_context
process = clean_context().Process(target=print)
process.start()
process.join()
print(process.exitcode)
"""
    ended = subprocess.run(
        [sys.executable, "-c", start],
        env={**os.environ, "TMPDIR": str(folder), "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.stdout.split(), ended.stderr) == (["0"], "")
    assert list(folder.iterdir()) == []
