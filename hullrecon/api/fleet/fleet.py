# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run every dive of a folder that is new or out of date, each in a process of its own."""

from __future__ import annotations

import logging
import math
import os
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

from hullrecon.api.fleet.index_page import FleetIndex
from hullrecon.api.fleet.outcome import FleetDive, FleetResult, State
from hullrecon.api.fleet.packages import (
    MADE_BY_RUNS,
    Listing,
    Skipped,
    as_utf8,
    dive_names,
    list_folder,
    program_signature,
    require_packages,
)
from hullrecon.api.fleet.processes import Ended, run_each
from hullrecon.api.fleet.records import FOLDER, DiveRecord, FleetRecords, Terms
from hullrecon.artifacts.disk import make_folder
from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.machine import usable_cores
from hullrecon.artifacts.progress import Progress
from hullrecon.artifacts.workspace import PUBLISHED, hold_lock
from hullrecon.errors import HullreconError, LockedError, StageError, UsageError

log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class PlannedDive:
    """A package of a fleet before it is run."""

    package: Path  # absolute
    name: str | None  # of the dive, None if dive.toml is not valid
    listing: Listing
    to_do: str = ""  # why it is to be run, empty if it is not
    refused: HullreconError | None = None  # why it may not be run
    record: DiveRecord | None = None  # how it ended last, None if unknown


def preview_fleet(
    dives: Path | str,
    runs: Path | str = "runs",
    *,
    retry: bool = False,
    allow_outside: bool = False,
    time_limit_s: float | None = None,
) -> FleetResult:
    """Plan what `run_fleet` would do with the same arguments, without changing anything.

    Raises InputError if there is no package.
    """
    terms = Terms(allow_outside=allow_outside, time_limit_s=time_limit_s)
    return _Fleet(dives, runs, retry=retry, terms=terms).result()


