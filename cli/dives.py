# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From what stands on the command line to a chain of stages and the folder of its run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.storage.workspace import Workspace

from .set_errors import name_overrides
from .state import state_of

Command = TypeVar("Command", bound=Callable[..., Any])
FOLDER = click.Path(path_type=Path, file_okay=True)
CONFIGURATION = "dive.toml"


def runs_option(command: Command) -> Command:
    return click.option(
        "--runs", type=FOLDER, default=Path("runs"), envvar="HULLRECON_RUNS", show_default=True, show_envvar=True,
        help="folder of all runs; this dive's is RUNS/<its name>",
    )(command)  # fmt: skip


def set_option(command: Command) -> Command:
    text = "an option in place of that of dive.toml; may be repeated"
    return click.option("--set", "overrides", multiple=True, metavar="SECTION.KEY=VALUE", help=text)(command)


def open_dive(target: Path, runs: Path, overrides: Sequence[str] = ()) -> DiveRun:
    """target: a dive package, or the folder of a run, whose package is the one that it last read.

    Raises InputError when it is neither, UsageError for a wrong configuration.
    """
    from hullrecon.api.dive_run import open_dive as open_dive_run
    from hullrecon.steps.chain import stages

    with name_overrides({stage.name: stage.parameters for stage in stages()}, overrides):
        dive = open_dive_run(target, runs, overrides)
    state_of().workspace = dive.workspace.root
    return dive


def find_workspace(target: Path, runs: Path) -> Workspace:
    """The folder of a run, given itself or by its package; needs no valid configuration in the first case."""
    workspace = Workspace(target)
    return workspace if workspace.exists() else open_dive(target, runs).workspace
