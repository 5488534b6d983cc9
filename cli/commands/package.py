# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""init and check: write a dive.toml, and check a package, a bare log or the folder of a run."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from hullrecon.errors import HullreconError, InputError, UsageError

from ..dives import CONFIGURATION, FOLDER, allow_outside_option, name_overrides, set_option
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
    from hullrecon.artifacts.disk import storage_errors, write_file
    from hullrecon.dive.check.to_fill_in import to_fill_in
    from hullrecon.dive.config.config_template import fill_template
    from hullrecon.dive.config.load import load_config
    from hullrecon.dive.config.log_proposals import missing_calibrations, questions
    from hullrecon.dive.logs.readers.open import find_logs, open_log
    from hullrecon.dive.logs.summary import A_RUN_NEEDS, guess_topics, summarise_logs
    from hullrecon.dive.package_files import check_log, lies_inside

    logs = find_logs(log)
    for path in logs if log.is_dir() else ():
        check_log(path, log, allow_outside=allow_outside)
    _require_utf8([log, *logs])
    found = summarise_logs([open_log(path) for path in logs])
    if not found.topics:
        raise InputError(found.why_nothing(), where=str(log), remedy=A_RUN_NEEDS)
    folder = out or (log if log.is_dir() else Path())
    path = folder / CONFIGURATION
    if path.exists() and not force:
        raise UsageError(
            f"{CONFIGURATION} is there already", where=str(folder), remedy="--force replaces it"
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
    unknown = to_fill_in(load_config(folder), guess_topics(found.topics).keys(), frozenset())
    unknown += [
        f"outside the package: {p}; put it there, or give --allow-outside to check and run"
        for p in outside
    ]
    unknown += questions(found)
    unknown += [
        f"to see to: {name} is the log's CameraInfo; it has to be that of the camera in water"
        for name in calibrations
    ]
    lines = [
        *found.lines(),
        *(f"wrote {folder / name}" for name in calibrations),
        f"wrote {path}",
        *unknown,
        f"next: read it through, then `hullrecon check {folder}`",
    ]
    state_of().emit({**found.document(), "wrote": str(path), "to_fill_in": unknown}, lines)


def _require_utf8(paths: list[Path]) -> None:
    """Raise InputError for a name that dive.toml, which is UTF-8, cannot hold."""
    for path in paths:
        try:
            str(path).encode()
        except UnicodeEncodeError:
            shown = os.fsencode(path).decode(errors="replace")
            raise InputError(
                "the name is not UTF-8, and dive.toml could not tell it",
                where=shown,
                remedy="rename it",
            ) from None


@click.command("check")
@click.argument("package", type=FOLDER)
@set_option
@allow_outside_option
def check_of_package(package: Path, overrides: tuple[str, ...], allow_outside: bool) -> None:
    """Describe what PACKAGE holds, or a bare log, and what is missing for a run.

    Exits with 0 only when a run is possible, else with 3.
    """
    if package.is_file() or (package.is_dir() and not (package / CONFIGURATION).exists()):
        _check_logs(package, allow_outside)
        return
    from hullrecon.artifacts.progress import choose_progress
    from hullrecon.artifacts.stage import StageSettings
    from hullrecon.dive.check.package_check import check_package
    from hullrecon.dive.config.load import load_config
    from hullrecon.dive.package_files import check_files
    from hullrecon.steps.chain import stages
    from hullrecon.steps.ingest import STAGE, USES, request_of
    from hullrecon.steps.stereo_check import describe_rig_problem

    step_sections = {stage.name: stage.parameters for stage in (*stages(), STAGE)}
    with name_overrides(step_sections, overrides):
        loaded = load_config(package, step_sections, overrides)
    check_files(
        loaded,
        allow_outside=allow_outside,
        trusted_keys=[text.partition("=")[0].strip() for text in overrides],
    )
    request = request_of(StageSettings(STAGE.name, {name: loaded.value(name) for name in USES}))
    progress = choose_progress()
    found = check_package(
        loaded,
        request,
        lambda messages: progress.track(messages, "check: messages", None),
        describe_rig_problem,
    )
    state_of().emit(found.document(), found.lines())
    if found.run_is_possible:
        return
    if state_of().json:
        click.get_current_context().exit(InputError.exit_code)
    raise InputError(f"no run is possible: {'; '.join(found.reasons)}")


def _check_logs(path: Path, allow_outside: bool) -> None:
    from hullrecon.dive.logs.readers.open import find_logs, open_log
    from hullrecon.dive.logs.summary import A_RUN_NEEDS, summarise_logs
    from hullrecon.dive.package_files import check_log

    try:
        logs = find_logs(path)
    except InputError as error:
        raise InputError(
            f"no {CONFIGURATION} here, and {error.what}", where=error.where, remedy=error.remedy
        ) from None
    for log in logs if path.is_dir() else ():
        check_log(log, path, allow_outside=allow_outside)
    found = summarise_logs([open_log(log) for log in logs])
    unwritten = f"no {CONFIGURATION} yet, `hullrecon init {path}` writes one"
    reasons = [unwritten, *found.needs()] if found.topics else [found.why_nothing(), A_RUN_NEEDS]
    verdict = f"not ready: {'; '.join(reasons)}"
    state_of().emit(
        {**found.document(), "run_is_possible": False, "verdict": verdict},
        [*found.lines(), f"verdict: {verdict}"],
    )
    if state_of().json:
        click.get_current_context().exit(InputError.exit_code)
    raise InputError(f"no run is possible: {'; '.join(reasons)}")


class _Check(click.Command):
    """Its help lists the options of a package's check as well, which are parsed by that command."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
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
    """End with a verdict where an error came before it, such as a mistake in dive.toml."""
    try:
        yield
    except HullreconError as error:
        if not state_of().json and not state_of().is_emitted:
            state_of().emit(None, [f"verdict: not ready: {' '.join(error.line().split())}"])
        raise


def _check_run(folder: Path, read_data: bool) -> None:
    from hullrecon.artifacts.checking import check_workspace
    from hullrecon.artifacts.workspace import Workspace
    from hullrecon.steps.chain import NAMES

    found = check_workspace(Workspace(folder), NAMES, read_data=read_data)
    how = "read" if read_data else "looked at"
    summary = f"{found.artifacts} artifacts, {found.files} files {how}"
    summary += f", {found.read_bytes / 1e6:.1f} MB, {len(found.damaged)} damaged"
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
