# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""`hullrecon.init` and `hullrecon.check`: write the dive.toml of a package, and check a package."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from hullrecon.api.costs import findings_of, predict, size_of
from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.disk import storage_errors, write_file
from hullrecon.artifacts.progress import Progress
from hullrecon.dive.check.package_check import check_package
from hullrecon.dive.check.package_report import PackageCheck
from hullrecon.dive.check.requirements import to_fill_in
from hullrecon.dive.config.load import FILE, LoadedConfig, load_config
from hullrecon.dive.init.log_summary import LogSummary, guess_topics, summarise_logs
from hullrecon.dive.init.proposals import missing_calibrations, questions
from hullrecon.dive.init.template import fill_template
from hullrecon.dive.logs.formats.stamps import ASSUMED
from hullrecon.dive.logs.read_streams import Watch
from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.dive.package_files import check_files, check_log, lies_inside
from hullrecon.errors import InputError, UsageError
from hullrecon.findings.finding import Finding
from hullrecon.findings.package import A_RUN_NEEDS
from hullrecon.steps.chain import stages
from hullrecon.steps.ingest import ingest_settings, request_of
from hullrecon.steps.path_check import check_path
from hullrecon.steps.sensor_check import check_sensors
from hullrecon.steps.stereo_check import check_sampled_rig


@dataclass(frozen=True, kw_only=True)
class InitResult:
    """What `init` read and wrote."""

    log: LogSummary  # what the logs hold
    folder: Path  # the package
    calibrations: list[Path]  # camera calibrations that were written
    dive_toml: Path  # the file that was written
    to_fill_in: list[Finding]  # what the user has to add, as no log says it


def init(
    log: Path | str,
    out: Path | str | None = None,
    *,
    force: bool = False,
    allow_outside: bool = False,
) -> InitResult:
    """Write a commented dive.toml by looking into a log.

    Parameters
    ----------
    log
        A file, or a folder with a log.
    out
        The package's folder. If None, the log if that is a folder, else the current folder.
    force
        Replace a dive.toml that is there.
    allow_outside
        Read also log files to which links in the folder of the log lead outside it.

    Raises
    ------
    InputError
        There is no log, or nothing can be read of it.
    UsageError
        A dive.toml exists already.
    """
    log = Path(log)
    logs = _find_logs(log, allow_outside)
    _require_utf8([log, *logs])
    found = summarise_logs([open_log(path, clock=ASSUMED) for path in logs])
    if not found.topics:
        raise InputError(found.why_nothing(), where=str(log), remedy=A_RUN_NEEDS)
    folder = Path(out) if out is not None else (log if log.is_dir() else Path())
    path = folder / FILE
    if path.exists() and not force:
        raise UsageError(
            f"{FILE} is there already", where=str(folder), remedy="--force replaces it"
        )
    with storage_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        calibrations = missing_calibrations(found, folder)
        if calibrations:
            (folder / "calibration").mkdir(exist_ok=True)
    for name, text in calibrations.items():
        write_file(folder / name, text.encode())
    write_file(path, fill_template(found, logs, folder).encode())
    outside = [] if allow_outside else [path for path in logs if not lies_inside(path, folder)]
    return InitResult(
        log=found,
        folder=folder,
        calibrations=[folder / name for name in calibrations],
        dive_toml=path,
        to_fill_in=[
            *to_fill_in(load_config(folder), guess_topics(found.topics).keys(), frozenset()),
            *(Finding("log-outside", {"file": str(file)}) for file in outside),
            *questions(found),
            *(Finding("calibration-in-water", {"file": name}) for name in calibrations),
        ],
    )


def check(
    package: Path | str, *, allow_outside: bool = False, progress: Progress | None = None
) -> PackageCheck:
    """Read a whole package, and list what it holds, what it lacks and what cannot be used.

    Raises UsageError for a mistake in dive.toml, InputError if there is no dive.toml.
    """
    loaded = load_config(Path(package), {stage.name: stage.parameters for stage in stages()})
    return check_loaded(loaded, allow_outside=allow_outside, progress=progress)


def check_loaded(
    loaded: LoadedConfig,
    *,
    allow_outside: bool = False,
    trusted_keys: Sequence[str] = (),
    memory_gb: float | None = None,
    progress: Progress | None = None,
) -> PackageCheck:
    """Check the package of a configuration, and predict what its run would cost.

    Parameters
    ----------
    loaded
        The configuration.
    allow_outside
        Read also files outside the package.
    trusted_keys
        Keys that were set by the caller, not by the package: their files may lie outside.
    memory_gb
        As for `hullrecon.run`.
    progress
        Shows how many messages were read, nothing if None.
    """
    check_files(loaded, allow_outside=allow_outside, trusted_keys=trusted_keys)
    request = request_of(ingest_settings(loaded))
    watch: Watch = iter
    if progress is not None:
        watch = partial(progress.track, label="check: messages", total=None)
    checked = check_package(loaded, request, watch, check_sampled_rig, check_sensors, check_path)
    if checked.reasons:
        return checked
    found, chain = checked.found, Chain(stages(), loaded.sections, loaded.package)
    size = size_of(found.images, found.cameras, found.records.sonar)
    steps = [stage.name for stage in chain.stages if stage.name not in chain.skip_reasons()]
    costs = findings_of(predict(size, steps), memory_gb, chain.pairs_beside())
    return replace(checked, costs=costs)


def summarise(path: Path | str, *, allow_outside: bool = False) -> LogSummary:
    """Summarise a bare log, or the logs of a folder without a dive.toml."""
    return summarise_logs(
        [open_log(log, clock=ASSUMED) for log in _find_logs(Path(path), allow_outside)]
    )


def _find_logs(path: Path, allow_outside: bool) -> list[Path]:
    """Find the logs of a path. Raises InputError for special files, and those outside of it."""
    logs = find_logs(path)
    for log in logs if path.is_dir() else ():
        check_log(log, path, allow_outside=allow_outside)
    return logs


def _require_utf8(paths: list[Path]) -> None:
    """Raise InputError for a name that dive.toml, which is UTF-8, cannot hold."""
    for path in paths:
        try:
            str(path).encode()
        except UnicodeEncodeError:
            raise InputError(
                "the name is not UTF-8, and dive.toml could not tell it",
                where=os.fsencode(path).decode(errors="replace"),
                remedy="rename it",
            ) from None
