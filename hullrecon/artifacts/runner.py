# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run one step, or a chain of steps. What is up to date is kept, the rest is rebuilt."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from hullrecon.artifacts.chain import Chain, StepStatus, assess_chain, assess_step, inputs_of
from hullrecon.artifacts.delivery import delivered_records
from hullrecon.artifacts.disk import commit_folder, make_folder, remove, storage_errors
from hullrecon.artifacts.executor import Executor, choose_executor
from hullrecon.artifacts.interleaving import Course, await_end, interleave, run_to_end
from hullrecon.artifacts.machine import host, refuse_small_address_space, versions
from hullrecon.artifacts.manifest import HashCache, Manifest, write_manifest
from hullrecon.artifacts.parts import PartStore
from hullrecon.artifacts.progress import Outlook, Progress, RunOutlook, choose_progress
from hullrecon.artifacts.recipe import Job, SourceWatch, make_job
from hullrecon.artifacts.stage import Stage
from hullrecon.artifacts.step_call import BeginStep, StepCall, begin_here
from hullrecon.artifacts.workspace import Workspace, removed_meanwhile
from hullrecon.errors import HullreconError, StageError

log = logging.getLogger(__name__)
Preflight = Callable[[list[StepStatus]], None]  # checks before anything is done; may raise


@dataclass(frozen=True)
class RunContext:
    """What a run works with, the same for all stages."""

    hashes: HashCache
    executor: Executor
    progress: Progress = field(default_factory=Progress)
    outlook: RunOutlook = field(default_factory=RunOutlook)
    watch: SourceWatch | None = None  # of the whole run, None for a step that runs alone
    is_held: Callable[[], bool] = lambda: True  # whether the workspace's lock is still held
    begin_step: BeginStep = begin_here  # calls a step's function, here or in a process of its own
    # whether the steps of these names may run at the same time
    fit_together: Callable[[Collection[str]], bool] = lambda steps: False


@dataclass(frozen=True)
class StepOutcome:
    """What a run did with one step."""

    before: StepStatus  # as assessed before the run
    made: bool  # it ran to its end
    manifest: Manifest | None  # of its artifact, None when skipped or failed
    failure: Exception | None = None  # why a step that fails alone has no result

    @property
    def delivers(self) -> bool:
        """Whether the step's artifact holds files that are copied to deliver/."""
        return self.manifest is not None and bool(delivered_records(self.manifest))


def first_failure(outcomes: Sequence[StepOutcome]) -> Exception | None:
    """Find the error of the first step that failed alone. None if no step did."""
    return next((outcome.failure for outcome in outcomes if outcome.failure is not None), None)


def run_chain(
    chain: Chain,
    workspace: Workspace,
    run_context: RunContext,
    *,
    from_scratch: bool = False,
    wait_s: float = 0.0,
    preflight: Preflight | None = None,
    before: Mapping[str, Callable[[], None]] | None = None,
    keep_going: bool = False,
) -> list[StepOutcome]:
    """Bring every step of the chain up to date, and publish the deliverables.

    Parameters
    ----------
    chain
        The steps, their settings and the package.
    workspace
        The dive's folder in RUNS.
    run_context
        What the run works with.
    from_scratch
        Rebuild all steps, also those that are up to date.
    wait_s
        How long to wait for another run on this workspace.
    preflight
        Called with the status of every step before anything is done. Its error ends the run.
    before
        Functions by name of a step, called before that step once its predecessors are up to date.
        An error ends the run.
    keep_going
        The error of a step that may fail alone (`Stage.fails_alone`) is returned in its outcome,
        and the other steps go on.

    Returns
    -------
    outcomes
        One for each step, in order.

    Raises
    ------
    LockedError
        Another run holds the workspace after wait_s.
    InputError
        The package changed during the run.
    Exception
        A step's own error. Finished steps are kept. What an earlier run delivered is withdrawn.
    """
    refuse_small_address_space()
    workspace.refuse_package(chain.package)
    with workspace.lock(wait_s) as is_held:
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
            run_context = replace(run_context, is_held=is_held)
            return _run_all(chain, workspace, run_context, from_scratch, keep_going, before or {})
        except Exception:
            if is_held() and workspace.delivery.withdraw():
                withdrawn = workspace.delivery.withdrawn
                log.warning("what an earlier run delivered is in %s now", withdrawn)
            raise
        finally:
            if is_held():
                run_context.hashes.save()


def _run_all(
    chain: Chain,
    workspace: Workspace,
    run_context: RunContext,
    from_scratch: bool,
    keep_going: bool,
    before: Mapping[str, Callable[[], None]],
) -> list[StepOutcome]:
    """Bring all steps up to date in order, at the same time where they fit together.

    Steps that the dive cannot have, and those that need one that failed, are skipped, and their
    outcomes say why. Parameters are those of `run_chain`.
    """
    skipped, failures = chain.skip_reasons(), dict[str, str]()
    hashes = run_context.hashes
    watch = SourceWatch(hashes, chain.package, chain.read_before)
    run_context = replace(run_context, watch=watch)

    def take(stage: Stage) -> Course[StepOutcome]:
        """Bring a step up to date, unless the dive cannot have it or an input has failed."""
        if not run_context.is_held():
            raise removed_meanwhile(workspace.root)
        lost = next((name for name in stage.inputs if name in failures), None)
        if stage.name in skipped:
            log.info("%s: skipped: %s", stage.name, skipped[stage.name])
        elif lost is not None:
            failures[stage.name] = f"it needs {lost}, which failed: {failures[lost]}"
        why_not = skipped.get(stage.name) or failures.get(stage.name)
        if why_not is not None:
            status = StepStatus(stage=stage, state="skipped", reasons=(why_not,))
            return StepOutcome(status, False, None)
        if stage.name in before:
            before[stage.name]()
        inputs = inputs_of(stage, chain, workspace, {**skipped, **failures})
        job = make_job(stage, chain.sections, inputs, chain.package, hashes, failures)
        watch.begin(job)
        outcome = yield from _bring_up_to_date(
            job, workspace, run_context, from_scratch, keep_going
        )
        if outcome.failure is not None:
            failures[stage.name] = _in_words(outcome.failure)
            return outcome
        watch.end(job)
        restored = workspace.publish(stage.name, hashes)
        if restored is not None:
            log.warning("%s", restored)
        return outcome

    return interleave(chain.stages, take, run_context.fit_together)


