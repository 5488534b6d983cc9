# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run one step, or a chain of steps: what is up to date stays, the rest is made anew."""

from __future__ import annotations

import logging
import multiprocessing
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from hullrecon.artifacts.chain import Chain, StepStatus, assess_chain, assess_step, inputs_of
from hullrecon.artifacts.delivery import delivered_records
from hullrecon.artifacts.disk import commit_folder, make_folder, remove, storage_errors
from hullrecon.artifacts.executor import Executor, choose_executor
from hullrecon.artifacts.machine import (
    host,
    is_lack_of_memory,
    peak_rss,
    refuse_small_address_space,
    reset_peak_rss,
    versions,
)
from hullrecon.artifacts.manifest import (
    HashCache,
    JsonTable,
    Manifest,
    files_below,
    hash_file,
    write_manifest,
)
from hullrecon.artifacts.progress import (
    Progress,
    Silent,
    choose_progress,
    length,
    raise_if_requested,
)
from hullrecon.artifacts.recipe import Job, SourceWatch, make_job
from hullrecon.artifacts.stage import Stage, Writer
from hullrecon.artifacts.workspace import Workspace
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.errors import HullreconError, InputError, StageError

Item = TypeVar("Item")
Result = TypeVar("Result")
log = logging.getLogger(__name__)


class StageContext:
    """Implements `stage.Context`. `warnings`, `times` (s, by name) and `workers_peak_rss` (bytes)
    are read by the runner when the stage has ended.
    """

    def __init__(
        self, job: Job, out: Writer, executor: Executor, progress: Progress
    ) -> None:  # fmt: skip
        self.settings, self.inputs, self.out = job.settings, job.inputs, out
        self.failures: Mapping[str, str] = job.recipe.failures
        self.warnings: list[str] = []
        self.times: dict[str, list[float]] = {}
        self.workers_peak_rss = 0
        self._stage, self._source = job.stage, job.source
        self._executor, self._progress = executor, progress

    @property
    def source(self) -> Path:
        if self._source is None or self._stage.external is None:
            raise RuntimeError(
                f"step {self._stage.name} reads the package without declaring `external` files"
            )
        return self._source

    @property
    def parameters(self) -> Any:
        return self.settings[self._stage.name]

    def progress(
        self, items: Iterable[Item], label: str, total: int | None = None
    ) -> Iterable[Item]:
        total = total if total is not None else length(items)
        return self._progress.track(
            _until_interrupted(items), f"{self._stage.name}: {label}", total
        )

    def map(
        self, function: Callable[[Item], Result], items: Sequence[Item], label: str
    ) -> list[Result]:
        results = list(self.progress(self._executor.map(function, items), label, len(items)))
        workers = (peak_rss(worker.pid) for worker in multiprocessing.active_children())
        self.workers_peak_rss = max(self.workers_peak_rss, *workers, 0)
        return results

    def warn(self, message: str) -> None:
        log.warning("%s: %s", self._stage.name, message)
        self.warnings.append(message)

    def record_times(self, name: str, seconds: Sequence[float]) -> None:
        self.times[name] = [round(float(s), 3) for s in seconds]


def _until_interrupted(items: Iterable[Item]) -> Iterator[Item]:
    for item in items:
        raise_if_requested()
        yield item


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


Preflight = Callable[[list[StepStatus]], None]


@dataclass(frozen=True)
class StepOutcome:
    """What a run did with one step: its status before, whether it ran, and its artifact's manifest,
    None when skipped or failed. failure: why a step that fails alone has no result.
    """

    before: StepStatus
    made: bool
    manifest: Manifest | None
    failure: Exception | None = None

    @property
    def delivers(self) -> bool:
        """Whether the step's artifact holds files that are copied to deliver/."""
        return self.manifest is not None and bool(delivered_records(self.manifest))


