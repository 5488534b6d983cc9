# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.cluster: the same results from a Dask scheduler with a worker in another process."""

from __future__ import annotations

import math
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from hullrecon.artifacts.execution.executor import choose_executor
from hullrecon.errors import StageError, UsageError

pytest.importorskip("distributed")
PYTHON = [sys.executable, "-W", "ignore"]


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder: Path = tmp_path_factory.mktemp("dask")
    address = f"tcp://127.0.0.1:{_free_port()}"
    options = {"cwd": folder, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    host_port = address.removeprefix("tcp://")
    environment = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
    commands = [
        ["distributed.cli.dask_scheduler", "--host", host_port, "--no-dashboard"],
        ["distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"],
    ]
    running = [subprocess.Popen([*PYTHON, "-m", *command], env=environment, **options) for command in commands]
    yield address
    for process in running:
        process.kill()
        process.wait()


@pytest.mark.filterwarnings("ignore")
def test_a_cluster_gives_what_serial_gives_in_order(scheduler: str) -> None:
    with choose_executor(scheduler=scheduler) as executor:
        assert list(executor.map(math.sqrt, range(20))) == [math.sqrt(i) for i in range(20)]


@pytest.mark.filterwarnings("ignore")
def test_work_is_done_elsewhere_and_a_functions_error_passes(scheduler: str) -> None:
    with choose_executor(scheduler=scheduler) as executor:
        assert list(executor.map(os.path.exists, [f"/proc/{os.getpid()}"])) == [True]
        with pytest.raises(ValueError, match="math domain"):
            list(executor.map(math.sqrt, [1.0, -1.0]))


@pytest.mark.filterwarnings("ignore")
def test_a_killed_worker_is_a_stage_error(scheduler: str) -> None:
    with choose_executor(scheduler=scheduler) as executor, pytest.raises(StageError, match="a Dask worker was killed"):
        list(executor.map(os._exit, [9]))


@pytest.mark.filterwarnings("ignore")
def test_no_scheduler_at_the_address_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hullrecon.artifacts.execution.cluster._CONNECT_S", 0.5)
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        choose_executor(scheduler=f"tcp://127.0.0.1:{_free_port()}")
