# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""clean: list what would go, ask, remove."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from hullrecon.errors import UsageError

from ..dives import FOLDER, find_workspace, runs_option
from ..printing import printable
from ..state import state_of
from .run import refuse_unknown


@click.command()
@click.argument("target", type=FOLDER)
@click.argument("steps", nargs=-1, metavar="[STEP]...")
@click.option("--dry-run", is_flag=True, help="list what would be removed, remove nothing")
@click.option(
    "--yes", "-y", is_flag=True, help="do not ask before removing the artifacts of all steps"
)
@click.option(
    "--wait",
    "wait_s",
    type=click.FloatRange(min=0),
    default=0.0,
    help="seconds to wait for another run on this dive",
)
@runs_option
def clean(
    target: Path, steps: tuple[str, ...], runs: Path, dry_run: bool, yes: bool, wait_s: float
) -> None:
    """Remove the artifacts of the named STEPs, or of all steps after asking.

    The package is never touched, nor is what lies in quarantine.
    """
    from hullrecon.steps.chain import NAMES

    refuse_unknown(steps, NAMES)
    workspace = find_workspace(target, runs)
    there = [name for name in steps or NAMES if workspace.artifact(name).is_dir()]
    if dry_run:
        document = {"workspace": str(workspace.root), "would_remove": there}
        state_of().emit(document, [f"would remove {workspace.artifact(name)}" for name in there])
        return
    if there and not steps and not yes:
        _ask(workspace.root, there)
    removed = []
    if there:
        with workspace.lock(wait_s):
            removed = [name for name in there if workspace.remove(name)]
    state_of().emit(
        {"workspace": str(workspace.root), "removed": removed},
        [f"removed {name}" for name in removed],
    )


def _ask(root: Path, names: list[str]) -> None:
    """Ask for confirmation. Raises UsageError if it is denied, or without a terminal."""
    listed = ", ".join(names)
    if not sys.stdin.isatty():
        remedy = "name the steps, or give --yes; --dry-run lists them"
        raise UsageError(
            f"clean without steps would remove all artifacts: {listed}",
            where=str(root),
            remedy=remedy,
        )
    if not click.confirm(printable(f"Remove the artifacts of {listed} in {root}?"), err=True):
        raise UsageError("nothing was removed")