def _bring_up_to_date(
    job: Job, workspace: Workspace, run_context: RunContext, from_scratch: bool, keep_going: bool
) -> Course[StepOutcome]:
    """Rebuild one step if it is out of date or damaged, or in any case if `from_scratch`.

    With `keep_going`, an error that concerns this step alone is returned in its outcome.
    """
    name = job.stage.name
    status = assess_step(job, workspace, run_context.hashes)
    parts = PartStore(workspace.parts_folder(name), job.recipe)
    if status.state == "up to date" or from_scratch:
        parts.remove()
    if status.state == "up to date" and not from_scratch:
        log.debug("%s: up to date", name)
        return StepOutcome(status, False, status.manifest)
    try:
        with run_context.outlook.step(name) as outlook:
            why = status.why_run()
            log.info("%s%s: started: %s%s", outlook.mark, name, why, outlook.left())
            if status.state == "damaged":
                place, how = workspace.quarantine(name), "; ".join(status.reasons)
                log.warning("%s: damaged (%s), set apart in %s", name, how, place)
            manifest = yield from _build(
                job,
                workspace.root / name,
                workspace.build_folder(name),
                run_context,
                parts,
                outlook,
            )
    except Exception as error:
        error.add_note(name)
        # An error of the disk, the package or the configuration concerns all steps.
        is_its_own = isinstance(error, StageError) or not isinstance(
            error, HullreconError | OSError
        )
        if not (keep_going and job.stage.fails_alone and is_its_own):
            raise
        log.warning("%s: failed: %s", name, _in_words(error))
        return StepOutcome(status, False, None, error)
    run_context.hashes.save()
    spent = manifest.run
    log.debug("%s: done in %.1f s, %.0f MB", name, spent["seconds"], spent["peak_rss_bytes"] / 1e6)
    return StepOutcome(status, True, manifest)


def _in_words(failure: Exception) -> str:
    """Describe the failure of a step in one line, for the steps that go on without it."""
    if isinstance(failure, HullreconError):
        return failure.line()
    return f"internal error ({type(failure).__name__})"


def run_stage(
    stage: Stage,
    settings: Mapping[str, object],
    inputs: Mapping[str, Path],
    out: Path,
    source: Path | None = None,
    jobs: int = 1,
) -> Path:
    """Run one stage into the folder `out`, outside a workspace, for tests and notebooks.

    Parameters
    ----------
    stage
        The step.
    settings
        Decoded sections by name. An absent section is None, the stage's own has its defaults.
    inputs
        Folder of each input by stage name, with or without a manifest.
    out
        Folder of the artifact, which is returned.
    source
        The package's folder, if the stage reads files of it.
    jobs
        Number of worker processes.
    """
    hashes = HashCache()
    job = make_job(stage, settings, inputs, source, hashes)
    building = out.with_name(f".building-{out.name}")
    with choose_executor(jobs) as executor:
        build(job, out, building, RunContext(hashes, executor, choose_progress()))
    return out


def build(job: Job, out: Path, building: Path, run_context: RunContext) -> Manifest:
    """Run the stage's function in the folder `building`, then rename that to `out`.

    The manifest is written last. After any error, `out` is as it was.

    Raises
    ------
    StorageError
        The disk refuses.
    StageError
        The memory ran out.
    InputError
        A file of the package changed meanwhile.
    """
    return run_to_end(_build(job, out, building, run_context))


def _build(
    job: Job,
    out: Path,
    building: Path,
    run_context: RunContext,
    parts: PartStore | None = None,
    outlook: Outlook | None = None,
) -> Course[Manifest]:
    """Build as `build` does, as a coroutine. After an error `parts` keeps the finished parts."""
    watch = run_context.watch or SourceWatch(run_context.hashes, job.source or Path())
    watch.begin(job)
    with storage_errors(building.parent):
        remove(building)
    make_folder(building)
    if parts is not None:
        parts.begin()
    try:
        call = StepCall(job=job, building=building, parts=parts, executor=run_context.executor)
        begun = run_context.begin_step(call, run_context.progress, outlook or Outlook())
        made = yield from await_end(begun)
        manifest = Manifest(
            recipe=job.recipe,
            key=job.recipe.key,
            outputs=made.outputs,
            warnings=made.warnings,
            run={"versions": versions(), "host": host(), **made.spent},
        )
        write_manifest(building, manifest)
        watch.end(job)
        commit_folder(building, out)
    except BaseException:
        remove(building)
        raise
    if parts is not None:
        parts.remove()
    for name, record in manifest.outputs.items():
        run_context.hashes.learn(out / name, record)
    return manifest
