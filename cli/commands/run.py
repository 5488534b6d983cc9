# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""run, status, explain: run the chain on a dive and describe where it stands."""

from __future__ import annotations

import json
import logging
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from hullrecon.api.dive_run import DiveRun
from hullrecon.api.preflight import refuse_wrong_bow
from hullrecon.artifacts.chain import StepStatus, assess_chain, unknown_step
from hullrecon.artifacts.delivery import PUBLISHED, delivered_records
from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.progress import choose_progress
from hullrecon.artifacts.runner import RunContext, StepOutcome, first_failure, run_chain
from hullrecon.errors import HullreconError, StorageError

from ..dives import FOLDER, Command, allow_outside_option, open_dive, runs_option, set_option
from ..state import state_of

log = logging.getLogger("hullrecon.cli")
SCHEDULER_HELP = (
    "a Dask scheduler instead of worker processes. tcp://HOST:PORT is plain TCP with pickle: whoever reaches the port runs"
    " programs on all machines of the cluster. tls://HOST:PORT takes its certificates from Dask's configuration"
    " (distributed.comm.tls)"
)


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How a chain is run, whatever it computes. jobs: worker processes; scheduler: address of a
    Dask scheduler instead; wait_s: s to wait for another run on this dive.
    """

    from_scratch: bool
    read_data: bool
    jobs: int
    scheduler: str | None
    wait_s: float


def run_options(command: Command) -> Command:
    """Add the options that `run` and the single steps share."""
    for option in (
        click.option("--from-scratch", is_flag=True, help="rerun every step, up to date or not"),
        click.option(
            "--read-data",
            is_flag=True,
            help="read every byte that a step depends on instead of trusting times and sizes",
        ),
        click.option(
            "--jobs",
            type=click.IntRange(min=1),
            default=1,
            show_default=True,
            help="worker processes inside a step",
        ),
        click.option("--scheduler", metavar="ADDRESS", help=SCHEDULER_HELP),
        click.option(
            "--wait",
            "wait_s",
            type=click.FloatRange(min=0),
            default=0.0,
            help="seconds to wait for another run on this dive",
        ),
        allow_outside_option,
        set_option,
        runs_option,
    ):
        command = option(command)
    return command


@click.command()
@click.argument("package", type=FOLDER)
@run_options
@click.option(
    "--to", "last", metavar="STEP", help="stop after this step, running only what it needs"
)
def run(
    package: Path, runs: Path, last: str | None, overrides: tuple[str, ...], from_scratch: bool, read_data: bool, jobs: int,
    scheduler: str | None, wait_s: float, allow_outside: bool,
) -> None:  # fmt: skip
    """Run the chain on a dive PACKAGE; steps that are up to date are left as they are."""
    dive = open_dive(package, runs, overrides, allow_outside=allow_outside)
    _warn_of_defaults(dive, overrides)
    options = RunOptions(
        from_scratch=from_scratch,
        read_data=read_data,
        jobs=jobs,
        scheduler=scheduler,
        wait_s=wait_s,
    )
    execute(dive, last, options)


def _warn_of_defaults(dive: DiveRun, overrides: Sequence[str]) -> None:
    """Log a warning for each lever arm, mount and calibration that dive.toml leaves open."""
    from hullrecon.dive.check.to_fill_in import configured_sensors, to_fill_in
    from hullrecon.dive.config.load import load_config

    config = load_config(
        dive.chain.package, {stage.name: stage.parameters for stage in dive.chain.stages}, overrides
    )
    for line in to_fill_in(config, configured_sensors(config)):
        log.warning("%s", line)


def execute(dive: DiveRun, last: str | None, options: RunOptions) -> None:
    """Run the chain up to `last` and print what each step did, the warnings and the findings."""
    state = state_of()
    chain = dive.chain if last is None else dive.chain.up_to(last)
    hashes = dive.workspace.hashes(trusting=not options.read_data)
    with choose_executor(options.jobs, options.scheduler) as executor:
        run_context = RunContext(hashes, executor, choose_progress(quiet=state.quiet))
        outcomes = run_chain(
            chain,
            dive.workspace,
            run_context,
            from_scratch=options.from_scratch,
            wait_s=options.wait_s,
            preflight=lambda plan: _preflight(dive, plan),
            keep_going=True,
        )
    shown = dive.workspace.root / PUBLISHED
    # by this run, not before it
    is_delivered = any(o.manifest is not None and delivered_records(o.manifest) for o in outcomes)
    delivered = str(shown) if is_delivered else None
    document = {
        "dive": dive.name,
        "workspace": str(dive.workspace.root),
        "deliver": delivered,
        "steps": [_outcome(o) for o in outcomes],
    }
    findings = delivery_lines(shown) if is_delivered else []
    state.emit(document, [*(_line(o) for o in outcomes), *_warning_lines(outcomes), *findings])
    failure = first_failure(outcomes)
    if failure is not None:
        raise failure


def _preflight(dive: DiveRun, plan: list[StepStatus]) -> None:
    """Log what is to be done. Raises InputError for a bow that the CAD model does not have,
    StorageError where the disk is too full.

    A step is built beside its old artifact, so about that much space must be free.
    """
    to_do = [step.stage.name for step in plan if step.to_do]
    log.info(
        "%s: %s", dive.name, f"to do: {', '.join(to_do)}" if to_do else "everything is up to date"
    )
    refuse_wrong_bow(dive, plan)
    needed = sum(
        r.size
        for s in plan
        if s.to_do and s.manifest is not None
        for r in s.manifest.outputs.values()
    )
    free = shutil.disk_usage(dive.workspace.root).free
    if needed > free:
        remedy = f"the last run's artifacts took {needed / 1e6:.0f} MB: free some space, or choose another folder with --runs"
        raise StorageError(
            f"only {free / 1e6:.0f} MB are free", where=str(dive.workspace.root), remedy=remedy
        )


def _outcome(outcome: StepOutcome) -> dict[str, object]:
    manifest = outcome.manifest
    spent = (
        {k: manifest.run.get(k) for k in ("seconds", "peak_rss_bytes")}
        if manifest is not None and outcome.made
        else {}
    )
    state = (
        "failed"
        if outcome.failure is not None
        else "made"
        if outcome.made
        else outcome.before.state
    )
    warnings = manifest.warnings if manifest is not None else []
    return {
        "name": outcome.before.stage.name,
        "state": state,
        "reasons": outcome.before.reasons,
        "warnings": warnings,
        **spent,
    }


def _warning_lines(outcomes: Sequence[StepOutcome]) -> list[str]:
    """Repeat every warning in one place: those of the log have scrolled away."""
    warnings = [
        (o.before.stage.name, w)
        for o in outcomes
        if o.manifest is not None
        for w in o.manifest.warnings
    ]
    return (
        [
            f"{len(warnings)} warning{'s' if len(warnings) > 1 else ''}:",
            *(f"  {n}: {w}" for n, w in warnings),
        ]
        if warnings
        else []
    )


def _line(outcome: StepOutcome) -> str:
    step = outcome.before
    if outcome.failure is not None:
        reason = (
            outcome.failure.line()
            if isinstance(outcome.failure, HullreconError)
            else "internal error"
        )
        return f"{step.stage.name:16}failed: {reason}"
    if outcome.made and outcome.manifest is not None:
        return (
            f"{step.stage.name:16}ran in {outcome.manifest.run['seconds']:.1f} s: {step.why_run()}"
        )
    return _status_line(step)


@click.command()
@click.argument("target", type=FOLDER)
@set_option
@runs_option
@allow_outside_option
def status(target: Path, runs: Path, overrides: tuple[str, ...], allow_outside: bool) -> None:
    """Say of each step whether it is up to date. TARGET is a dive package or a run's folder."""
    dive = open_dive(target, runs, overrides, allow_outside=allow_outside)
    plan = assess_chain(dive.chain, dive.workspace, dive.workspace.hashes())
    state_of().emit(_document(dive, plan), map(_status_line, plan))


