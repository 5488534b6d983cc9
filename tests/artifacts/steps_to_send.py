# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Functions of steps for test_step_process.py, which their processes import. Runs as a script as
well: steps_to_send.py OUT makes a step whose process and workers print their numbers.
"""

from __future__ import annotations

import logging
import os
import signal
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from msgspec import Struct

from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.executor import Executor, Processes
from hullrecon.artifacts.manifest import HashCache, Manifest
from hullrecon.artifacts.progress import Progress
from hullrecon.artifacts.recipe import make_job
from hullrecon.artifacts.runner import RunContext, StepOutcome, build, run_chain
from hullrecon.artifacts.stage import Context, Stage
from hullrecon.artifacts.step_call import BeginStep
from hullrecon.artifacts.step_process import step_processes
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import InputError

log = logging.getLogger("hullrecon.test")


class Options(Struct, frozen=True, kw_only=True):
    pass


def make(
    function: Callable[[Context[Any]], None],
    out: Path,
    begin_step: BeginStep,
    *,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Manifest:
    stage = Stage("make", "make", (), Options, 1, function)
    executor = Processes(jobs) if jobs > 1 else Executor()
    context = RunContext(HashCache(), executor, progress or Progress(), begin_step=begin_step)
    job = make_job(stage, {}, {}, None, context.hashes)
    return build(job, out, out.with_name("building"), context)


def square(number: int) -> int:
    return number * number


def say_and_leave(context: Context[Any]) -> None:
    log.debug("not asked for")
    log.info("a %s", "word")
    context.out.json("squares.json", context.map(square, range(50), "numbers"))
    context.warn("a warning")
    context.record_times("rounds", [1.0])


def environment_of(item: int) -> dict[str, object]:
    return {"process": os.getpid(), "threads": os.environ.get("OMP_NUM_THREADS")}


def leave_environment(context: Context[Any]) -> None:
    workers = context.map(environment_of, range(8), "items")
    context.out.json("seen.json", {"step": environment_of(0), "workers": workers})


def go_slowly(context: Context[Any]) -> None:
    for _ in context.progress(range(3), "items"):
        time.sleep(0.25)


def refuse(context: Context[Any]) -> None:
    raise InputError("too short", where="a.csv", remedy="log more")


class OwnError(Exception):
    def __init__(self, *, what: str) -> None:
        super().__init__(what)


def fail_oddly(context: Context[Any]) -> None:
    raise OwnError(what="odd")


def die(number: signal.Signals, context: Context[Any]) -> None:
    os.kill(os.getpid(), number)


def wait_for_interrupt(folder: Path, context: Context[Any]) -> None:
    (folder / "begun").touch()
    try:
        time.sleep(60)
    finally:
        (folder / "tidied").touch()


def meet(folder: Path, mine: str, other: str, context: Context[Any]) -> None:
    """Wait for the other step, for long."""
    (folder / mine).touch()
    until = time.monotonic() + 30
    while not (folder / other).exists():
        assert time.monotonic() < until, "the other step never began"
        time.sleep(0.01)


def refuse_beside(folder: Path, context: Context[Any]) -> None:
    while not (folder / "begun").exists():
        time.sleep(0.01)
    refuse(context)


def run_two(
    one: Callable[[Context[Any]], None],
    other: Callable[[Context[Any]], None],
    folder: Path,
    begin_step: BeginStep,
) -> list[StepOutcome]:
    """Run a chain of two steps, which may run beside each other."""
    stages = (
        Stage("one", "one", (), Options, 1, one),
        Stage("other", "other", (), Options, 1, other),
    )
    run_context = RunContext(
        HashCache(), Executor(), begin_step=begin_step, fit_together=lambda steps: True
    )
    (folder / "package").mkdir()
    chain = Chain(stages, {}, folder / "package")
    return run_chain(chain, Workspace(folder / "run"), run_context)


def die_once(folder: Path, item: int) -> int:
    """Kill the worker that does item 3 first, as a lack of memory would."""
    if item == 3 and not (folder / "died").exists():
        (folder / "died").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return item


def lose_a_worker(folder: Path, context: Context[Any]) -> None:
    context.out.json("items.json", context.map(partial(die_once, folder), range(8), "items"))


def process_of(item: int) -> int:
    return os.getpid()


def hold_the_interpreter(context: Context[Any]) -> None:
    workers = set(context.map(process_of, range(8), "items"))
    print(os.getpid(), *workers, flush=True)
    pow(7, 10**9)  # no other thread has a turn for minutes


if __name__ == "__main__":
    with step_processes() as in_process:
        make(hold_the_interpreter, Path(sys.argv[1]), in_process, jobs=2)
