# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""run, status, explain, clean."""

from __future__ import annotations

import logging
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from hullrecon.artifacts.execution.chain_runner import Outcome, run_chain
from hullrecon.artifacts.execution.executor import choose_executor
from hullrecon.artifacts.execution.progress import choose_progress
from hullrecon.artifacts.execution.runner import RunContext
from hullrecon.artifacts.graph.plan import StepStatus, survey
from hullrecon.artifacts.storage.workspace import PUBLISHED, Workspace
from hullrecon.errors import StorageError, UsageError

from .dives import FOLDER, Command, DiveRun, find_workspace, open_dive, runs_option, set_option
from .state import state_of

log = logging.getLogger("hullrecon.cli")


def run_options(command: Command) -> Command:
    """What `run` and the single steps share."""
    for option in (
        click.option("--from-scratch", is_flag=True, help="make every step anew, fresh or not"),
        click.option(
            "--read-data", is_flag=True, help="read every byte that a step depends on instead of trusting times and sizes"
        ),
        click.option("--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="worker processes inside a step"),
        click.option("--scheduler", metavar="ADDRESS", help="a Dask scheduler instead of worker processes"),
        click.option(
            "--wait", "wait_s", type=click.FloatRange(min=0), default=0.0, help="seconds to wait for another run on this dive"
        ),
        set_option,
        runs_option,
    ):
        command = option(command)
    return command


@click.command()
@click.argument("package", type=FOLDER)
@run_options
@click.option("--to", "last", metavar="STEP", help="stop after this step, running only what it needs")
def run(package: Path, runs: Path, last: str | None, overrides: tuple[str, ...], **how: Any) -> None:
    """Run the chain on a dive PACKAGE; what is fresh is left as it is."""
    execute(open_dive(package, runs, overrides), last, **how)


def execute(
    dive: DiveRun, last: str | None, *, from_scratch: bool, read_data: bool, jobs: int, scheduler: str | None, wait_s: float
) -> None:
    """Runs the chain up to `last` and says on standard output what came of it."""
    state = state_of()
    chain = dive.chain if last is None else dive.chain.up_to(last)
    hashes = dive.workspace.hashes(trusting=not read_data)
    with choose_executor(jobs, scheduler) as executor:
        run_context = RunContext(hashes, executor, choose_progress(quiet=state.quiet))
        outcomes = run_chain(
            chain,
            dive.workspace,
            run_context,
            from_scratch=from_scratch,
            wait_s=wait_s,
            preflight=lambda plan: _preflight(dive, plan),
        )
    shown = dive.workspace.root / PUBLISHED
    delivered = str(shown) if shown.is_dir() else None
    document = {
        "dive": dive.name,
        "workspace": str(dive.workspace.root),
        "deliver": delivered,
        "steps": [_outcome(o) for o in outcomes],
    }
    state.emit(document, [*(_line(o) for o in outcomes), *([f"deliverables: {delivered}"] if delivered else [])])


def _preflight(dive: DiveRun, plan: list[StepStatus]) -> None:
    """Says what is to be done; a step is built beside its old artifact, so about that much space must be free."""
    to_do = [step.stage.name for step in plan if step.to_do]
    log.info("%s: %s", dive.name, f"to do: {', '.join(to_do)}" if to_do else "everything is fresh")
    needed = sum(r.size for s in plan if s.to_do and s.manifest is not None for r in s.manifest.outputs.values())
    free = shutil.disk_usage(dive.workspace.root).free
    if needed > free:
        remedy = f"the last run's artifacts took {needed / 1e6:.0f} MB: free some space, or choose another folder with --runs"
        raise StorageError(f"only {free / 1e6:.0f} MB are free", where=str(dive.workspace.root), remedy=remedy)


def _outcome(outcome: Outcome) -> dict[str, object]:
    manifest = outcome.manifest
    spent = {k: manifest.run.get(k) for k in ("seconds", "peak_rss_bytes")} if manifest is not None and outcome.made else {}
    state = "made" if outcome.made else outcome.before.state
    warnings = manifest.warnings if manifest is not None else []
    return {"name": outcome.before.stage.name, "state": state, "reasons": outcome.before.reasons, "warnings": warnings, **spent}


def _line(outcome: Outcome) -> str:
    step = outcome.before
    if outcome.made and outcome.manifest is not None:
        why = "; ".join(step.reasons) or "from scratch"
        return f"{step.stage.name:16}made in {outcome.manifest.run['seconds']:.1f} s: {why}"
    return _status_line(step)


@click.command()
@click.argument("target", type=FOLDER)
@set_option
@runs_option
def status(target: Path, runs: Path, overrides: tuple[str, ...]) -> None:
    """Say of each step whether it is fresh. TARGET is a dive package or a run's folder."""
    dive = open_dive(target, runs, overrides)
    plan = survey(dive.chain, dive.workspace, dive.workspace.hashes())
    state_of().emit(_document(dive, plan), map(_status_line, plan))


@click.command()
@click.argument("target", type=FOLDER)
@click.argument("steps", nargs=-1, metavar="[STEP]...")
@set_option
@runs_option
def explain(target: Path, steps: tuple[str, ...], runs: Path, overrides: tuple[str, ...]) -> None:
    """Say why steps would run again: which option, input or file changed, and from what to what."""
    dive = open_dive(target, runs, overrides)
    _known(steps, [stage.name for stage in dive.chain.stages])
    plan = [s for s in survey(dive.chain, dive.workspace, dive.workspace.hashes()) if not steps or s.stage.name in steps]
    lines = (f"{s.stage.name}: {reason}" for s in plan for reason in s.reasons or (f"{s.state}",))
    state_of().emit(_document(dive, plan), lines)


def _document(dive: DiveRun, plan: Sequence[StepStatus]) -> dict[str, object]:
    steps = [{"name": s.stage.name, "state": s.state, "reasons": s.reasons} for s in plan]
    return {"dive": dive.name, "workspace": str(dive.workspace.root), "steps": steps}


def _status_line(step: StepStatus) -> str:
    return f"{step.stage.name:16}{step.state}" + (f": {'; '.join(step.reasons)}" if step.reasons else "")


@click.command()
@click.argument("target", type=FOLDER)
@click.argument("steps", nargs=-1, metavar="[STEP]...")
@runs_option
def clean(target: Path, steps: tuple[str, ...], runs: Path) -> None:
    """Remove the artifacts of steps, or of all of them. The package is never touched, nor is what lies in quarantine."""
    from hullrecon.steps.chain import NAMES

    _known(steps, NAMES)
    workspace: Workspace = find_workspace(target, runs)
    with workspace.lock():
        removed = [name for name in steps or NAMES if workspace.remove(name)]
    state_of().emit({"workspace": str(workspace.root), "removed": removed}, [f"removed {name}" for name in removed])


def _known(steps: Sequence[str], names: Sequence[str]) -> None:
    for step in steps:
        if step not in names:
            raise UsageError(f"no step is called {step}", remedy=f"the steps are {', '.join(names)}")
