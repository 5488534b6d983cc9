# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.cluster: the same results from a Dask scheduler with a worker in another process."""

from __future__ import annotations

import math
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from hullrecon.artifacts.executor import choose_executor
from hullrecon.errors import StageError, UsageError

dask = pytest.importorskip("dask")
pytest.importorskip("distributed")
PYTHON = [sys.executable, "-W", "ignore"]


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


@pytest.fixture(autouse=True)
def _wait_for_a_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a scheduler of these tests take a minute to start, beside other tests."""
    monkeypatch.setattr("hullrecon.artifacts.executor._CONNECT_S", 60)


@contextmanager
def cluster(
    folder: Path, scheme: str, **environment: str
) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """A scheduler, its process, and one worker in processes of their own."""
    address = f"{scheme}://127.0.0.1:{_free_port()}"
    environment = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"} | environment
    commands = [
        ["distributed.cli.dask_scheduler", "--host", address, "--no-dashboard"],
        ["distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"],
    ]
    quiet = subprocess.DEVNULL
    running = [
        subprocess.Popen(
            [*PYTHON, "-m", *command], env=environment, cwd=folder, stdout=quiet, stderr=quiet
        )
        for command in commands
    ]
    try:
        yield address, running[0]
    finally:
        for process in running:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with cluster(tmp_path_factory.mktemp("dask"), "tcp") as (address, _):
        yield address


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Settings of Dask for one certificate that signs itself."""
    folder: Path = tmp_path_factory.mktemp("tls")
    key, certificate = str(folder / "key.pem"), str(folder / "certificate.pem")
    options = [
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-subj",
        "/CN=test",
        "-keyout",
        key,
        "-out",
        certificate,
    ]
    subprocess.run(["openssl", "req", "-x509", *options], check=True, capture_output=True)
    parts = ("scheduler", "worker", "client")
    return {
        "distributed.comm.tls.ca-file": certificate,
        **{f"distributed.comm.tls.{part}.cert": certificate for part in parts},
        **{f"distributed.comm.tls.{part}.key": key for part in parts},
    }


@pytest.mark.filterwarnings("ignore")
def test_tls_cluster_gives_serial_results_without_warning(
    certificates: dict[str, str], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    names = {
        f"DASK_{key.replace('.', '__').replace('-', '_').upper()}": value
        for key, value in certificates.items()
    }
    with (
        cluster(tmp_path, "tls", **names) as (address, _),
        dask.config.set(certificates),
        choose_executor(scheduler=address) as executor,
    ):
        assert list(executor.map(math.sqrt, range(20))) == [math.sqrt(i) for i in range(20)]
    assert "plain TCP" not in caplog.text


@pytest.mark.filterwarnings("ignore")
def test_a_plain_cluster_is_said_to_be_one(
    scheduler: str, caplog: pytest.LogCaptureFixture
) -> None:
    with choose_executor(scheduler=scheduler):
        pass
    (said,) = [
        record.getMessage() for record in caplog.records if record.name.startswith("hullrecon")
    ]
    assert said.startswith(f"{scheduler} is plain TCP: whoever reaches its port runs programs here")


def test_a_cluster_with_tls_needs_certificates() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"tls://127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(
            UsageError,
            match=r"lacks distributed\.comm\.tls\.ca-file and distributed\.comm\.tls\.client",
        ):
            choose_executor(scheduler=address)


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
    with (
        choose_executor(scheduler=scheduler) as executor,
        pytest.raises(StageError, match="a Dask worker was killed"),
    ):
        list(executor.map(os._exit, [9]))


@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_that_vanishes_is_a_stage_error(tmp_path: Path) -> None:
    timeouts = {"distributed.comm.timeouts.connect": "1s"}
    with cluster(tmp_path, "tcp") as (address, process), dask.config.set(timeouts):
        with choose_executor(scheduler=address) as executor:
            results = executor.map(time.sleep, [0.2] * 100)
            next(results)
            process.kill()
            with pytest.raises(StageError, match="the Dask scheduler has gone") as caught:
                list(results)
        assert "what is finished is kept" in (caught.value.remedy or "")


@pytest.mark.filterwarnings("ignore")
def test_no_scheduler_at_the_address_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hullrecon.artifacts.executor._CONNECT_S", 0.5)
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        choose_executor(scheduler=f"tcp://127.0.0.1:{_free_port()}")
