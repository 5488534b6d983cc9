# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run a chain of stages in a workspace: what is up to date stays, the rest reruns in order."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from hullrecon.artifacts.execution.memory_limit import refuse_small_address_space
from hullrecon.artifacts.execution.runner import RunContext, build
from hullrecon.artifacts.graph.chain import Chain, inputs_of
from hullrecon.artifacts.graph.job import Job, make_job
from hullrecon.artifacts.graph.plan import StepStatus, assess_chain, assess_step
from hullrecon.artifacts.graph.source_watch import SourceWatch
from hullrecon.artifacts.storage.manifest import Manifest
from hullrecon.artifacts.storage.workspace import Workspace
from hullrecon.errors import HullreconError, StageError

log = logging.getLogger(__name__)
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
