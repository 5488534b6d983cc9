# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""init and check: what concerns a dive package as such."""

from __future__ import annotations

from pathlib import Path

import click

from hullrecon.errors import InputError, UsageError

from .dives import CONFIGURATION, FOLDER, set_option
from .state import state_of


@click.command()
@click.argument("log", type=FOLDER)
@click.option("--out", type=FOLDER, help="the package's folder  [default: LOG where it is a folder, else the current one]")
@click.option("--force", is_flag=True, help=f"replace a {CONFIGURATION} that is there")
def init(log: Path, out: Path | None, force: bool) -> None:
    """Write a commented dive.toml by looking into LOG, a file or a folder with one."""
    from hullrecon.artifacts.storage.disk import storage_errors, write_file
    from hullrecon.dive.check.to_fill_in import to_fill_in
    from hullrecon.dive.config.config_template import beams_to_ask_for, first_config
    from hullrecon.dive.config.load import load_config
    from hullrecon.dive.logs.dvl_beams import ask_for_beams
    from hullrecon.dive.logs.readers.open import find_logs, open_log
    from hullrecon.dive.logs.summary import guess_topics, survey_all

    logs = find_logs(log)
    found = survey_all([open_log(path) for path in logs])
    if not found.topics:
        raise InputError("nothing could be read of the log", where=str(log))
    folder = out or (log if log.is_dir() else Path())
    path = folder / CONFIGURATION
    if path.exists() and not force:
        raise UsageError(f"{CONFIGURATION} is there already", where=str(folder), remedy="--force replaces it")
    with storage_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
    write_file(path, first_config(found, logs, folder).encode())
    unknown = to_fill_in(load_config(folder), guess_topics(found.topics).keys())
    beams = beams_to_ask_for(found)
    unknown += [f"to fill in: {ask_for_beams(beams).line()}"] if beams else []
    lines = [*found.lines(), f"wrote {path}", *unknown, f"next: read it through, then `hullrecon check {folder}`"]
    state_of().emit({**found.document(), "wrote": str(path), "to_fill_in": unknown}, lines)


@click.command()
@click.argument("package", type=FOLDER)
@set_option
def check(package: Path, overrides: tuple[str, ...]) -> None:
    """Say in words what PACKAGE holds, or a bare log, and what is missing for a run."""
    if package.is_file() or (package.is_dir() and not (package / CONFIGURATION).exists() and _is_log(package)):
        _check_log(package)
        return
    from hullrecon.artifacts.execution.progress import choose_progress
    from hullrecon.dive.check.package_check import check_package
    from hullrecon.dive.config.load import load_config
    from hullrecon.steps.chain import stages
    from hullrecon.steps.ingest import STAGE, USES, request_of

    loaded = load_config(package, {stage.name: stage.parameters for stage in (*stages(), STAGE)}, overrides)
    request = request_of({name: loaded.value(name) for name in USES})
    progress = choose_progress()
    found = check_package(loaded, request, lambda messages: progress.track(messages, "check: messages", None))
    state_of().emit(found.document(), found.lines())


def _check_log(path: Path) -> None:
    from hullrecon.dive.logs.readers.open import open_log
    from hullrecon.dive.logs.summary import survey

    found = survey(open_log(path))
    advice = "this is a log without a dive.toml: `hullrecon init` writes one beside it"
    state_of().emit(found.document(), [*found.lines(), advice])


def _is_log(folder: Path) -> bool:
    from hullrecon.dive.logs.readers.open import open_log

    try:
        open_log(folder)
    except InputError:
        return False
    return True
