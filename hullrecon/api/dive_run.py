# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Open a dive package, run its chain of steps, and score what came out."""

from __future__ import annotations

import logging
import multiprocessing
import shutil
from collections.abc import Collection, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from hullrecon.artifacts.chain import Chain, StepStatus
from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.machine import usable_cores
from hullrecon.artifacts.manifest import hash_file
from hullrecon.artifacts.progress import Progress, RunOutlook
from hullrecon.artifacts.runner import RunContext, StepOutcome, first_failure, run_chain
from hullrecon.artifacts.step_call import begin_here
from hullrecon.artifacts.step_process import start_early, step_processes
from hullrecon.artifacts.workspace import PUBLISHED, Workspace
from hullrecon.errors import InputError, StorageError, UsageError

if TYPE_CHECKING:
    from hullrecon.api.costs import StepCost
    from hullrecon.dive.config.load import LoadedConfig
    from hullrecon.evaluation.score import Score

log = logging.getLogger(__name__)
PRELOAD = ("hullrecon.steps.preload",)  # modules that the processes of steps have imported
# Keys by which a step uses where the hull lies: with one of them the hull is checked before the run
ASKS_FOR_HULL = frozenset({"hull", "hull.bow", "hull.pose"})


@dataclass(frozen=True)
class DiveRun:
    """An opened dive package, with the folder of its artifacts."""

    name: str  # dive.name of dive.toml
    chain: Chain  # its steps with their settings
    workspace: Workspace  # RUNS/<name>
    config: LoadedConfig | None = None  # dive.toml with the overrides

    @property
    def deliver(self) -> Path:
        """Folder of the deliverables, whether it exists yet or not."""
        return self.workspace.root / PUBLISHED


@dataclass(frozen=True, kw_only=True)
class RunResult:
    """A dive with what its run did, step by step."""

    dive: DiveRun
    outcomes: tuple[StepOutcome, ...]

    @property
    def deliver(self) -> Path:
        """Folder of the deliverables."""
        return self.dive.deliver

    @property
    def workspace(self) -> Workspace:
        """Folder of the run, RUNS/<dive>, with its artifacts."""
        return self.dive.workspace

    @property
    def is_delivered(self) -> bool:
        """Whether the deliverables are of this run, not of an earlier one."""
        return any(outcome.delivers for outcome in self.outcomes)

    @property
    def failure(self) -> Exception | None:
        """The error of the first step that failed alone, else of a deliverable, else None."""
        from hullrecon.steps.finished_run import failed_delivery

        failed = failed_delivery(self.workspace.root) if self.is_delivered else None
        return first_failure(self.outcomes) or failed


def open_dive(
    target: Path | str,
    runs: Path | str = "runs",
    overrides: Sequence[str] = (),
    *,
    allow_outside: bool = False,
) -> DiveRun:
    """Read the configuration of a dive package, or of the package that a run read last.

    Parameters
    ----------
    target
        Folder of the package, or of a run (RUNS/<dive>).
    runs
        Folder in which the dive's run has its own folder.
    overrides
        `section.key=value` in place of what dive.toml says.
    allow_outside
        Read also files outside the package that dive.toml names.

    Raises
    ------
    InputError
        The target is neither package nor run, or names files outside that are not allowed.
    UsageError
        The configuration is wrong.
    """
    from hullrecon.dive.config.load import FILE, load_config
    from hullrecon.dive.package_files import check_files
    from hullrecon.steps.chain import stages

    given = Path(target)
    workspace = Workspace(given) if Workspace(given).exists() else None
    package = given if workspace is None else package_of(workspace)
    steps = stages()
    read_before = {FILE: hash_file(package / FILE)} if (package / FILE).is_file() else {}
    config = load_config(package, {stage.name: stage.parameters for stage in steps}, overrides)
    check_files(
        config,
        allow_outside=allow_outside,
        trusted_keys=[text.partition("=")[0].strip() for text in overrides],
    )
    name = config.config.dive.name
    return DiveRun(
        name,
        Chain(steps, config.sections, package, read_before),
        workspace or Workspace(Path(runs) / name),
        config,
    )


def package_of(workspace: Workspace) -> Path:
    """Look up the package that a run read last. Raises InputError if the run does not record it."""
    package = workspace.package
    if package is None:
        raise InputError(
            "this run does not say which dive package it read",
            where=str(workspace.root),
            remedy="give the package's folder",
        )
    return package


