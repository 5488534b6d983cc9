# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""run, status, explain: run the chain on a dive and describe where it stands."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from hullrecon.api import dive_run
from hullrecon.artifacts.chain import StepStatus, assess_chain, unknown_step
from hullrecon.artifacts.progress import choose_progress
from hullrecon.artifacts.runner import StepOutcome
from hullrecon.errors import HullreconError

from ..dives import (
    FOLDER,
    Command,
    allow_outside_option,
    jobs_option,
    memory_option,
    open_dive,
    runs_option,
    set_option,
)
from ..state import state_of

SCHEDULER_HELP = (
    "a Dask scheduler instead of worker processes. tcp://HOST:PORT is plain TCP with pickle:"
    " whoever reaches the port runs programs on all machines of the cluster. tls://HOST:PORT takes"
    " its certificates from Dask's configuration (distributed.comm.tls)"
)
FROM_SCRATCH_HELP = "rerun every step, up to date or not"
READ_DATA_HELP = "read every byte that a step depends on instead of trusting times and sizes"
WAIT_HELP = "seconds to wait for another run on this dive"


def run_options(command: Command) -> Command:
    """Add the options that `run` and the single steps share, named as `hullrecon.run` has them."""
    wait = click.FloatRange(min=0)
    for option in (
        click.option("--from-scratch", is_flag=True, help=FROM_SCRATCH_HELP),
        click.option("--read-data", is_flag=True, help=READ_DATA_HELP),
        jobs_option("worker processes inside a step"),
        memory_option,
        click.option("--scheduler", metavar="ADDRESS", help=SCHEDULER_HELP),
        click.option("--wait", "wait_s", type=wait, default=0.0, help=WAIT_HELP),
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
    "--to", "last_step", metavar="STEP", help="stop after this step, running only what it needs"
)
def run(package: Path, **options: Any) -> None:
    """Run the chain on a dive PACKAGE; steps that are up to date are left as they are."""
    run_and_print(package, **options)


def run_and_print(
    package: Path, *, runs: Path, overrides: Sequence[str], allow_outside: bool, **options: Any
) -> None:
    """Run the chain and print what each step did, the warnings and the findings.

    options: as for `hullrecon.run`.
    """
    dive = open_dive(package, runs, overrides, allow_outside=allow_outside)
    progress = choose_progress(quiet=state_of().quiet)
    result = dive_run.run(dive, progress=progress, raise_failure=False, **options)
    document = {
        "dive": dive.name,
        "workspace": str(dive.workspace.root),
        "deliver": str(result.deliver) if result.is_delivered else None,
        "steps": [_outcome(o) for o in result.outcomes],
    }
    findings = delivery_lines(result.deliver) if result.is_delivered else []
    steps = [_line(outcome) for outcome in result.outcomes]
    state_of().emit(document, [*steps, *_warning_lines(result.outcomes), *findings])
    if result.failure is not None:
        raise result.failure


def _outcome(outcome: StepOutcome) -> dict[str, object]:
    """Describe what a run did with a step, for --json."""
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
    """Repeat all warnings at the end: those logged during the run have scrolled away."""
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
    """Say in a line what a run did with a step."""
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


def _document(dive: dive_run.DiveRun, plan: Sequence[StepStatus]) -> dict[str, object]:
    """Describe the state of the steps for --json."""
    steps = [{"name": s.stage.name, "state": s.state, "reasons": s.reasons} for s in plan]
    return {"dive": dive.name, "workspace": str(dive.workspace.root), "steps": steps}


def _status_line(step: StepStatus) -> str:
    """Say in a line whether a step is up to date, and why not."""
    return f"{step.stage.name:16}{step.state}" + (
        f": {'; '.join(step.reasons)}" if step.reasons else ""
    )


def refuse_unknown(steps: Sequence[str], names: Sequence[str]) -> None:
    """Raise UsageError for the first name that is no step."""
    for step in steps:
        if step not in names:
            raise unknown_step(step, names)


def delivery_lines(deliver: Path) -> list[str]:
    """Return the findings and the paths of report and deliverables, if there are any."""
    if not deliver.is_dir():
        return []
    report = deliver / "report" / "index.html"
    paths = [f"report: {report}"] if report.is_file() else []
    return [*_findings(deliver / "summary.json"), *paths, f"deliverables: {deliver}"]


def _findings(summary: Path) -> list[str]:
    """Return the sentences at the head of the report, if its summary can be read."""
    try:
        lines = json.loads(summary.read_text(encoding="utf-8"))["summary"]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return [str(line) for line in lines] if isinstance(lines, list) else []
