# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""export: results in forms that are too large, or asked for too seldom, to lie in deliver/."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click

from ..dives import FOLDER, jobs_option
from ..state import add_common_options, state_of


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
