# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Call the function of a step in a process of its own, as if it were called here.

The step's process sends log records, progress and its result through a pipe to the run's process,
which shows them. The reasons are in docs/adr/0015-each-step-has-a-process-of-its-own.md.
"""

from __future__ import annotations

import logging
import math
import os
import pickle
import signal
import threading
import time
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from itertools import count, repeat
from logging.handlers import QueueHandler
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerContext
from typing import Any, TypeVar

from hullrecon.artifacts.processes import clean_context, end_with_parent, stop_server
from hullrecon.artifacts.progress import Outlook, Progress, listen
from hullrecon.artifacts.step_call import BeginStep, Made, StepCall, call_here
from hullrecon.errors import StageError

Item = TypeVar("Item")
_EVERY_S = 0.2  # between two messages about a loop's progress
_PATIENCE_S = 10.0  # that an interrupted step has to tidy up
_PIPE_BYTES = 1 << 16  # read from the pipe at a time


@dataclass(frozen=True)
class _LoopBegun:
    """A loop over items has begun."""

    number: int
    label: str
    total: int | None
    kept: int


@dataclass(frozen=True)
class _LoopGoesOn:
    """Items of a loop have passed."""

    number: int
    passed: int  # items since the last message


@dataclass(frozen=True)
class _LoopEnded:
    """A loop has ended, by itself or by an error."""

    number: int


@dataclass(frozen=True)
class _Resumed:
    """Part of the step was made by an earlier run."""


@dataclass(frozen=True)
class _Failed:
    """The step's function raised an error."""

    error: BaseException
    trace: str


class _StepError(Exception):
    """Cause of an error that shows its traceback in the process of the step."""

    def __str__(self) -> str:
        return f'\n"""\n{self.args[0]}"""'


@contextmanager
def step_processes(preload: Sequence[str] = ()) -> Iterator[BeginStep]:
    """Yield a function that starts a step in a new process. `preload`: as for `clean_context`."""
    try:
        yield partial(_StepProcess, preload)
    finally:
        stop_server()


def start_early(preload: Sequence[str]) -> None:
    """Begin the imports for the processes of steps while this process prepares the first."""
    _context(preload)


def _context(preload: Sequence[str]) -> ForkServerContext:
    return clean_context([__name__, *preload])


class _StepProcess:
    """A step in a process of its own. Its log and progress are shown by this process."""

    def __init__(
        self, preload: Sequence[str], call: StepCall, progress: Progress, outlook: Outlook
    ) -> None:
        """Start the process, which begins with the step's function at once."""
        self._step, self._patient_until = call.job.stage.name, math.inf
        self._display = _Display(progress, outlook)
        context = _context(preload)
        self._ours, theirs = context.Pipe(duplex=False)
        self._process = context.Process(
            target=_serve, args=(theirs, call, outlook.mark, _levels(), dict(os.environ))
        )
        with theirs:
            self._process.start()

    @property
    def waitables(self) -> Sequence[Connection[Any, Any] | int]:
        return [] if self._ours.closed else [self._ours, self._process.sentinel]

    def poll(self) -> Made | None:
        """Show what the step has sent so far. Returns its result once it has ended, else None.

        Raises
        ------
        StageError
            The process was killed, most likely as the memory ran out.
        Exception
            The step's own error, as `call_here` raises it.
        """
        while ready := wait(self.waitables, 0):
            if self._ours not in ready:  # the process has ended without a result
                break
            try:
                message = self._ours.recv()
            except EOFError:
                break
            if isinstance(message, Made):
                self._close(_PATIENCE_S)
                return message
            if isinstance(message, _Failed):
                self._close(_PATIENCE_S)
                raise message.error from _StepError(message.trace)
            self._display.show(message)
        else:  # all that was sent is read, and the step goes on
            return None
        self._close(_PATIENCE_S)
        raise _ended_early(self._step, self._process.exitcode or 0)

    def interrupt(self) -> None:
        """Send the step SIGINT, upon which it has _PATIENCE_S to tidy up."""
        if self._ours.closed or self._patient_until < math.inf:
            return
        self._patient_until = time.monotonic() + _PATIENCE_S
        with suppress(ProcessLookupError):
            os.kill(self._process.pid or 0, signal.SIGINT)

    def end(self) -> None:
        """Wait for the interrupted step, then kill it.

        What it sends meanwhile is read and dropped, as it would block on a full pipe.
        """
        if self._ours.closed:
            return
        try:
            while self._ours in wait(self.waitables, self._left_s()):
                if not os.read(self._ours.fileno(), _PIPE_BYTES):
                    break
            self._process.join(self._left_s())
        finally:  # also if Ctrl-C is pressed again
            self._close(0.0)

    def _left_s(self) -> float:
        return max(0.0, self._patient_until - time.monotonic())

    def _close(self, patience_s: float) -> None:
        """Wait for the process to end by itself, then kill it and close what belongs to it."""
        try:
            self._process.join(patience_s)
        finally:
            self._process.kill()  # its result has arrived, or is not wanted any more
            self._process.join()
            self._ours.close()
            self._display.close()