def run(
    package: Path | str | DiveRun,
    runs: Path | str = "runs",
    *,
    last_step: str | None = None,
    overrides: Sequence[str] = (),
    jobs: int | None = None,
    scheduler: str | None = None,
    from_scratch: bool = False,
    read_data: bool = False,
    wait_s: float = 0.0,
    memory_gb: float | None = None,
    allow_outside: bool = False,
    progress: Progress | None = None,
    raise_failure: bool = True,
) -> RunResult:
    """Run every step of a dive that is out of date, and write the deliverables.

    Parameters
    ----------
    package, runs, overrides, allow_outside
        As for `open_dive`. An open dive is used as it is.
    last_step
        Stop after this step, and run only what it needs.
    jobs
        Worker processes inside a step, all usable cores if None. The results do not depend on it.
        With 1 all runs in this process, else each step in one of its own.
    scheduler
        Address of a Dask scheduler in place of worker processes.
    from_scratch
        Run every step, up to date or not.
    read_data
        Read every byte that a step depends on instead of trusting sizes and times.
    wait_s
        How long to wait for another run on this dive.
    memory_gb
        How much memory a run may take, half of the machine's if None. A dive that is predicted to
        take more is warned of once its package is read, and refused if it is twice as much. Two
        steps run beside each other only if both fit in it, and none do with one job.
    progress
        Shows how far each step is, nothing if None.
    raise_failure
        Raise the error of a step on which no other depends (a mosaic, say), once all else is
        delivered. If False, the error is in `RunResult.failure`.

    Returns
    -------
    RunResult
        What was done, step by step. The deliverables are in its `deliver`.

    Raises
    ------
    HullreconError
        The errors of hullrecon.errors: what is wrong, where and what to do.
    """
    _refuse_script_without_guard()
    dive = package
    if not isinstance(dive, DiveRun):
        dive = open_dive(dive, runs, overrides, allow_outside=allow_outside)
    _warn_of_defaults(dive)
    if scheduler is None and jobs is None:
        jobs = usable_cores()
    is_alone = scheduler is None and jobs == 1  # all in this process
    processes = nullcontext(begin_here) if is_alone else step_processes(PRELOAD)
    chain = dive.chain if last_step is None else dive.chain.up_to(last_step)
    forecast = _Forecast(
        dive=dive, memory_gb=memory_gb, beside=() if is_alone else tuple(chain.pairs_beside())
    )

    def prepare(plan: Sequence[StepStatus]) -> None:
        """Check what the steps to do need, before any of them begins, and plan their progress."""
        to_do = [s for s in plan if s.to_do or (from_scratch and s.state != "skipped")]
        if to_do and not is_alone:
            start_early(PRELOAD)
        _check_before_run(dive, to_do, jobs)
        forecast.outlook.plan(step.stage.name for step in to_do)

    with choose_executor(jobs or 1, scheduler) as executor, processes as begin_step:
        run_context = RunContext(
            dive.workspace.hashes(trusting=not read_data),
            executor,
            progress or Progress(),
            forecast.outlook,
            begin_step=begin_step,
            fit_together=forecast.fit_together,
        )
        outcomes = run_chain(
            chain,
            dive.workspace,
            run_context,
            from_scratch=from_scratch,
            wait_s=wait_s,
            preflight=prepare,
            before={"navigate": forecast.predict},
            keep_going=True,
        )
    result = RunResult(dive=dive, outcomes=tuple(outcomes))
    if raise_failure and result.failure is not None:
        raise result.failure
    return result


def evaluate(run: Path | str, package: Path | str) -> Score:
    """Score a run (RUNS/<dive> or its deliver/) against the truth of a simulated dive's package."""
    from hullrecon.evaluation.score import score_run

    return score_run(Path(run), Path(package))


