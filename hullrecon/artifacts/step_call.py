# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Call the function of a step, here."""

from __future__ import annotations

import gc
import signal
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from msgspec import Struct

from hullrecon.artifacts.disk import storage_errors
from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.machine import is_lack_of_memory, peak_rss, reset_peak_rss
from hullrecon.artifacts.manifest import FileRecord, JsonTable, files_below, hash_file
from hullrecon.artifacts.parts import PartStore
from hullrecon.artifacts.progress import Outlook, Progress, raise_if_requested
from hullrecon.artifacts.recipe import Job
from hullrecon.artifacts.stage import Context, Stage
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.errors import HullreconError, InputError, StageError
from hullrecon.memory import return_free_memory


@dataclass(frozen=True, kw_only=True)
class StepCall:
    """What the function of a step works on."""

    job: Job
    building: Path  # folder that it fills
    parts: PartStore | None  # where it keeps what is finished
    executor: Executor


@dataclass(frozen=True, kw_only=True)
class Made:
    """What the function of a step left: its files, its warnings and what it took."""

    outputs: dict[str, FileRecord]  # every file by its path in the folder
    warnings: list[str]
    spent: JsonTable  # times (s) and memory (bytes)


class BegunStep(Protocol):
    """A step whose function was called: it has ended, or is running in a process of its own."""

    @property
    def waitables(self) -> Sequence[Connection[Any, Any] | int]:
        """Objects for `multiprocessing.connection.wait`: one is ready when `poll` is to be called.

        Empty when the step has ended.
        """

    def poll(self) -> Made | None:
        """Process the messages that the step has sent. Returns what it left once it has ended.

        Raises as `call_here` does.
        """

    def interrupt(self) -> None:
        """Ask a step that has not ended to tidy up, and return at once."""

    def end(self) -> None:
        """Wait until a step that was interrupted has tidied up, and end it if that takes long."""


@dataclass(frozen=True)
class EndedStep:
    """A step that was run in this process and has ended."""

    made: Made
    waitables: tuple[()] = ()

    def poll(self) -> Made:
        return self.made

    def interrupt(self) -> None: ...

    def end(self) -> None: ...


BeginStep: TypeAlias = Callable[[StepCall, Progress, Outlook], BegunStep]


def begin_here(call: StepCall, progress: Progress, outlook: Outlook) -> EndedStep:
    """Call the step's function in this process, to its end. Raises as `call_here`."""
    return EndedStep(call_here(call, progress, outlook))


def call_here(call: StepCall, progress: Progress, outlook: Outlook) -> Made:
    """Call the step's function in this process.

    Raises
    ------
    StorageError
        The disk refuses.
    StageError
        The memory ran out.
    InputError
        A file may not be read.
    """
    job, building = call.job, call.building
    context: Context[Struct] = Context(
        job.stage,
        job.settings,
        job.inputs,
        ArtifactWriter(building),
        source=job.source,
        failures=job.recipe.failures,
        executor=call.executor,
        progress=progress,
        outlook=outlook,
        parts=call.parts,
    )
    spent = _call(job.stage, context, building)
    return Made(
        outputs={name: hash_file(building / name) for name in files_below(building)},
        warnings=context.warnings,
        spent=spent,
    )


def _call(stage: Stage, context: Context[Struct], building: Path) -> JsonTable:
    """Call the stage's function. Returns the times (s) and memory (bytes) that it took.

    Errors of disk, memory and permission get a sentence and a remedy.
    """
    return_free_memory()
    gc.freeze()  # what lives now, libraries above all, is not looked at by the step's collections
    reset_peak_rss()
    started, begun, cpu = time.time(), time.perf_counter(), time.process_time()
    try:
        with storage_errors(building, only_below=building):
            stage.run(context)
            raise_if_requested()
    except PermissionError as error:
        raise InputError(f"{stage.name} may not read a file", where=str(error.filename)) from error
    except Exception as error:
        if isinstance(error, HullreconError) or not is_lack_of_memory(error):
            raise
        remedy = "run on a machine with more, or with a smaller --jobs"
        raise StageError(f"{stage.name} ran out of memory", remedy=remedy) from error
    finally:
        _take_back_sigterm()
    return {
        "started": round(started, 3),
        "seconds": round(time.perf_counter() - begun, 3),
        "cpu_seconds": round(time.process_time() - cpu, 3),
        "peak_rss_bytes": peak_rss(),
        "workers_peak_rss_bytes": context.workers_peak_rss,
        **({"times": context.times} if context.times else {}),
    }


def _take_back_sigterm() -> None:
    """Restore Python's handler of SIGTERM, which pycolmap replaces on import."""
    handler = signal.getsignal(signal.SIGTERM)
    if handler is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, handler)
