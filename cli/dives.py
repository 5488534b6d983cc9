# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From what stands on the command line to a chain of stages and the folder of its run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import click

from hullrecon.artifacts.graph.chain import Chain
from hullrecon.artifacts.storage.workspace import Workspace
from hullrecon.errors import InputError

from .set_errors import name_overrides
from .state import state_of

Command = TypeVar("Command", bound=Callable[..., Any])
FOLDER = click.Path(path_type=Path, file_okay=True)
CONFIGURATION = "dive.toml"


@dataclass(frozen=True)
class DiveRun:
    """A dive package, read, with the place of its artifacts."""

    name: str
    chain: Chain
    workspace: Workspace


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
    from hullrecon.dive.config.load import load_config
    from hullrecon.steps.chain import stages

    workspace = Workspace(target) if Workspace(target).exists() else None
    package = target if workspace is None else package_of(workspace)
    all_stages = stages()
    step_sections = {stage.name: stage.parameters for stage in all_stages}
    with name_overrides(step_sections, overrides):
        config = load_config(package, step_sections, overrides)
    name = config.sections["dive"].name
    workspace = workspace or Workspace(runs / name)
    state_of().workspace = workspace.root
    return DiveRun(name, Chain(all_stages, config.sections, package), workspace)


def package_of(workspace: Workspace) -> Path:
    package = workspace.package
    if package is None:
        raise InputError(
            "this run does not say which dive package it read", where=str(workspace.root), remedy="give the package's folder"
        )
    return package


def find_workspace(target: Path, runs: Path) -> Workspace:
    """The folder of a run, given itself or by its package; needs no valid configuration in the first case."""
    workspace = Workspace(target)
    return workspace if workspace.exists() else open_dive(target, runs).workspace
