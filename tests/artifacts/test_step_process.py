# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.step_process: a step in a process of its own leaves, says and raises what it does here,
and ends with the run.
"""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Generator, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from hullrecon.artifacts.progress import Outlook, Progress
from hullrecon.artifacts.step_call import BeginStep, begin_here
from hullrecon.artifacts.step_process import step_processes
from hullrecon.errors import InputError, StageError
from tests.artifacts import steps_to_send as steps


@pytest.fixture(scope="module")
def in_process() -> Iterator[BeginStep]:
    with step_processes(["hullrecon.artifacts.step_process"]) as call:
        yield call


def test_a_step_leaves_and_says_the_same_as_here(
    in_process: BeginStep, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    here = steps.make(steps.say_and_leave, tmp_path / "here", begin_here)
    there = steps.make(steps.say_and_leave, tmp_path / "there", in_process, jobs=2)
    said = [record.getMessage() for record in caplog.records if record.name.startswith("hullrecon")]
    assert said == 2 * ["a word", "make: a warning"]
    assert here.content_hash == there.content_hash
    assert there.run["times"] == {"rounds": [1.0]}
    assert there.run["workers_peak_rss_bytes"] > 1e6


def test_step_and_workers_are_processes_and_workers_have_a_thread(
    in_process: BeginStep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    steps.make(steps.leave_environment, tmp_path / "out", in_process, jobs=2)
    seen = json.loads((tmp_path / "out" / "seen.json").read_text())
    workers = {worker["process"] for worker in seen["workers"]}
    assert len({os.getpid(), seen["step"]["process"], *workers}) > 2
    assert seen["step"]["threads"] is None
    assert {worker["threads"] for worker in seen["workers"]} == {"1"}


def test_work_of_a_killed_worker_is_done_again(
    in_process: BeginStep, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    steps.make(partial(steps.lose_a_worker, tmp_path), tmp_path / "out", in_process, jobs=2)
    assert json.loads((tmp_path / "out" / "items.json").read_text()) == list(range(8))
    assert "the work is done again by 1 worker" in caplog.text


class Shown(Progress):
    def __init__(self) -> None:
        self.loops: list[tuple[str, int | None, int]] = []

    def track(
        self,
        items: Iterable[Any],
        label: str,
        total: int | None,
        outlook: Outlook | None = None,
        kept: int = 0,
    ) -> Generator[Any, None, None]:
        passed = 0
        try:
            for item in items:
                yield item
                passed += 1
        finally:
            self.loops.append((label, total, passed))


def test_loops_of_the_step_are_shown_by_the_run(in_process: BeginStep, tmp_path: Path) -> None:
    shown = Shown()
    steps.make(steps.go_slowly, tmp_path / "out", in_process, progress=shown)
    assert shown.loops == [("make: items", 3, 2)]  # the last item ends with its loop


def test_a_steps_own_error_comes_with_its_traceback(in_process: BeginStep, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        steps.make(steps.refuse, tmp_path / "out", in_process)
    assert caught.value.line() == "too short (a.csv): log more"
    assert "in refuse" in str(caught.value.__cause__)
    assert not (tmp_path / "building").exists()


def test_an_error_that_cannot_be_sent_comes_in_words(in_process: BeginStep, tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="OwnError: odd"):
        steps.make(steps.fail_oddly, tmp_path / "out", in_process)


@pytest.mark.parametrize(
    ("number", "said"),
    [(signal.SIGKILL, "was killed: most likely the memory"), (signal.SIGSEGV, "with SIGSEGV")],
)
def test_a_process_that_a_signal_ended_is_a_stage_error(
    number: signal.Signals, said: str, in_process: BeginStep, tmp_path: Path
) -> None:
    with pytest.raises(StageError, match=f"the process of make .*{said}"):
        steps.make(partial(steps.die, number), tmp_path / "out", in_process)
    assert not (tmp_path / "building").exists()


def test_an_interrupted_run_lets_the_step_tidy_up(in_process: BeginStep, tmp_path: Path) -> None:
    def interrupt() -> None:
        while not (tmp_path / "begun").exists():
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        steps.make(partial(steps.wait_for_interrupt, tmp_path), tmp_path / "out", in_process)
    assert (tmp_path / "tidied").exists()
    assert not (tmp_path / "building").exists()


def test_steps_that_fit_together_run_beside_each_other(
    in_process: BeginStep, tmp_path: Path
) -> None:
    one, other = (partial(steps.meet, tmp_path, *names) for names in ("ab", "ba"))
    outcomes = steps.run_two(one, other, tmp_path, in_process)
    assert [outcome.made for outcome in outcomes] == [True, True]


def test_an_error_lets_the_step_beside_it_tidy_up(in_process: BeginStep, tmp_path: Path) -> None:
    refuse = partial(steps.refuse_beside, tmp_path)
    with pytest.raises(InputError, match="too short"):
        steps.run_two(partial(steps.wait_for_interrupt, tmp_path), refuse, tmp_path, in_process)
    assert (tmp_path / "tidied").exists()
    assert not any((tmp_path / "run" / ".hullrecon" / "building").iterdir())


def test_step_and_workers_end_at_once_when_the_run_is_killed(tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, steps.__file__, str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    ) as run:
        assert run.stdout is not None
        processes = [int(word) for word in run.stdout.readline().split()]
        run.kill()
        run.wait()
    until = time.monotonic() + 30
    while any(_is_alive(process) for process in processes):
        assert time.monotonic() < until, "a process outlived its run"
        time.sleep(0.05)
    assert len(processes) > 1


def _is_alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False