def _refuse_script_without_guard() -> None:
    """Raise UsageError in a worker process that imports the user's script and finds `run` in it.

    A spawned process imports the main module. Without a guard there it would start the same run
    again, and its end would look as if memory had run out.
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise UsageError(
            "a worker process that imports this script would start its run again",
            remedy='put the call of hullrecon.run below `if __name__ == "__main__":`',
        )


def _warn_of_defaults(dive: DiveRun) -> None:
    """Log a warning for each lever arm, mount and calibration that dive.toml leaves open."""
    from hullrecon.dive.check.requirements import configured_sensors, to_fill_in

    if dive.config is not None:
        for finding in to_fill_in(dive.config, configured_sensors(dive.config)):
            log.warning("%s", finding.sentence)


def _check_before_run(dive: DiveRun, to_do: Sequence[StepStatus], jobs: int | None) -> None:
    """Log what is to be done, and find errors early that would end the run hours later.

    Raises InputError for a `hull.bow` that the CAD model does not have, a `hull.pose` far from the
    dive and another `hull.length_overall`, as steps only use the CAD model after hours of comparing
    images. Raises StorageError if the disk is too full: a step is built next to its old artifact,
    so about that much space must be free.
    """
    names = ", ".join(step.stage.name for step in to_do)
    log.info("%s: %s", dive.name, f"to do: {names}" if to_do else "everything is up to date")
    if to_do and jobs is not None:
        log.info("%s: %d worker process%s (--jobs)", dive.name, jobs, "" if jobs == 1 else "es")
    if any(ASKS_FOR_HULL & set(step.stage.uses) for step in to_do):
        _refuse_wrong_hull(dive)
    manifests = [step.manifest for step in to_do if step.manifest is not None]
    needed = sum(file.size for manifest in manifests for file in manifest.outputs.values())
    _refuse_full_disk(dive, needed, "the last run's artifacts took")


@dataclass(kw_only=True)
class _Forecast:
    """What a run is expected to take, by the size of its dive. Known once the package is read."""

    dive: DiveRun
    memory_gb: float | None  # that the run may take
    beside: tuple[tuple[str, str], ...]  # steps that could run at the same time
    outlook: RunOutlook = field(default_factory=RunOutlook)
    costs: list[StepCost] = field(default_factory=list)  # of the steps to do

    def predict(self) -> None:
        """Predict and log the costs of the steps to do, by the size of the dive.

        Raises InputError for too little memory, as `check` would, StorageError for too little disk.
        """
        if not self.outlook.steps:
            return
        from hullrecon.api.costs import findings_of, predict, size_of_run

        self.costs = predict(size_of_run(self.dive.workspace.root), self.outlook.steps)
        self.outlook.predict({cost.step: cost.seconds for cost in self.costs})
        for finding in findings_of(self.costs, self.memory_gb, self.beside):
            if finding.severity == "error":
                raise InputError(finding.sentence)
            level = logging.WARNING if finding.severity == "warning" else logging.INFO
            log.log(level, "%s: %s", self.dive.name, finding.sentence)
        needed = 1e6 * sum(cost.disk_mb for cost in self.costs)
        _refuse_full_disk(self.dive, needed, "the artifacts take about")

    def fit_together(self, steps: Collection[str]) -> bool:
        """Decide whether steps may run at the same time. False before costs are predicted."""
        if not self.costs:
            return False
        from hullrecon.api.costs import fit_together

        return fit_together(steps, self.costs, self.memory_gb)


def _refuse_full_disk(dive: DiveRun, needed: float, why: str) -> None:
    """Raise StorageError if less than `needed` bytes are free. `why` begins the remedy."""
    free = shutil.disk_usage(dive.workspace.root).free
    if needed > free:
        raise StorageError(
            f"only {free / 1e6:.0f} MB are free",
            where=str(dive.workspace.root),
            remedy=f"{why} {needed / 1e6:.0f} MB: free some space, or"
            " choose another folder with --runs",
        )


def _refuse_wrong_hull(dive: DiveRun) -> None:
    """Raise InputError for a CAD model that cannot be the ship's where hull.pose has it.

    Its pose is far from the dive, its length is not the stated one, or it lacks the bow's axis.
    """
    from hullrecon.dive.check.hull_checks import check_length, describe_bow, refuse_far_hull
    from hullrecon.dive.config.schema import Hull
    from hullrecon.dive.hull.load import read_hull

    hull = dive.chain.sections.get("hull")
    if isinstance(hull, Hull):
        mesh = read_hull(dive.chain.package / hull.mesh, hull.units, [])
        refuse_far_hull(hull, mesh)
        check_length(hull, mesh)
        describe_bow(hull, mesh)
