# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.executor: the same results in order, here and in worker processes; a dead worker has a
name.
"""

from __future__ import annotations

import math
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hullrecon.artifacts.executor import Executor, Processes, choose_executor
from hullrecon.artifacts.processes import THREAD_VARIABLES
from hullrecon.errors import StageError

ORPHANS = """
import os, sys, time
from hullrecon.artifacts.executor import Processes
if __name__ == "__main__":
    with Processes(2) as executor:
        print(*set(executor.map(os.getpgid, [0] * 2)), flush=True)
        import multiprocessing
        print(*[p.pid for p in multiprocessing.active_children()], flush=True)
        time.sleep(60)
"""


def test_the_executor_follows_the_options() -> None:
    assert type(choose_executor(1)) is Executor
    assert isinstance(choose_executor(2), Processes)


def test_processes_give_what_serial_gives_in_order() -> None:
    items = list(range(50))
    with Processes(2) as executor:
        assert list(executor.map(math.sqrt, items)) == list(Executor().map(math.sqrt, items))


def test_processes_are_other_processes_and_are_kept_between_maps() -> None:
    with Processes(1) as executor:
        first = set(executor.map(os.getpgid, [0, 0]))
        assert first == {os.getpgid(0)}
        pids = {executor._start_pool()._processes.keys().__iter__().__next__() for _ in range(2)}
    assert os.getpid() not in pids
    assert len(pids) == 1


def test_one_item_needs_no_process() -> None:
    executor = Processes(2)
    assert list(executor.map(os.getpid.__call__, [])) == []
    assert list(executor.map(math.sqrt, [4.0])) == [2.0]
    assert executor._pool is None


def test_a_functions_own_error_passes() -> None:
    with Processes(2) as executor, pytest.raises(ValueError, match="math domain"):
        list(executor.map(math.sqrt, [1.0, -1.0]))


def _die_once(marked: tuple[str, int]) -> int:
    """Kill this process at the first call for item 7, as a lack of memory would."""
    marker, item = marked
    if item == 7 and not os.path.exists(marker):
        Path(marker).touch()
        os._exit(9)
    return item * item


def test_work_of_a_killed_worker_is_done_again_by_fewer(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    items = [(str(tmp_path / "died"), k) for k in range(40)]
    with Processes(4) as executor:
        assert list(executor.map(_die_once, items)) == [k * k for k in range(40)]
        assert len(executor._start_pool()._processes) <= 2
    (said,) = [r.getMessage() for r in caplog.records if "killed" in r.getMessage()]
    assert re.fullmatch(
        r"a worker process was killed: from item [1-8] of 40 on, the work is done again by 2"
        r" workers",
        said,
    )


def test_work_that_kills_two_workers_is_a_stage_error_and_the_next_map_works() -> None:
    with Processes(2) as executor:
        with pytest.raises(StageError, match="killed, and again at item 1 of 2") as caught:
            list(executor.map(os._exit, [9, 9]))
        assert "memory" in caught.value.remedy
        assert list(executor.map(math.sqrt, [1.0, 4.0])) == [1.0, 2.0]


def test_worker_has_one_thread_unless_the_parent_sets_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in THREAD_VARIABLES:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    with Processes(1) as executor:
        seen = dict(zip(THREAD_VARIABLES, executor.map(os.getenv, THREAD_VARIABLES), strict=True))
    assert seen == {**dict.fromkeys(THREAD_VARIABLES, "1"), "OMP_NUM_THREADS": "3"}


def test_workers_end_when_their_parent_is_killed(tmp_path: Path) -> None:
    script = tmp_path / "orphans.py"
    script.write_text(ORPHANS)
    with subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        workers = [int(pid) for pid in process.stdout.readline().split()]
        assert workers
        process.send_signal(signal.SIGKILL)
        process.wait()
        deadline = time.monotonic() + 30
        while any(_alive(pid) for pid in workers):
            assert time.monotonic() < deadline, "a worker outlived its parent"
            time.sleep(0.05)


def _alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"
