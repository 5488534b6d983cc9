# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Say of each dive of a folder whether it has to be run, and why, without opening anything but its
dive.toml.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from hullrecon.api.fleet.listing import MADE_BY_RUNS, Listing, list_folder, program_signature
from hullrecon.api.fleet.packages import FILE, Skipped, find_packages, read_name, same_names
from hullrecon.api.fleet.records import DiveRecord, FleetRecords
from hullrecon.errors import HullreconError, InputError, UsageError


@dataclass(frozen=True, kw_only=True)
class RunTerms:
    """What a dive of a fleet may do. allow_outside: read files outside its package; time_limit_s:
    None for no limit.
    """

    allow_outside: bool = False
    time_limit_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class PlannedDive:
    """A package of a fleet. package: absolute path; name: of the dive, None where dive.toml does
    not tell; to_do: why it is run, empty where it is not; refused: why it may not be; record: how
    it ended last, None where unknown.
    """

    package: Path
    name: str | None
    listing: Listing
    program: str
    to_do: str = ""
    refused: HullreconError | None = None
    record: DiveRecord | None = None


def plan_fleet(
    dives: Path,
    runs: Path,
    records: FleetRecords,
    *,
    retry: bool = False,
    terms: RunTerms = RunTerms(),
) -> tuple[list[PlannedDive], list[Skipped]]:
    """Return every package in `dives`, by name, and what is skipped. retry: run also what failed
    and has not changed since.

    Raises InputError when there is no package, UsageError when results would lie among packages.
    """
    packages, skipped = packages_for(dives, runs)
    names, refused = _names(packages, dives, runs)
    program, planned = program_signature(), list[PlannedDive]()
    for package in packages:
        listing = list_folder(package, dives)
        skipped += [
            Skipped(path=package / name, reason=f"{kind}, not opened")
            for name, kind in listing.special
        ]
        dive = PlannedDive(
            package=package,
            name=names.get(package),
            listing=listing,
            program=program,
            refused=refused.get(package),
            record=records.get(package),
        )
        planned.append(
            dive if dive.refused else replace(dive, to_do=_why_run(dive, runs, retry, terms))
        )
    return planned, skipped


def packages_for(dives: Path, runs: Path) -> tuple[list[Path], list[Skipped]]:
    """Return the packages in `dives` and what is skipped. Raises as `plan_fleet` does."""
    packages, skipped = find_packages(dives)
    if not packages:
        remedy = (
            f"this is a package itself: `hullrecon run {dives}`" if (dives / FILE).exists() else ""
        )
        raise InputError(
            f"no dive package (a folder with a {FILE}) lies here", where=str(dives), remedy=remedy
        )
    if runs == dives or any(runs.is_relative_to(package) for package in packages):
        raise UsageError(
            "results would lie among the packages",
            where=str(runs),
            remedy="choose another folder with --runs",
        )
    return packages, [s for s in skipped if s.path != runs]


def _names(
    packages: list[Path], dives: Path, runs: Path
) -> tuple[dict[Path, str | None], dict[Path, HullreconError]]:
    """Return the dives' names, and the packages that may not be run."""
    names, refused = dict[Path, str | None](), dict[Path, HullreconError]()
    for package in packages:
        try:
            name = names[package] = read_name(package, dives)
        except HullreconError as error:
            refused[package] = error
            continue
        if name is not None and dives.is_relative_to(runs / name):
            what = f"the results of a dive called {name} would lie above the packages"
            refused[package] = UsageError(
                what, where=str(package), remedy="choose another folder with --runs"
            )
    for package, others in same_names(names):
        named = ", ".join(other.name for other in others)
        what = f"its dive.name {names[package]} is also that of {named}"
        refused[package] = UsageError(
            what, where=str(package), remedy="give each dive a name of its own"
        )
    return names, refused


def _why_run(dive: PlannedDive, runs: Path, retry: bool, terms: RunTerms) -> str:
    """Return why a dive is run; empty where its last result or failure stands."""
    record = dive.record
    if record is None:
        return "new"
    if (record.package, record.name) != (dive.listing.signature, dive.name):
        return "the package changed"
    if record.program != dive.program:
        return "hullrecon changed"
    if record.exit_code and _may_more(record, terms):
        return "it may do more than when it failed"
    if record.exit_code:
        return "" if record.holds and not retry else "it failed before"
    return "" if record.result == result_signature(runs, dive.name) else "the result changed"


def _may_more(record: DiveRecord, terms: RunTerms) -> bool:
    """Return whether a dive that failed may read more now, or was ended by a limit that is gone or
    larger now.
    """
    more_time = record.time_limit_s is not None and (
        terms.time_limit_s is None or terms.time_limit_s > record.time_limit_s
    )
    return more_time or (terms.allow_outside and not record.allow_outside)


def result_signature(runs: Path, name: str | None) -> str:
    """Return the signature of a dive's artifacts and deliverables, whether they are there or not."""
    return "" if name is None else list_folder(runs / name, runs / name, MADE_BY_RUNS).signature
