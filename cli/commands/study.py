# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""study: reproduce the published variants of the method and the published figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import click

from hullrecon.artifacts.progress import choose_progress

from ..dives import FOLDER, allow_outside_option, open_dive, runs_option, set_option
from ..state import add_common_options, state_of

_JOBS = click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="worker processes inside a step",
)


@click.group(invoke_without_command=True)
@click.pass_context
def study(context: click.Context) -> None:
    """Reproduce the sources on a simulated dive: the published methods and figures."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@study.command()
@click.argument("package", type=FOLDER)
@_JOBS
@set_option
@runs_option
@allow_outside_option
def methods(
    package: Path, runs: Path, overrides: tuple[str, ...], jobs: int, allow_outside: bool
) -> None:
    """Compare naive, geva and maxmix, each as published and as weighted by us, on one simulated
    dive, in one table.

    The steps before `adjust` run once if they are out of date; `adjust` runs six times. As
    published is one solve from the registration on, without a deviation field, outliers left to the
    Huber loss.
    """
    from hullrecon.evaluation.scoring.score import without_nan
    from hullrecon.studies import compare_methods

    dive = open_dive(package, runs, overrides, allow_outside=allow_outside)
    comparison = compare_methods(dive, jobs=jobs, progress=choose_progress(quiet=state_of().quiet))
    state_of().emit(without_nan(comparison.figures), _table(comparison.heads, comparison.rows))


@study.command()
@click.argument("package", type=FOLDER)
@_JOBS
@set_option
@runs_option
@allow_outside_option
def figures(
    package: Path, runs: Path, overrides: tuple[str, ...], jobs: int, allow_outside: bool
) -> None:
    """Draw the sources' figures on one simulated dive: pictures and their tables, in
    RUNS/<dive>/compare/figures.

    Cross-sections of the three methods, labels by iteration, cost by iteration and by time, the
    DVL's residuals before and after, the height of a structure; the sigma along the path and its
    links, two-view models (one camera), DVL returns on the CAD model with planes and without, the
    sonar mosaic's variance by source of poses; and, of scenes made for it, when a homography
    explains two images, search ellipses, a sphere mapped by planes. Solves what `study methods`
    has not solved, runs the chain up to `detect`, whose heights are the ones delivered, and with
    one camera `links` twice more.
    """
    from hullrecon.studies import draw_figures

    dive = open_dive(package, runs, overrides, allow_outside=allow_outside)
    folder, drawn = draw_figures(dive, jobs=jobs, progress=choose_progress(quiet=state_of().quiet))
    lines = [f"{folder / figure.name}.png: {figure.caption}" for figure in drawn]
    state_of().emit({"folder": str(folder), "figures": {f.name: f.caption for f in drawn}}, lines)


for _command in (methods, figures):
    add_common_options(_command)


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterable[str]:
    """Yield the lines of a table, columns as wide as they need, the first aligned left."""
    cells = [list(heads), *(list(row) for row in rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(heads))]
    for row in cells:
        first, *rest = (
            f"{cell:<{w}}" if k == 0 else f"{cell:>{w}}"
            for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        )
        yield "  ".join([first, *rest])
