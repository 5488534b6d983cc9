# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run every dive of a folder that is new or whose result is out of date, each in a process of its
own.
"""

from __future__ import annotations

import logging
import math
import os
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from hullrecon.api.fleet.index_page import FleetIndex
from hullrecon.api.fleet.outcome import FleetDive, FleetResult, State
from hullrecon.api.fleet.plan import (
    PlannedDive,
    RunTerms,
    packages_for,
    plan_fleet,
    result_signature,
)
from hullrecon.api.fleet.processes import Ended, run_each
from hullrecon.api.fleet.records import FOLDER, DiveRecord, FleetRecords
from hullrecon.api.fleet.text import as_utf8
from hullrecon.artifacts.disk import make_folder
from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.progress import Progress
from hullrecon.artifacts.workspace import PUBLISHED, hold_lock
from hullrecon.errors import LockedError, StageError, UsageError

log = logging.getLogger(__name__)


def run_fleet(
    dives: Path | str, runs: Path | str = "runs", *, jobs: int = 1, scheduler: str | None = None, retry: bool = False,
    progress: Progress | None = None, on_failure: Callable[[FleetDive], None] | None = None, allow_outside: bool = False,
    time_limit_s: float | None = None,
) -> FleetResult:  # fmt: skip
    """Bring every dive package in the folder `dives` up to date in RUNS, as `hullrecon fleet` does;
    return how each stands.

    jobs: dives at a time. scheduler: address of a Dask scheduler for all of them. retry: run also
    what failed before and has not changed since. on_failure: called with each failed dive, as it
    fails. allow_outside: dives may read files outside their packages. time_limit_s: a dive that
    takes longer is ended and has failed. Raises LockedError when another fleet works for these
    runs, InputError when there is no package, StorageError when RUNS cannot be written; for a
    failed dive nothing.
    """
    terms = RunTerms(allow_outside=allow_outside, time_limit_s=time_limit_s)
    here, out = Path(os.path.realpath(dives)), Path(os.path.realpath(runs))
    packages_for(here, out)  # a wrong folder is said before anything is written
    with _lock(out):
        records = FleetRecords(out)
        memory = _Memory(records=records, runs=out, terms=terms, on_failure=on_failure)
        planned, skipped = plan_fleet(here, out, records, retry=retry, terms=terms)
        records.forget_all_but(here, [dive.package for dive in planned])
        to_do = {dive.package: dive for dive in planned if dive.to_do}
        if scheduler is not None and to_do:
            with choose_executor(scheduler=scheduler):  # an address where nobody answers ends here
                pass
        done = {dive.package: _fleet_dive(dive, out) for dive in planned}
        for dive in planned:
            if not dive.to_do:
                _note(dive, done[dive.package], memory)
        log.info("%d of %d dives to run", len(to_do), len(planned))
        commands = {
            package: _command(dive, out, scheduler, terms) for package, dive in to_do.items()
        }
        index, running = FleetIndex(out), set[Path]()

        def start(package: Path) -> None:
            running.add(package)
            index.write(done.values(), running)

        try:
            with closing(
                run_each(commands, jobs, out / FOLDER, time_limit_s or math.inf, start)
            ) as ended:
                for package, end in (progress or Progress()).track(ended, "dives", len(commands)):
                    running.remove(package)
                    done[package] = _outcome(to_do[package], end, out)
                    _note(to_do[package], done[package], memory, timed_out=end.timed_out)
                    index.forget(to_do[package].name)
                    index.write(done.values(), running)
        finally:
            if to_do or not index.exists():  # a call that finds nothing to do reads no results
                index.write(done.values())
    return FleetResult(
        dives_folder=here, runs=out, dives=tuple(done.values()), skipped=tuple(skipped)
    )


def preview_fleet(
    dives: Path | str, runs: Path | str = "runs", *, retry: bool = False, allow_outside: bool = False,
    time_limit_s: float | None = None,
) -> FleetResult:  # fmt: skip
    """Return what `run_fleet` would do, without changing anything. Raises InputError when there is
    no package.
    """
    here, out = Path(os.path.realpath(dives)), Path(os.path.realpath(runs))
    terms = RunTerms(allow_outside=allow_outside, time_limit_s=time_limit_s)
    planned, skipped = plan_fleet(here, out, FleetRecords(out), retry=retry, terms=terms)
    return FleetResult(
        dives_folder=here,
        runs=out,
        dives=tuple(_fleet_dive(dive, out) for dive in planned),
        skipped=tuple(skipped),
    )


@contextmanager
def _lock(runs: Path) -> Iterator[None]:
    """Hold the lock of all fleets of these runs. Raises LockedError when another has it."""
    try:
        with hold_lock(runs / FOLDER / "lock"):
            yield
    except LockedError as error:
        what = error.what.replace("dive is", "another fleet is at work here:")
        raise LockedError(what, where=str(runs), remedy="wait for it to end") from None


def _command(dive: PlannedDive, runs: Path, scheduler: str | None, terms: RunTerms) -> list[str]:
    """Return the arguments that run a dive; those that explain what is wrong with its dive.toml
    where it tells no name.

    The name is that which was compared with all others', should dive.toml change meanwhile.
    """
    if dive.name is None:
        return ["status", str(dive.package), "--runs", str(runs)]
    path = _log_file(dive, runs)
    make_folder(path.parent)
    path.unlink(missing_ok=True)
    more = [] if scheduler is None else ["--scheduler", scheduler]
    more += ["--allow-outside"] if terms.allow_outside else []
    named = f'dive.name="{dive.name}"'
    return [
        "run",
        str(dive.package),
        "--runs",
        str(runs),
        "--set",
        named,
        "--log-file",
        str(path),
        *more,
    ]


def _log_file(dive: PlannedDive, runs: Path) -> Path:
    return runs / FOLDER / "logs" / f"{dive.name}.log"


def _outcome(dive: PlannedDive, ended: Ended, runs: Path) -> FleetDive:
    """Return how a dive stands whose process has ended; an empty log is removed."""
    path = _log_file(dive, runs)
    with suppress(FileNotFoundError):
        if path.stat().st_size == 0:
            path.unlink()
    log.debug(
        "%s ended with exit code %d after %.1f s", dive.package.name, ended.exit_code, ended.seconds
    )
    code, reason = ended.exit_code, ended.reason
    if dive.name is None and code == 0:
        code, reason = UsageError.exit_code, "its dive.toml changed while it was read"
    known = dive.record is not None and (dive.record.exit_code, dive.record.reason) == (
        code,
        reason,
    )
    state: State = "failed" if code else "delivered"
    return _dive(
        dive, runs, state, code, reason, ran=True, known=known, ended_early=ended.timed_out
    )


def _fleet_dive(dive: PlannedDive, runs: Path) -> FleetDive:
    """Return how a dive stands that is not run, or not yet."""
    record = dive.record
    if dive.refused is not None:
        code, reason = dive.refused.exit_code, dive.refused.line()
        known = record is not None and (record.exit_code, record.reason) == (code, reason)
        return _dive(dive, runs, "failed", code, reason, known=known)
    if dive.to_do or record is None:
        return _dive(dive, runs, "to do", None, dive.to_do)
    state: State = "failed" if record.exit_code else "up to date"
    ended_early = record.refused or record.time_limit_s is not None
    return _dive(
        dive, runs, state, record.exit_code, record.reason, known=True, ended_early=ended_early
    )


def _dive(
    dive: PlannedDive, runs: Path, state: State, code: int | None, reason: str, *, ran: bool = False, known: bool = False,
    ended_early: bool = False,
) -> FleetDive:  # fmt: skip
    """Return how a dive stands. ended_early: its run did not come to its end; one that fails there
    withdraws what was delivered before, but for a step that fails alone.
    """
    path = _log_file(dive, runs)
    is_whole = state in ("delivered", "up to date") or (
        code == StageError.exit_code and not ended_early
    )
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
        delivered=is_whole and dive.name is not None and (runs / dive.name / PUBLISHED).is_dir(),
    )


@dataclass(frozen=True, kw_only=True)
class _Memory:
    """Where it is noted how a dive stands, under which terms it was run, and who is told of a
    failure.
    """

    records: FleetRecords
    runs: Path
    terms: RunTerms
    on_failure: Callable[[FleetDive], None] | None


def _note(dive: PlannedDive, now: FleetDive, memory: _Memory, *, timed_out: bool = False) -> None:
    """Remember how a dive stands where that is new, and report a failure."""
    if now.exit_code is not None and (now.ran or not now.known):
        record = DiveRecord(
            name=dive.name,
            package=dive.listing.signature,
            result=result_signature(memory.runs, dive.name),
            program=dive.program,
            exit_code=now.exit_code,
            reason=as_utf8(now.reason),
            refused=dive.refused is not None,
            ended_s=time.time(),
            allow_outside=memory.terms.allow_outside,
            time_limit_s=memory.terms.time_limit_s if timed_out else None,
        )
        memory.records.put(dive.package, record)
    if now.state == "failed" and memory.on_failure is not None:
        memory.on_failure(now)
