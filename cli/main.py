# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The program: its group of commands, and the exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module

import click

from hullrecon.artifacts.progress import listen

from .command_table import COMMANDS, RENAMED, SECTIONS
from .error_reporting import exit_code_of
from .printing import write_out_what_cannot_be_encoded
from .state import CallState, add_common_options, common_options, configure_logging

PROGRAM = "hullrecon"


class LazyGroup(click.Group):
    """A group that imports a command only when it is called. Their list comes from a table."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command by its name, with the options that all have. None for an unknown one."""
        entry = COMMANDS.get(cmd_name)
        if entry is None:
            return None
        module = import_module(f".commands.{entry.module}", __package__)
        command: click.Command = (
            module.command(cmd_name) if entry.module == "steps" else getattr(module, entry.name)
        )
        add_common_options(command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Refuse an unknown command, and suggest the known one whose name is nearest."""
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            from difflib import get_close_matches

            near = (
                [RENAMED[args[0]]]
                if args[0] in RENAMED
                else get_close_matches(args[0], COMMANDS, 1)
            )
            ctx.fail(
                f"no command is called {args[0]!r}"
                + (f"; did you mean {near[0]!r}?" if near else "")
            )
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        for title, entries in SECTIONS.items():
            with formatter.section(title):
                formatter.write_dl([(name, entry.summary) for name, entry in entries.items()])


def _version(context: click.Context, parameter: click.Parameter, value: bool) -> None:
    """Print the version and exit, where --version is given."""
    if value and not context.resilient_parsing:
        from hullrecon.version import describe

        click.echo(f"{PROGRAM} {describe()}")
        context.exit()


@click.group(
    cls=LazyGroup,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_version,
    help="print the version and the commit",
)
@click.pass_context
def cli(context: click.Context) -> None:
    """Reconstruct a ship's hull as found from an inspection's logs and the CAD model.

    Exit codes: 0 done, 1 an internal error, 2 usage or configuration, 3 the input cannot be used, 4
    a step reached no result, 5 the dive is locked by another run, 6 no space or no permission, 130
    interrupted.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


cli.params += common_options()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code."""
    # One thread for BLAS: sums must not depend on the number of cores. Worker processes inherit it.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # What OpenCV cannot decode is said once, not by its own lines for each picture
    os.environ.setdefault("OPENCV_LOG_LEVEL", "ERROR")
    listen()
    write_out_what_cannot_be_encoded()
    state = CallState()
    configure_logging(state)
    try:
        result = cli.main(arguments, prog_name=PROGRAM, standalone_mode=False, obj=state)
        sys.stdout.flush()
    except BaseException as error:
        return exit_code_of(error, state)
    return result if isinstance(result, int) else 0


if __name__ == "__main__":
    sys.exit(main())
