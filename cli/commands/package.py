# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""init and check: write the dive.toml of a package, and check a package, a log or a run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from hullrecon.errors import HullreconError, InputError

from ..dives import (
    CONFIGURATION,
    FOLDER,
    allow_outside_option,
    memory_option,
    name_overrides,
    set_option,
)
from ..state import state_of


@click.command()
@click.argument("log", type=FOLDER)
@click.option(
    "--out",
    type=FOLDER,
    help="the package's folder  [default: LOG where it is a folder, else the current one]",
)
@click.option("--force", is_flag=True, help=f"replace a {CONFIGURATION} that is there")
@allow_outside_option
def init(log: Path, out: Path | None, force: bool, allow_outside: bool) -> None:
    """Write a commented dive.toml by looking into LOG, a file or a folder with one."""
    from hullrecon.api import package
    from hullrecon.findings.finding import sentences

    done = package.init(log, out, force=force, allow_outside=allow_outside)
    lines = [
        *done.log.lines(),
        *(f"wrote {path}" for path in (*done.calibrations, done.dive_toml)),
        *sentences(done.to_fill_in),
        f"next: read it through, then `hullrecon check {done.folder}`",
    ]
    document = {
        **done.log.document(),
        "wrote": str(done.dive_toml),
        "to_fill_in": sentences(done.to_fill_in),
    }
    state_of().emit(document, lines)


@click.command("check")
@click.argument("package", type=FOLDER)
@set_option
@memory_option
@allow_outside_option
def check_of_package(
    package: Path, overrides: tuple[str, ...], memory_gb: float | None, allow_outside: bool
) -> None:
    """Describe what PACKAGE holds, or a bare log, and what is missing for a run.

    Exits with 0 only when a run is possible, else with 3.
    """
    if package.is_file() or (package.is_dir() and not (package / CONFIGURATION).exists()):
        _check_logs(package, allow_outside)
        return
    from hullrecon.api.package import check_loaded
    from hullrecon.artifacts.progress import choose_progress
    from hullrecon.dive.config.load import load_config
    from hullrecon.steps.chain import stages

    step_sections = {stage.name: stage.parameters for stage in stages()}
    with name_overrides(step_sections, overrides):
        loaded = load_config(package, step_sections, overrides)
    found = check_loaded(
        loaded,
        allow_outside=allow_outside,
        trusted_keys=[text.partition("=")[0].strip() for text in overrides],
        memory_gb=memory_gb,
        progress=choose_progress(),
    )
    state_of().emit(found.document(), found.lines())
    if not found.run_is_possible:
        _end_unready(found.reasons)


def _check_logs(path: Path, allow_outside: bool) -> None:
    """Describe a bare log: without a dive.toml no run is possible."""
    from hullrecon.api.package import summarise
    from hullrecon.dive.logs.readers.open import find_logs
    from hullrecon.findings.finding import sentences
    from hullrecon.findings.package import A_RUN_NEEDS

    try:
        find_logs(path)
    except InputError as error:
        raise InputError(
            f"no {CONFIGURATION} here, and {error.what}", where=error.where, remedy=error.remedy
        ) from None
    found = summarise(path, allow_outside=allow_outside)
    unwritten = f"no {CONFIGURATION} yet, `hullrecon init {path}` writes one"
    reasons = [found.why_nothing(), A_RUN_NEEDS]
    if found.topics:
        reasons = [unwritten, *sentences(found.needs())]
    verdict = f"not ready: {'; '.join(reasons)}"
    state_of().emit(
        {**found.document(), "run_is_possible": False, "verdict": verdict},
        [*found.lines(), f"verdict: {verdict}"],
    )
    _end_unready(reasons)


def _end_unready(reasons: list[str]) -> None:
    """End with the exit code of an input that no run can use."""
    if state_of().json:
        click.get_current_context().exit(InputError.exit_code)
    raise InputError(f"no run is possible: {'; '.join(reasons)}")


class _Check(click.Command):
    """The command `check`, whose help also lists the options of `check_of_package`.

    These are passed on and parsed by that command.
    """

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the help of this command's options, then those for a dive package."""
        super().format_options(ctx, formatter)
        known = {parameter.name for parameter in self.get_params(ctx)}
        options = [
            p
            for p in check_of_package.params
            if isinstance(p, click.Option) and p.name not in known
        ]
        more = [option.get_help_record(ctx) for option in options]
        with formatter.section("Options for a dive package"):
            formatter.write_dl([record for record in more if record is not None])


@click.command(
    cls=_Check, context_settings={"ignore_unknown_options": True, "allow_extra_args": True}
)
@click.argument("target", type=FOLDER)
@click.option(
    "--read-data", is_flag=True, help="run's folder: read every byte, those of the package too"
)
@click.pass_context
def check(context: click.Context, target: Path, read_data: bool) -> None:
    """Check TARGET, a dive package or the folder of a run, and name what is wrong."""
    from hullrecon.artifacts.workspace import Workspace

    if Workspace(target).exists() and not (target / CONFIGURATION).exists():
        if context.args:
            raise click.UsageError(f"no such option: {context.args[0]}", context)
        _check_run(target, read_data)
        return
    if read_data:
        raise click.UsageError(
            f"--read-data is for the folder of a run, and {target} is none", context
        )
    with (
        check_of_package.make_context(
            "check", [str(target), *context.args], parent=context
        ) as inner,
        _verdict_in_any_case(),
    ):
        check_of_package.invoke(inner)


@contextmanager
def _verdict_in_any_case() -> Iterator[None]:
    """Print a verdict also if an error, such as a mistake in dive.toml, prevents the check."""
    try:
        yield
    except HullreconError as error:
        if not state_of().json and not state_of().is_emitted:
            state_of().emit(None, [f"verdict: not ready: {' '.join(error.line().split())}"])
        raise


def _check_run(folder: Path, read_data: bool) -> None:
    """Check the artifacts of a run against their manifests. Raises InputError if any is damaged."""
    from hullrecon.artifacts.checking import check_workspace
    from hullrecon.artifacts.workspace import Workspace
    from hullrecon.steps.chain import NAMES

    found = check_workspace(Workspace(folder), NAMES, read_data=read_data)
    how = "read" if read_data else "looked at"
    summary = (
        f"{found.artifacts} artifacts, {found.files} files {how}, "
        f"{found.read_bytes / 1e6:.1f} MB, {len(found.damaged)} damaged"
    )
    document = {
        "artifacts": found.artifacts,
        "files": found.files,
        "read_data": read_data,
        "damaged": found.damaged,
    }
    if found.damaged and state_of().json:
        state_of().emit(document, ())
        context = click.get_current_context()
        context.exit(InputError.exit_code)
    state_of().emit(document, [*(f"damaged: {sentence}" for sentence in found.damaged), summary])
    if found.damaged:
        remedy = "`hullrecon run --read-data` sets damaged artifacts apart and reruns their steps"
        raise InputError(
            f"damaged: {'; '.join(found.damaged[:3])}", where=str(folder), remedy=remedy
        )