def _ended_early(step: str, exit_code: int) -> StageError:
    """Build the error of a step whose process ended without a result. Negative codes: a signal."""
    if exit_code == -signal.SIGKILL:
        return StageError(
            f"the process of {step} was killed",
            remedy="most likely the memory ran out: run on a machine with more, or with a smaller"
            " --jobs, what is finished is kept",
        )
    known = -exit_code in set(signal.Signals)
    how = signal.Signals(-exit_code).name if known else f"exit code {exit_code}"
    return StageError(
        f"the process of {step} ended with {how}",
        remedy="what it printed says more; what is finished is kept",
    )


class _Display:
    """Shows loops of the step's process as if they ran here."""

    def __init__(self, progress: Progress, outlook: Outlook) -> None:
        self._progress, self._outlook = progress, outlook
        self._loops: dict[int, Generator[None, None, None]] = {}

    def show(self, message: object) -> None:
        """Show a log record, or how far the step is."""
        match message:
            case logging.LogRecord():
                logger = logging.getLogger(message.name)
                if logger.isEnabledFor(message.levelno):
                    logger.handle(message)
            case _LoopBegun(number, label, total, kept):
                loop = self._progress.track(repeat(None), label, total, self._outlook, kept)
                self._loops[number] = loop
                next(loop)
            case _LoopGoesOn(number, passed):
                for _ in range(passed):
                    next(self._loops[number])
            case _LoopEnded(number):
                self._loops.pop(number).close()
            case _Resumed():
                self._outlook.resume()
            case _:
                raise TypeError(message)

    def close(self) -> None:
        """End the loops that an error has left."""
        for loop in self._loops.values():
            loop.close()


def _levels() -> dict[str, int]:
    """Look up the level of every logger, to set the same in the step's process."""
    named = logging.root.manager.loggerDict
    loggers = {name: logger for name, logger in named.items() if isinstance(logger, logging.Logger)}
    return {name: logger.level for name, logger in {"root": logging.root, **loggers}.items()}


def _serve(
    connection: Connection[Any, Any],
    call: StepCall,
    mark: str,
    levels: Mapping[str, int],
    environment: Mapping[str, str],
) -> None:
    """Call the step's function in this process, which has just begun, and send its result.

    Parameters
    ----------
    connection
        To the run's process.
    call
        The step and what it works on.
    mark
        Number of the step among those to do.
    levels, environment
        Levels of the loggers, and environment, of the run's process.
    """
    end_with_parent()
    os.environ.clear()  # the fork server has the environment that the first run had
    os.environ.update(environment)
    call.executor.fork_workers()
    lock = threading.Lock()

    def send(message: object) -> None:
        with lock:
            connection.send(message)

    result: Made | _Failed
    try:
        listen(once=True)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)
        logging.root.addHandler(_Forward(send))
        with call.executor:
            result = call_here(call, _ReportedProgress(send), _ReportedOutlook(mark, send))
    except BaseException as error:  # the run's process raises it
        result = _Failed(_that_pickles(error), "".join(traceback.format_exception(error)))
    # The step has ended: a signal that comes now is for the run's process.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    send(result)


class _Forward(QueueHandler):
    """Sends log records to the run's process, whose handlers they reach."""

    def __init__(self, send: Callable[[object], None]) -> None:
        super().__init__(None)  # type: ignore[arg-type]
        self._send = send

    def enqueue(self, record: logging.LogRecord) -> None:
        self._send(record)


class _ReportedProgress(Progress):
    """Tells the run's process how many items have passed."""

    def __init__(self, send: Callable[[object], None]) -> None:
        self._send, self._numbers = send, count()

    def track(
        self,
        items: Iterable[Item],
        label: str,
        total: int | None,
        outlook: Outlook | None = None,
        kept: int = 0,
    ) -> Generator[Item, None, None]:
        """Yield the items, and tell every _EVERY_S how many have passed since the last message."""
        number, said, said_s = next(self._numbers), 0, time.monotonic()
        self._send(_LoopBegun(number, label, total, kept))
        try:
            for done, item in enumerate(items):
                if time.monotonic() - said_s >= _EVERY_S:
                    self._send(_LoopGoesOn(number, done - said))
                    said, said_s = done, time.monotonic()
                yield item
        finally:
            self._send(_LoopEnded(number))


class _ReportedOutlook(Outlook):
    """Outlook in the step's process: has its number, and reports parts made by an earlier run."""

    def __init__(self, mark: str, send: Callable[[object], None]) -> None:
        super().__init__()
        self._mark, self._send = mark, send

    @property
    def mark(self) -> str:
        return self._mark

    def resume(self) -> None:
        self._send(_Resumed())


def _that_pickles(error: BaseException) -> BaseException:
    """Return the error, or a RuntimeError with its text if it cannot be pickled."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
