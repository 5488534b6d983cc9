# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run commands of hullrecon in processes of their own, some at a time: what ends one leaves the
others.
"""

from __future__ import annotations

import ctypes
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Generic, TypeVar

from hullrecon.errors import StageError

Key = TypeVar("Key")
_CODE = (
    "import sys; from hullrecon.api.fleet.processes import end_with_parent; end_with_parent(int(sys.argv.pop(1)));"
    "from hullrecon_cli.start import start; start()"
)
# -P: a numpy.py in the folder where the fleet was started is not imported
PROGRAM = (sys.executable, "-P", "-c", _CODE)
_POLL_S = 0.05
_PATIENCE_S = 30.0  # to end after SIGTERM
_PR_SET_PDEATHSIG = 1
_MAX_ANSWER = 1 << 22


@dataclass(frozen=True, kw_only=True)
class Ended:
    """How a command ended. exit_code: 128 + signal where one ended it, as a shell has it, 4 where
    its time was over; reason: empty when all was well.
    """

    exit_code: int
    reason: str
    seconds: float
    timed_out: bool = False


@dataclass(frozen=True, kw_only=True)
class _Running(Generic[Key]):
    key: Key
    process: subprocess.Popen[bytes]
    output: IO[bytes]
    errors: IO[bytes]
    started: float


def run_each(
    commands: Mapping[Key, Sequence[str]],
    jobs: int,
    scratch: Path,
    time_limit_s: float = math.inf,
    on_start: Callable[[Key], None] | None = None,
) -> Generator[tuple[Key, Ended], None, None]:
    """Run hullrecon with each of these arguments, `jobs` at a time, and yield how each ended, as
    they end.

    A command that takes longer than time_limit_s is ended with SIGTERM, and so is what still runs
    when the generator is closed. scratch: folder for what the commands print. on_start: called with
    each command that was started.
    """
    waiting, running = deque(commands.items()), list[_Running[Key]]()
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                running.append(_start(*waiting.popleft(), scratch))
                if on_start is not None:
                    on_start(running[-1].key)
            ended = [r for r in running if r.process.poll() is not None]
            for r in ended:
                running.remove(r)
                yield r.key, _end_of(r)
            late = [r for r in running if time.monotonic() - r.started > time_limit_s]
            for r in late:
                end = _end_late(r, time_limit_s)
                running.remove(r)
                yield r.key, end
            if not ended and not late:
                time.sleep(_POLL_S)
    finally:
        _stop(running)


def end_with_parent(parent: int) -> None:
    """Have the kernel send SIGTERM to this process when the one that started it ends, even by
    SIGKILL.
    """
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGTERM)


def _start(key: Key, arguments: Sequence[str], scratch: Path) -> _Running[Key]:
    output = tempfile.TemporaryFile(dir=scratch)  # noqa: SIM115  closed when the command has ended
    errors = tempfile.TemporaryFile(dir=scratch)  # noqa: SIM115
    command = [*PROGRAM, str(os.getpid()), "--quiet", "--json", *arguments]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=errors)
    return _Running(
        key=key, process=process, output=output, errors=errors, started=time.monotonic()
    )


def _end_of(run: _Running[Key]) -> Ended:
    code = run.process.returncode
    with run.output, run.errors:
        reason = (
            ""
            if code == 0
            else _signal(-code)
            if code < 0
            else _message(run.output) or _last_line(run.errors)
        )
    return Ended(
        exit_code=code if code >= 0 else 128 - code,
        reason=reason,
        seconds=time.monotonic() - run.started,
    )


def _end_late(run: _Running[Key], time_limit_s: float) -> Ended:
    """End a command whose time is over, and say so; what came to its end meanwhile is taken as it
    ended.
    """
    _terminate([run])
    ended = _end_of(run)
    if ended.exit_code == 0:
        return ended
    reason = f"it took longer than {time_limit_s:g} s (--time-limit); finished steps are kept, its log says how far it came"
    return replace(ended, exit_code=StageError.exit_code, reason=reason, timed_out=True)


def _signal(number: int) -> str:
    name = signal.Signals(number).name if number in set(signal.Signals) else f"signal {number}"
    return f"ended by {name}" + (
        ": most likely the memory ran out" if number == signal.SIGKILL else ""
    )


def _message(output: IO[bytes]) -> str:
    """Return the message of the command's error document; empty where it printed none."""
    output.seek(0)
    with suppress(ValueError, LookupError, TypeError, RecursionError):
        return str(json.loads(output.read(_MAX_ANSWER))["error"]["message"])
    return ""


def _last_line(errors: IO[bytes]) -> str:
    errors.seek(max(0, errors.seek(0, os.SEEK_END) - 4096))
    lines = errors.read().decode(errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")


def _stop(running: Sequence[_Running[Key]]) -> None:
    """End processes and forget what they printed."""
    _terminate(running)
    for r in running:
        r.output.close()
        r.errors.close()


def _terminate(running: Sequence[_Running[Key]]) -> None:
    """End processes: a run that gets SIGTERM leaves what it has finished; one that does not listen
    is killed.
    """
    for r in running:
        r.process.terminate()
    until = time.monotonic() + _PATIENCE_S
    for r in running:
        try:
            r.process.wait(max(0.0, until - time.monotonic()))
        except subprocess.TimeoutExpired:
            r.process.kill()
            r.process.wait()
