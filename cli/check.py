# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""check: of a dive package what it holds, of a run's folder whether it is as it was written."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import click

from hullrecon.errors import InputError

from .dives import CONFIGURATION, FOLDER
from .state import state_of


class _Check(click.Command):
    """Its help lists the options of a package's check as well, which are parsed by that command."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        super().format_options(ctx, formatter)
        package_check: click.Command = import_module(".dive", __package__).check
        known = {parameter.name for parameter in self.get_params(ctx)}
        more = [parameter.get_help_record(ctx) for parameter in package_check.params if parameter.name not in known]
        with formatter.section("Options for a dive package"):
            formatter.write_dl([record for record in more if record is not None])


@click.command(cls=_Check, context_settings={"ignore_unknown_options": True, "allow_extra_args": True})
@click.argument("target", type=FOLDER)
@click.option("--read-data", is_flag=True, help="run's folder: read every byte, those of the package too")
@click.pass_context
def check(context: click.Context, target: Path, read_data: bool) -> None:
    """Check TARGET, a dive package or the folder of a run, and name what is wrong."""
    from hullrecon.artifacts.storage.workspace import Workspace

    if Workspace(target).exists() and not (target / CONFIGURATION).exists():
        if context.args:
            raise click.UsageError(f"no such option: {context.args[0]}", context)
        _check_run(target, read_data)
        return
    if read_data:
        raise click.UsageError(f"--read-data is for the folder of a run, and {target} is none", context)
    package_check: click.Command = import_module(".dive", __package__).check
    with package_check.make_context("check", [str(target), *context.args], parent=context) as inner:
        package_check.invoke(inner)


def _check_run(folder: Path, read_data: bool) -> None:
    from hullrecon.artifacts.storage.checking import check_workspace
    from hullrecon.artifacts.storage.workspace import Workspace
    from hullrecon.steps.chain import NAMES

    found = check_workspace(Workspace(folder), NAMES, read_data=read_data)
    how = "read" if read_data else "looked at"
    summary = (
        f"{found.artifacts} artifacts, {found.files} files {how}, {found.read_bytes / 1e6:.1f} MB, {len(found.damaged)} damaged"
    )
    document = {"artifacts": found.artifacts, "files": found.files, "read_data": read_data, "damaged": found.damaged}
    if found.damaged and state_of().json:
        state_of().emit(document, ())
        context = click.get_current_context()
        context.exit(InputError.exit_code)
    state_of().emit(document, [*(f"damaged: {sentence}" for sentence in found.damaged), summary])
    if found.damaged:
        remedy = "`hullrecon run --read-data` sets damaged artifacts apart and reruns their steps"
        raise InputError(f"damaged: {'; '.join(found.damaged[:3])}", where=str(folder), remedy=remedy)
