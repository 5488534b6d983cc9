# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One thread for BLAS, as the commands have it: its threads wait by spinning, and a test took two
minutes instead of six seconds beside another process. Set here, before anything imports numpy, for
a pytest that is called by itself.
"""

import fcntl
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("HULLRECON_JOBS", "1")  # tests run beside each other
# Keep compiled modules whatever the caller's environment says: rewriting the assertions of the
# whole suite takes 25 s a worker, and each program that a test starts would compile hullrecon anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import pytest

sys.dont_write_bytecode = False

# a shell's `make test &`: what the tests start would not hear Ctrl-C
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files that hold slow tests: the last of them would else run on one worker
    while the others have ended.
    """
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(autouse=True)
def _signals_end_with_their_test() -> Iterator[None]:
    """Give SIGINT and SIGTERM back after a test that calls the program in this process, and forget
    those that came: the next test's steps would end as interrupted.
    """
    from hullrecon.artifacts import progress

    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
    progress._requested.clear()


@pytest.fixture(scope="session")
def demo_run(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """The folder of a whole run over sample_data/demo, made once for all workers of a session: to
    be read, not changed.
    """
    from end_to_end.shell import SAMPLE

    return _run_once(SAMPLE, tmp_path_factory, worker_id)


@pytest.fixture(scope="session")
def dive_a_run(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """The folder of a whole run over the evaluation data's simulated dive, made once for all
    workers of a session: to be read, not changed. The test is skipped where the data are not there.
    """
    from datasets import dataset

    return _run_once(dataset("dive-a"), tmp_path_factory, worker_id)


def _run_once(package: Path, tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """Run the chain over a package unless a worker of this session has; workers that ask for the
    same run wait for it.
    """
    from end_to_end.shell import Shell

    base = tmp_path_factory.getbasetemp()
    folder = (base if worker_id == "master" else base.parent) / package.name
    folder.mkdir(exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "done").exists():
            Shell(folder)("run", package, "--runs", "out", "--jobs", 2)
            (folder / "done").touch()
    return folder / "out" / package.name