def run_chain(
    chain: Chain, workspace: Workspace, run_context: RunContext, *, from_scratch: bool = False, wait_s: float = 0.0,
    preflight: Preflight | None = None, keep_going: bool = False,
) -> list[StepOutcome]:  # fmt: skip
    """Bring every step of the chain up to date and publishes what is to be delivered.

    preflight gets the status of every step before anything is done; an error that it raises ends
    the run. keep_going: a step that fails alone leaves its failure in its outcome
    (`first_failure`), and the others go on. What an earlier run delivered is withdrawn when this
    one fails. LockedError when another run holds the workspace; InputError when the package changed
    meanwhile; a stage's own errors pass, and what was finished before is kept.
    """
    refuse_small_address_space()
    workspace.refuse_package(chain.package)
    with workspace.lock(wait_s):
        other = workspace.other_package(chain.package, chain.read_before)
        if other is not None:
            log.warning(
                "%s holds the results of another dive package, %s: what differs is replaced",
                workspace.root,
                other,
            )
        workspace.tidy(stage.name for stage in chain.stages)
        workspace.remember_package(chain.package)
        try:
            if preflight is not None:
                preflight(assess_chain(chain, workspace, run_context.hashes))
            return _run_all(chain, workspace, run_context, from_scratch, keep_going)
        except Exception:
            if workspace.delivery.withdraw():
                log.warning(
                    "what an earlier run delivered is in %s now", workspace.delivery.withdrawn
                )
            raise
        finally:
            run_context.hashes.save()


def first_failure(outcomes: Sequence[StepOutcome]) -> Exception | None:
    """Return why the first step that failed alone did; None where none did."""
    return next((outcome.failure for outcome in outcomes if outcome.failure is not None), None)


def _run_all(
    chain: Chain,
    workspace: Workspace,
    run_context: RunContext,
    from_scratch: bool,
    keep_going: bool,
) -> list[StepOutcome]:
    skipped, failures = chain.skip_reasons(), dict[str, str]()
    done: list[StepOutcome] = []
    watch = SourceWatch(run_context.hashes, chain.package, chain.read_before)
    run_context = replace(run_context, watch=watch)
    for stage in chain.stages:
        if stage.name in skipped:
            log.info("%s: skipped: %s", stage.name, skipped[stage.name])
            done.append(
                StepOutcome(
                    StepStatus(stage=stage, state="skipped", reasons=(skipped[stage.name],)),
                    False,
                    None,
                )
            )
            continue
        lost = next((name for name in stage.inputs if name in failures), None)
        if lost is not None:
            failures[stage.name] = f"it needs {lost}, which failed: {failures[lost]}"
            done.append(
                StepOutcome(
                    StepStatus(stage=stage, state="skipped", reasons=(failures[stage.name],)),
                    False,
                    None,
                )
            )
            continue
        inputs = inputs_of(stage, chain, workspace, {**skipped, **failures})
        job = make_job(stage, chain.sections, inputs, chain.package, run_context.hashes, failures)
        watch.begin(job)
        outcome = _bring_up_to_date(job, workspace, run_context, from_scratch, keep_going)
        done.append(outcome)
        if outcome.failure is not None:
            failures[stage.name] = _in_words(outcome.failure)
            continue
        watch.end(job)
        restored = workspace.publish(stage.name, run_context.hashes)
        if restored is not None:
            log.warning("%s", restored)
    return done


def _in_words(failure: Exception) -> str:
    return (
        failure.line()
        if isinstance(failure, HullreconError)
        else f"internal error ({type(failure).__name__})"
    )


def _bring_up_to_date(
    job: Job, workspace: Workspace, run_context: RunContext, from_scratch: bool, keep_going: bool
) -> StepOutcome:
    name = job.stage.name
    status = assess_step(job, workspace, run_context.hashes)
    if status.state == "up to date" and not from_scratch:
        log.debug("%s: up to date", name)
        return StepOutcome(status, False, status.manifest)
    log.info("%s: started: %s", name, status.why_run())
    if status.state == "damaged":
        log.warning(
            "%s: damaged (%s), set apart in %s",
            name,
            "; ".join(status.reasons),
            workspace.quarantine(name),
        )
    try:
        manifest = build(job, workspace.root / name, workspace.build_folder(name), run_context)
    except Exception as error:
        error.add_note(name)
        if not keep_going or not job.stage.fails_alone or not _is_the_steps_own(error):
            raise
        log.warning("%s: failed: %s", name, _in_words(error))
        return StepOutcome(status, False, None, error)
    run_context.hashes.save()
    log.debug(
        "%s: done in %.1f s, %.0f MB",
        name,
        manifest.run["seconds"],
        manifest.run["peak_rss_bytes"] / 1e6,
    )
    return StepOutcome(status, True, manifest)


def _is_the_steps_own(error: Exception) -> bool:
    """Return whether a failure says nothing of the disk, the package or the configuration, which
    concern all steps.
    """
    return isinstance(error, StageError) or not isinstance(error, HullreconError | OSError)