@click.command()
@click.argument("target", type=FOLDER)
@click.argument("steps", nargs=-1, metavar="[STEP]...")
@set_option
@runs_option
@allow_outside_option
def explain(
    target: Path,
    steps: tuple[str, ...],
    runs: Path,
    overrides: tuple[str, ...],
    allow_outside: bool,
) -> None:
    """Say why steps would run again: which option, input or file changed, and from what to what."""
    dive = open_dive(target, runs, overrides, allow_outside=allow_outside)
    refuse_unknown(steps, [stage.name for stage in dive.chain.stages])
    plan = [
        s
        for s in assess_chain(dive.chain, dive.workspace, dive.workspace.hashes())
        if not steps or s.stage.name in steps
    ]
    lines = (f"{s.stage.name}: {reason}" for s in plan for reason in s.reasons or (f"{s.state}",))
    state_of().emit(_document(dive, plan), lines)


def _document(dive: DiveRun, plan: Sequence[StepStatus]) -> dict[str, object]:
    steps = [{"name": s.stage.name, "state": s.state, "reasons": s.reasons} for s in plan]
    return {"dive": dive.name, "workspace": str(dive.workspace.root), "steps": steps}


def _status_line(step: StepStatus) -> str:
    return f"{step.stage.name:16}{step.state}" + (
        f": {'; '.join(step.reasons)}" if step.reasons else ""
    )


def refuse_unknown(steps: Sequence[str], names: Sequence[str]) -> None:
    """Raise UsageError for the first name that is no step."""
    for step in steps:
        if step not in names:
            raise unknown_step(step, names)


def delivery_lines(deliver: Path) -> list[str]:
    """Return the findings of the report and the paths of report and deliverables; none when nothing
    is delivered.
    """
    if not deliver.is_dir():
        return []
    report = deliver / "report" / "index.html"
    paths = [f"report: {report}"] if report.is_file() else []
    return [*_findings(deliver / "summary.json"), *paths, f"deliverables: {deliver}"]


def _findings(summary: Path) -> list[str]:
    """Return the sentences at the head of the report; none when the summary is missing or of
    another form.
    """
    try:
        lines = json.loads(summary.read_text(encoding="utf-8"))["summary"]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return [str(line) for line in lines] if isinstance(lines, list) else []
