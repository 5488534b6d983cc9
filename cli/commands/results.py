# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""evaluate, diff, export: the commands that work on finished runs."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click

from ..dives import FOLDER, jobs_option
from ..state import add_common_options, state_of


@click.command()
@click.argument("run", type=FOLDER, metavar="RUN_OR_DELIVER")
@click.argument("package", type=FOLDER)
def evaluate(run: Path, package: Path) -> None:
    """Score a run (RUNS/<dive> or its deliver/) against the truth in a simulated dive's PACKAGE."""
    from hullrecon.evaluation.score import score_run, table_rows, without_nan

    figures = score_run(run, package)
    width = max(len(name) for name, _, _ in table_rows(figures))
    lines = [
        f"{name:{width}}  {value} {unit}".rstrip() for name, value, unit in table_rows(figures)
    ]
    state_of().emit(without_nan(figures), lines)


@click.command()
@click.argument("first", type=FOLDER, metavar="RUN1")
@click.argument("second", type=FOLDER, metavar="RUN2")
@click.option("--out", type=FOLDER, help="folder of the files; change-RUN1-RUN2 here if absent")
def diff(first: Path, second: Path, out: Path | None) -> None:
    """Say what changed on a hull from RUN1 to RUN2, both RUNS/<dive> of one hull with a CAD model.

    Objects that are new, gone, grown or shrunk, and bare hull that moved, each with its
    significance. The offset between the two dives is estimated from hull that both saw, and is not
    reported as a change. What only one dive looked at is said to be so. Leaves change.json,
    change.csv, layers for QGIS, a map and a page.
    """
    from hullrecon.api import change
    from hullrecon.report.change.chapter import move_sentence, object_sentence, verdict

    found = change.diff(first, second)
    folder = out or Path(f"change-{found.change.first}-{found.change.second}")
    names = change.write_change(folder, found)
    lines = [verdict(found.change), *(object_sentence(row) for row in found.change.changed())]
    lines += [move_sentence(row) for row in found.change.moves]
    document = {
        "verdict": lines[0],
        "changes": lines[1:],
        "folder": str(folder),
        "files": list(names),
    }
    state_of().emit(document, [*lines, f"files: {folder}"])


@click.group(invoke_without_command=True)
@click.pass_context
def export(context: click.Context) -> None:
    """Write results of a finished run in forms that other programs ask for."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@export.command()
@click.argument("run", type=FOLDER, metavar="RUN")
@click.argument("folder", type=FOLDER, metavar="OUT")
@jobs_option("worker processes")
def colmap(run: Path, folder: Path, jobs: int | None) -> None:
    """Write the undistorted images of RUN (RUNS/<dive>) to OUT, with their COLMAP model.

    The cameras are pinholes. OUT is a workspace for COLMAP's stereo, OpenMVS and trainers of
    Gaussian splats: images/, sparse/ (again as sparse/0/), stereo/. Poses and points are those of
    deliver/colmap. OUT must be new or empty; it appears when all of it is written.
    """
    from hullrecon.api.export import export_colmap
    from hullrecon.artifacts.progress import choose_progress

    made = export_colmap(run, folder, jobs=jobs, progress=choose_progress(quiet=state_of().quiet))
    line = f"wrote {folder}: {made.images} images, {made.points} points"
    line += f", {made.observations} observations"
    if made.lost_observations:
        line += f"; {made.lost_observations} observations lay outside the undistorted images"
    state_of().emit({**asdict(made), "folder": str(folder)}, [line])


add_common_options(colmap)
