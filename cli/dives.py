# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options that commands share, and the dive that a command names."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import click
import msgspec
from msgspec import inspect as types

from hullrecon.api import dive_run
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import UsageError

from .state import state_of

Command = TypeVar("Command", bound=Callable[..., object])
FOLDER = click.Path(path_type=Path, file_okay=True)
CONFIGURATION = "dive.toml"


def runs_option(command: Command) -> Command:
    """Add --runs to a command."""
    return click.option(
        "--runs",
        type=FOLDER,
        default=Path("runs"),
        envvar="HULLRECON_RUNS",
        show_default=True,
        show_envvar=True,
        help="folder of all runs; this dive's is RUNS/<its name>",
    )(command)


def jobs_option(what: str) -> Callable[[Command], Command]:
    """Make the option --jobs for a command. what: the things that it counts, for the help."""
    return click.option(
        "--jobs",
        type=click.IntRange(min=1),
        help=f"{what}  [default: HULLRECON_JOBS, else as many as there are cores]",
    )


def memory_option(command: Command) -> Command:
    """Add --memory to a command."""
    text = (
        "GB that a run may take; a dive that needs twice as much is refused, and two steps run "
        "beside each other only if both fit  [default: half of the machine's]"
    )
    return click.option(
        "--memory", "memory_gb", type=click.FloatRange(min=0, min_open=True), help=text
    )(command)


def set_option(command: Command) -> Command:
    """Add --set to a command."""
    text = "use this value instead of that of dive.toml; may be repeated"
    return click.option(
        "--set", "overrides", multiple=True, metavar="SECTION.KEY=VALUE", help=text
    )(command)


def allow_outside_option(command: Command) -> Command:
    """Add --allow-outside to a command."""
    return click.option(
        "--allow-outside", is_flag=True, envvar="HULLRECON_ALLOW_OUTSIDE", show_envvar=True,
        help="read files outside the package too, where dive.toml or a table names them",
    )(command)  # fmt: skip


def open_dive(
    target: Path, runs: Path, overrides: Sequence[str] = (), *, allow_outside: bool = False
) -> dive_run.DiveRun:
    """Open the dive of a package, or of a run by the package that it read last.

    Errors in values of --set name --set as their place.

    Raises InputError when the target is neither, or names files outside that are not allowed;
    UsageError for a wrong configuration.
    """
    from hullrecon.steps.chain import stages

    with name_overrides({stage.name: stage.parameters for stage in stages()}, overrides):
        dive = dive_run.open_dive(target, runs, overrides, allow_outside=allow_outside)
    state_of().workspace = dive.workspace.root
    return dive


def find_workspace(target: Path, runs: Path) -> Workspace:
    """Return the workspace of a run, given by its own folder or by its package.

    With the run's folder no valid configuration is needed.
    """
    workspace = Workspace(target)
    return (
        workspace if workspace.exists() else open_dive(target, runs, allow_outside=True).workspace
    )


@contextmanager
def name_overrides(
    step_sections: Mapping[str, type[msgspec.Struct]], overrides: Sequence[str]
) -> Iterator[None]:
    """Improve the UsageErrors of `load_config` raised inside the `with`.

    For a wrong choice the possible values are listed. If the value was given by --set, the error
    says so instead of naming dive.toml.
    """
    try:
        yield
    except UsageError as error:
        key, equals, rest = error.what.partition(" = ")
        if not equals:
            key = error.what.removeprefix("unknown key ").removesuffix(" is missing")
        given_by_set = key in {text.partition("=")[0].strip() for text in overrides}
        choices = _choices(step_sections, key) if "invalid enum value" in rest.lower() else ()
        if not given_by_set and not choices:
            raise
        value = rest.rpartition(": ")[0]
        what = f"{key}: {value} is not one of {', '.join(choices)}" if choices else error.what
        where = "from --set" if given_by_set else error.where
        raise UsageError(what, where=where, remedy=error.remedy) from None


def _choices(step_sections: Mapping[str, type[msgspec.Struct]], key: str) -> tuple[str, ...]:
    """List the values that the option `section.key` of a step may take, if it is a choice."""
    section, _, name = key.rpartition(".")
    if section not in step_sections:
        return ()
    info = types.type_info(step_sections[section])
    assert isinstance(info, types.StructType)
    kind = next((field.type for field in info.fields if field.name == name), None)
    while isinstance(kind, types.Metadata):
        kind = kind.type
    return tuple(str(value) for value in kind.values) if isinstance(kind, types.LiteralType) else ()
