# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""fleet: every dive of a folder, each in a process of its own."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import click

from hullrecon.api.fleet import FleetDive, FleetResult, preview_fleet, run_fleet
from hullrecon.api.fleet.packages import one_line
from hullrecon.artifacts.progress import choose_progress

from ..dives import FOLDER, allow_outside_option, runs_option
from ..state import state_of

log = logging.getLogger("hullrecon.cli")


@click.command()
@click.argument("dives", type=FOLDER)
@click.option(
    "--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="dives at a time"
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="a Dask scheduler for the work inside the steps of all dives",
)
@click.option(
    "--time-limit",
    "time_limit_s",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="end a dive that takes longer; it has failed with exit code 4",
)
@click.option(
    "--retry", is_flag=True, help="also run dives that failed before and have not changed since"
)
@click.option("--dry-run", is_flag=True, help="say what would be run and why, run nothing")
@allow_outside_option
@runs_option
@click.pass_context
def fleet(
    context: click.Context, /, dives: Path, runs: Path, dry_run: bool, **options: Any
) -> None:
    """Run every dive package in the folder DIVES that is new or whose result is out of date.

    A package is a folder with a dive.toml. Each dive runs in a process of its own. When one fails,
    the others still run, one line on standard error names it, and the exit code is 4. It is tried
    again when its package or hullrecon has changed, when --time-limit or --allow-outside lets it do
    more, after a day, or with --retry. With --quiet it is named once. A fleet may be killed and
    started again. A second fleet on the same runs ends with exit code 5.
    """
    if dry_run:
        terms = {name: options[name] for name in ("retry", "allow_outside", "time_limit_s")}
        result = preview_fleet(dives, runs, **terms)
        _emit(
            result,
            [f"would run {d.package.name}: {d.reason}" for d in result.dives if d.state == "to do"],
        )
        return
    progress = choose_progress(quiet=state_of().quiet)
    result = run_fleet(dives, runs, progress=progress, on_failure=_print_failure, **options)
    _emit(result, [])
    context.exit(result.exit_code)


def _emit(result: FleetResult, lines: list[str]) -> None:
    """Log the skipped entries, and print the lines and the summary, or the document."""
    for skipped in result.skipped:
        log.info(
            "%s",
            one_line(f"skipped: {skipped.path.relative_to(result.dives_folder)}: {skipped.reason}"),
        )
    state = state_of()
    document = result.document() if state.json else {}  # it lists every file
    state.emit(document, [*map(one_line, lines), result.summary()])


def _print_failure(dive: FleetDive) -> None:
    """Print a dive's failure, with --quiet only the first time."""
    if not (dive.known and state_of().quiet):
        click.echo(dive.line(), err=True)
