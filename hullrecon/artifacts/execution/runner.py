# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run one stage: call its function into a temporary folder and commit that, with its manifest, as a
whole.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hullrecon.artifacts.execution.context import StageContext
from hullrecon.artifacts.execution.executor import Executor, choose_executor
from hullrecon.artifacts.execution.interruption import raise_if_requested
from hullrecon.artifacts.execution.machine import host, peak_rss, reset_peak_rss, versions
from hullrecon.artifacts.execution.memory_limit import is_lack_of_memory
from hullrecon.artifacts.execution.progress import Progress, Silent, choose_progress
from hullrecon.artifacts.graph.job import Job, make_job
from hullrecon.artifacts.graph.source_watch import SourceWatch
from hullrecon.artifacts.graph.stage import Stage
from hullrecon.artifacts.storage.disk import commit_folder, make_folder, remove, storage_errors
from hullrecon.artifacts.storage.hashing import HashCache, files_below, hash_file
from hullrecon.artifacts.storage.manifest import JsonTable, Manifest, write_manifest
from hullrecon.artifacts.storage.writer import ArtifactWriter
from hullrecon.errors import HullreconError, InputError, StageError


@dataclass(frozen=True)
class RunContext:
    """What a run works with, whatever the stage."""

    hashes: HashCache
    executor: Executor
    progress: Progress = field(default_factory=Silent)
    # of the run that a step is part of; a step by itself has one of its own
    watch: SourceWatch | None = None


def run_stage(
    stage: Stage,
    settings: Mapping[str, object],
    inputs: Mapping[str, Path],
    out: Path,
    source: Path | None = None,
    jobs: int = 1,
) -> Path:
    """Run one stage outside a workspace, for tests and notebooks, and return `out`, which then
    holds its artifact.

    settings: decoded sections by name (an absent one is None, the stage's own takes its defaults).
    inputs: folder of each input by stage name, with or without a manifest. source: the package's
    folder, for stages with `external` files.
    """
    hashes = HashCache()
    job = make_job(stage, settings, inputs, source, hashes)
    with choose_executor(jobs) as executor:
        build(
            job,
            out,
            out.with_name(f".building-{out.name}"),
            RunContext(hashes, executor, choose_progress()),
        )
    return out


def build(job: Job, out: Path, building: Path, run_context: RunContext) -> Manifest:
    """Run the stage's function into the folder `building` and puts that, manifest last, at `out` in
    one step.

    Whatever goes wrong, `out` is as it was. StorageError when the disk refuses; StageError when the
    memory ran out; InputError when a file of the package changed meanwhile.
    """
    watch = run_context.watch or SourceWatch(run_context.hashes, job.source or Path())
    watch.begin(job)
    with storage_errors(building.parent):
        remove(building)
    make_folder(building)
    try:
        manifest = _fill(job, building, run_context)
        watch.end(job)
        commit_folder(building, out)
    except BaseException:
        remove(building)
        raise
    for name, record in manifest.outputs.items():
        run_context.hashes.learn(out / name, record)
    return manifest


def _fill(job: Job, building: Path, run_context: RunContext) -> Manifest:
    context = StageContext(
        job, ArtifactWriter(building), run_context.executor, run_context.progress
    )
    spent = _call(job.stage, context, building)
    outputs = {name: hash_file(building / name) for name in files_below(building)}
    run: JsonTable = {"versions": versions(), "host": host(), **spent}
    manifest = Manifest(
        recipe=job.recipe, key=job.recipe.key, outputs=outputs, warnings=context.warnings, run=run
    )
    write_manifest(building, manifest)
    return manifest


def _call(stage: Stage, context: StageContext, building: Path) -> JsonTable:
    """Call the stage's function and return what it took: times, s, and memory, bytes."""
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
    """Restore Python's handler of SIGTERM: pycolmap takes it when it is imported, and ends the
    process with a dump.
    """
    handler = signal.getsignal(signal.SIGTERM)
    if handler is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, handler)