def run_fleet(
    dives: Path | str,
    runs: Path | str = "runs",
    *,
    jobs: int = 1,
    scheduler: str | None = None,
    retry: bool = False,
    progress: Progress | None = None,
    on_failure: Callable[[FleetDive], None] | None = None,
    allow_outside: bool = False,
    time_limit_s: float | None = None,
) -> FleetResult:
    """Bring every dive package in the folder `dives` up to date, as `hullrecon fleet` does.

    Parameters
    ----------
    dives
        Folder of the packages.
    runs
        Folder of the results.
    jobs
        Dives at a time. Each has its share of the cores.
    scheduler
        Address of a Dask scheduler in place of the cores.
    retry
        Run also dives that failed before and have not changed since.
    progress
        Shows how many dives have ended, nothing if None.
    on_failure
        Called with each dive that has failed.
    allow_outside
        Read also files outside the packages.
    time_limit_s
        A dive that takes longer is ended and counts as failed.

    Raises
    ------
    LockedError
        Another fleet works for these runs.
    InputError
        There is no package.
    UsageError
        Results would lie among the packages.
    StorageError
        RUNS cannot be written. A dive that fails raises nothing.
    """
    terms = Terms(allow_outside=allow_outside, time_limit_s=time_limit_s)
    out = Path(os.path.realpath(runs))
    require_packages(
        Path(os.path.realpath(dives)), out
    )  # raises for a wrong folder before any writing
    with _lock(out):
        # Plan, and note the dives that need no run.
        fleet = _Fleet(dives, runs, retry=retry, terms=terms, on_failure=on_failure)
        to_do = {dive.package: dive for dive in fleet.planned if dive.to_do}
        if scheduler is not None and to_do:
            choose_executor(scheduler=scheduler).close()  # raises if no scheduler answers
        for dive in fleet.planned:
            if not dive.to_do:
                fleet.note(dive, fleet.done[dive.package])
        log.info("%d of %d dives to run", len(to_do), len(fleet.planned))

        # Run the others, each in a process. The page shows how far they are.
        cores = max(1, usable_cores() // jobs)
        commands = {p: _command(dive, out, scheduler, terms, cores) for p, dive in to_do.items()}
        index, running = FleetIndex(out), set[Path]()

        def start(package: Path) -> None:
            running.add(package)
            index.write(fleet.done.values(), running)

        limit_s = time_limit_s or math.inf
        try:
            with closing(run_each(commands, jobs, out / FOLDER, limit_s, start)) as ended:
                for package, end in (progress or Progress()).track(ended, "dives", len(commands)):
                    running.remove(package)
                    fleet.end(to_do[package], end)
                    index.forget(to_do[package].name)
                    index.write(fleet.done.values(), running)
        finally:
            if to_do or not index.exists():  # a call that finds nothing to do reads no results
                index.write(fleet.done.values())
        return fleet.result()


class _Fleet:
    """The dives of one call: the plan, and the state of each."""

    def __init__(
        self,
        dives: Path | str,
        runs: Path | str,
        *,
        retry: bool,
        terms: Terms,
        on_failure: Callable[[FleetDive], None] | None = None,
    ) -> None:
        """Read the folder of dives and the records of earlier calls, and plan. Changes nothing."""
        self.dives, self.runs = Path(os.path.realpath(dives)), Path(os.path.realpath(runs))
        self._terms, self._on_failure = terms, on_failure
        self._program = program_signature()
        self._records = FleetRecords(self.runs)
        packages, self._skipped = require_packages(self.dives, self.runs)
        self.planned = self._plan(packages, retry)
        self._records.forget_all_but(self.dives, packages)
        self.done = {dive.package: self._initial_state(dive) for dive in self.planned}

    def _plan(self, packages: list[Path], retry: bool) -> list[PlannedDive]:
        """Read the dives' names, and decide of each dive whether it is run, and why.

        Pipes, sockets and devices in a package are added to what is skipped.
        """
        names, refused = dive_names(packages, self.dives, self.runs)
        planned = []
        for package in packages:
            listing = list_folder(package, self.dives)
            for name, kind in listing.special:
                self._skipped.append(Skipped(path=package / name, reason=f"{kind}, not opened"))
            dive = PlannedDive(
                package=package,
                name=names.get(package),
                listing=listing,
                refused=refused.get(package),
                record=self._records.get(package),
            )
            if dive.refused is None:
                dive = replace(dive, to_do=self._why_run(dive, retry))
            planned.append(dive)
        return planned

    def _why_run(self, dive: PlannedDive, retry: bool) -> str:
        """Say why a dive is to be run. Empty if its last result or failure is still valid."""
        record = dive.record
        if record is None:
            return "new"
        if (record.package, record.name) != (dive.listing.signature, dive.name):
            return "the package changed"
        if record.program != self._program:
            return "hullrecon changed"
        if record.exit_code:
            return "it failed before" if retry or not record.is_likely_to_recur(self._terms) else ""
        return "" if record.result == self._result_signature(dive) else "the result changed"

    def _result_signature(self, dive: PlannedDive) -> str:
        """Hash names, sizes and times of the files of a dive's run. Empty without a name."""
        if dive.name is None:
            return ""
        folder = self.runs / dive.name
        return list_folder(folder, folder, MADE_BY_RUNS).signature

    def _initial_state(self, dive: PlannedDive) -> FleetDive:
        """Describe a dive before this call has run any: to do, refused, or as it ended last."""
        record = dive.record
        if dive.refused is not None:
            code, reason = dive.refused.exit_code, dive.refused.line()
            known = _is_known(record, code, reason)
            return self._dive(dive, "failed", code, reason, known=known)
        if dive.to_do or record is None:
            return self._dive(dive, "to do", None, dive.to_do)
        state: State = "failed" if record.exit_code else "up to date"
        early = record.refused or record.time_limit_s is not None
        return self._dive(
            dive, state, record.exit_code, record.reason, known=True, ended_early=early
        )

    def end(self, dive: PlannedDive, ended: Ended) -> None:
        """Note the state of a dive whose process has ended."""
        path = _log_file(dive, self.runs)
        with suppress(FileNotFoundError):
            if path.stat().st_size == 0:
                path.unlink()
        name = dive.package.name
        log.debug("%s ended with exit code %d after %.1f s", name, ended.exit_code, ended.seconds)
        code, reason = ended.exit_code, ended.reason
        if dive.name is None and code == 0:  # the command was to say what is wrong in dive.toml
            code, reason = UsageError.exit_code, "its dive.toml changed while it was read"
        now = self._dive(
            dive,
            "failed" if code else "delivered",
            code,
            reason,
            ran=True,
            known=_is_known(dive.record, code, reason),
            ended_early=ended.timed_out,
        )
        self.done[dive.package] = now
        self.note(dive, now, timed_out=ended.timed_out)

    def note(self, dive: PlannedDive, now: FleetDive, *, timed_out: bool = False) -> None:
        """Record the state of a dive if it is new, and report a failure."""
        if now.exit_code is not None and (now.ran or not now.known):
            record = DiveRecord(
                name=dive.name,
                package=dive.listing.signature,
                result=self._result_signature(dive),
                program=self._program,
                exit_code=now.exit_code,
                reason=as_utf8(now.reason),
                refused=dive.refused is not None,
                ended_s=time.time(),
                allow_outside=self._terms.allow_outside,
                time_limit_s=self._terms.time_limit_s if timed_out else None,
            )
            self._records.put(dive.package, record)
        if now.state == "failed" and self._on_failure is not None:
            self._on_failure(now)

    def _dive(
        self,
        dive: PlannedDive,
        state: State,
        code: int | None,
        reason: str,
        *,
        ran: bool = False,
        known: bool = False,
        ended_early: bool = False,
    ) -> FleetDive:
        """Describe a dive. If its run ended early, deliver/ is not from that run.

        ran: in this call. known: it ended in the same way the last time.
        """
        path = _log_file(dive, self.runs)
        # After a step that fails alone, such as a mosaic, all else is delivered.
        is_whole = code == 0 or (code == StageError.exit_code and not ended_early)
        return FleetDive(
            package=dive.package,
            name=dive.name,
            state=state,
            exit_code=code,
            reason=reason,
            ran=ran,
            known=known,
            files=dive.listing.files,
            log=path if dive.name is not None and path.is_file() else None,
            delivered=is_whole
            and dive.name is not None
            and (self.runs / dive.name / PUBLISHED).is_dir(),
        )

    def result(self) -> FleetResult:
        """Collect how every dive stands now."""
        return FleetResult(
            dives_folder=self.dives,
            runs=self.runs,
            dives=tuple(self.done.values()),
            skipped=tuple(self._skipped),
        )


def _is_known(record: DiveRecord | None, code: int, reason: str) -> bool:
    """Decide whether a dive ended in the same way the last time."""
    return record is not None and (record.exit_code, record.reason) == (code, reason)


@contextmanager
def _lock(runs: Path) -> Iterator[None]:
    """Hold the lock of all fleets of these runs. Raises LockedError if another fleet holds it."""
    try:
        with hold_lock(runs / FOLDER / "lock"):
            yield
    except LockedError as error:
        what = error.what.replace("dive is", "another fleet is at work here:")
        raise LockedError(what, where=str(runs), remedy="wait for it to end") from None


def _command(
    dive: PlannedDive, runs: Path, scheduler: str | None, terms: Terms, cores: int
) -> list[str]:
    """Build the arguments of hullrecon that run a dive, or that say what is wrong in its dive.toml.

    The dive's name is given as an argument: it was compared with those of all other dives, and
    dive.toml may have changed since.
    """
    if dive.name is None:
        return ["status", str(dive.package), "--runs", str(runs)]
    path = _log_file(dive, runs)
    make_folder(path.parent)
    path.unlink(missing_ok=True)
    options = {
        "--runs": str(runs),
        "--set": f'dive.name="{dive.name}"',
        "--log-file": str(path),
        **({"--jobs": str(cores)} if scheduler is None else {"--scheduler": scheduler}),
    }
    more = ["--allow-outside"] if terms.allow_outside else []
    return ["run", str(dive.package), *(word for o in options.items() for word in o), *more]


def _log_file(dive: PlannedDive, runs: Path) -> Path:
    return runs / FOLDER / "logs" / f"{dive.name}.log"
