# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One thread for BLAS, as the commands have it: its threads wait by spinning, and a test took two
minutes instead of six seconds beside another process. Set here, before anything imports numpy, for
a pytest that is called by itself.
"""

import fcntl
import gc
import json
import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("HULLRECON_JOBS", "1")  # tests run beside each other
# Keep compiled modules whatever the caller's environment says: rewriting the assertions of the
# whole suite takes 25 s a worker, and each program that a test starts would compile hullrecon anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import pytest
from datasets import dataset
from end_to_end.shell import COARSE, SAMPLE, Shell

sys.dont_write_bytecode = False
Once = Callable[[str, Callable[[Shell], object]], Path]

# a shell's `make test &`: what the tests start would not hear Ctrl-C
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


# What is collected stays: to look for garbage among it took a tenth of the time of collection.
gc.disable()


def pytest_collection_finish() -> None:
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files that hold slow tests: the last of them would else run on one worker
    while the others have ended.
    """
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(autouse=True, scope="module")
def _earlier_files_are_no_garbage() -> None:
    """Let the garbage collector pass over what the session keeps: thousands of tests and modules,
    and what earlier files imported and made for others.

    Every step of a chain collects before it starts, and looking at these took half of the time of
    the tests that run many short chains.
    """
    gc.collect()
    gc.freeze()


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
def once(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Once:
    """Make a folder by its name, once for all workers of a session: to be read, not changed.

    Workers that ask for a folder while another one fills it wait for it.
    """
    base = tmp_path_factory.getbasetemp()
    base = base if worker_id == "master" else base.parent

    def make(name: str, fill: Callable[[Shell], object]) -> Path:
        folder = base / name
        folder.mkdir(exist_ok=True)
        with (folder / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (folder / "done").exists():
                fill(Shell(folder))
                (folder / "done").touch()
        return folder

    return make


@pytest.fixture(scope="session")
def demo_run(once: Once) -> Path:
    """The folder of a whole run over sample_data/demo, with a PDF.

    That of `make demo` where HULLRECON_DEMO_RUNS names its RUNS, as .ci/run does, which has just
    made it by the same code.
    """
    if made := os.environ.get("HULLRECON_DEMO_RUNS"):
        return Path(made) / SAMPLE.name
    run = ("run", SAMPLE, "--runs", "out", "--jobs", 2)
    return once("demo", lambda shell: Shell(shell.folder, pdf=True)(*run)) / "out/demo"


@pytest.fixture(scope="session")
def demo_figures(once: Once, demo_run: Path) -> dict[str, dict[str, float]]:
    """The demo's figures against truth, as `evaluate` prints them."""

    def fill(shell: Shell) -> None:
        said = shell("evaluate", demo_run, SAMPLE, "--json").stdout
        (shell.folder / "figures.json").write_text(said)

    return json.loads((once("demo-figures", fill) / "figures.json").read_text())


@pytest.fixture(scope="session")
def dive_a_run(once: Once) -> Path:
    """The folder of a whole run over the evaluation data's simulated dive, with coarse mosaics.

    The test is skipped where the data are not there.
    """
    package = dataset("dive-a")
    run = ("run", package, "--runs", "out", "--jobs", 2, *COARSE)
    return once("dive-a", lambda shell: shell(*run)) / "out/dive-a"
