# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run hullrecon's commands in separate processes, so that a crash ends one command alone."""

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
    "import sys; from hullrecon.api.fleet.processes import end_with_parent;"
    "end_with_parent(int(sys.argv.pop(1))); from hullrecon_cli.start import start; start()"
)
# -P: a numpy.py in the folder where the fleet was started is not imported
PROGRAM = (sys.executable, "-P", "-c", _CODE)
_POLL_S = 0.05  # between two looks at the running commands
_PATIENCE_S = 30.0  # that a command has to end after SIGTERM
_PR_SET_PDEATHSIG = 1
_MAX_ANSWER = 1 << 22  # bytes of a command's document that are read


@dataclass(frozen=True, kw_only=True)
class Ended:
    """How a command ended."""

    exit_code: int  # 128 + signal if a signal ended it, as in a shell, 4 if its time was over
    reason: str  # empty when all was well
    seconds: float  # that it took
    timed_out: bool = False


@dataclass(frozen=True, kw_only=True)
class _Running(Generic[Key]):
    """A process that has not ended, with the files that take what it prints."""

    key: Key
    process: subprocess.Popen[bytes]
    output: IO[bytes]
    errors: IO[bytes]
    started: float  # s, by time.monotonic


def run_each(
    commands: Mapping[Key, Sequence[str]],
    jobs: int,
    scratch: Path,
    time_limit_s: float = math.inf,
    on_start: Callable[[Key], None] | None = None,
) -> Generator[tuple[Key, Ended], None, None]:
    """Run commands of hullrecon, `jobs` at a time. Yield the key and the end of each as it ends.

    Commands that are still running when the generator is closed are ended.

    Parameters
    ----------
    commands
        Arguments of each command, by key.
    jobs
        Commands at a time.
    scratch
        Folder for temporary files with their output.
    time_limit_s
        A command that takes longer is ended.
    on_start
        Called with the key of each command that was started.
    """
    waiting, running = deque(commands.items()), list[_Running[Key]]()
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                running.append(_start(*waiting.popleft(), scratch))
                if on_start is not None:
                    on_start(running[-1].key)
            for run in running:
                if run.process.poll() is not None:
                    end = _end_of(run)
                elif time.monotonic() - run.started > time_limit_s:
                    end = _end_late(run, time_limit_s)
                else:
                    continue
                running.remove(run)
                yield run.key, end
                break
            else:
                time.sleep(_POLL_S)
    finally:
        _terminate(running)
        for run in running:
            run.output.close()
            run.errors.close()


def end_with_parent(parent: int) -> None:
    """Let the kernel end this process by SIGTERM when its parent ends, even if that was killed."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGTERM)


def _start(key: Key, arguments: Sequence[str], scratch: Path) -> _Running[Key]:
    """Start a command, with its output and errors in temporary files."""
    output = tempfile.TemporaryFile(dir=scratch)  # noqa: SIM115  closed when the command has ended
    errors = tempfile.TemporaryFile(dir=scratch)  # noqa: SIM115
    command = [*PROGRAM, str(os.getpid()), "--quiet", "--json", *arguments]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=errors)
    return _Running(
        key=key, process=process, output=output, errors=errors, started=time.monotonic()
    )


def _end_of(run: _Running[Key]) -> Ended:
    """Read how a command ended: its exit code, 128 + n for a signal n, and why it failed."""
    code, reason = run.process.returncode, ""
    with run.output, run.errors:
        if code < 0:
            known = -code in set(signal.Signals)
            name = signal.Signals(-code).name if known else f"signal {-code}"
            why = ": most likely the memory ran out" if -code == signal.SIGKILL else ""
            code, reason = 128 - code, f"ended by {name}{why}"
        elif code > 0:
            reason = _message(run.output) or _last_line(run.errors)
    return Ended(exit_code=code, reason=reason, seconds=time.monotonic() - run.started)


def _end_late(run: _Running[Key], time_limit_s: float) -> Ended:
    """End a command whose time is over, unless it has succeeded meanwhile."""
    _terminate([run])
    ended = _end_of(run)
    if ended.exit_code == 0:
        return ended
    reason = (
        f"it took longer than {time_limit_s:g} s (--time-limit); finished steps are kept,"
        " its log says how far it came"
    )
    return replace(ended, exit_code=StageError.exit_code, reason=reason, timed_out=True)


def _message(output: IO[bytes]) -> str:
    """Read the message of the command's error document. Empty if it printed none."""
    output.seek(0)
    with suppress(ValueError, LookupError, TypeError, RecursionError):
        return str(json.loads(output.read(_MAX_ANSWER))["error"]["message"])
    return ""


def _last_line(errors: IO[bytes]) -> str:
    """Read the last line that a command printed as an error."""
    errors.seek(max(0, errors.seek(0, os.SEEK_END) - 4096))
    lines = errors.read().decode(errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")


def _terminate(running: Sequence[_Running[Key]]) -> None:
    """End commands by SIGTERM, upon which finished steps are kept. After _PATIENCE_S kill them."""
    for run in running:
        run.process.terminate()
    until = time.monotonic() + _PATIENCE_S
    for run in running:
        try:
            run.process.wait(max(0.0, until - time.monotonic()))
        except subprocess.TimeoutExpired:
            run.process.kill()
            run.process.wait()
