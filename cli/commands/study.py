# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""study: reproduce the sources' methods, tables and figures, print and ours side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import click

from hullrecon.artifacts.progress import choose_progress
from hullrecon.errors import UsageError

from ..dives import FOLDER, allow_outside_option, open_dive, runs_option, set_option
from ..state import add_common_options, state_of

_JOBS = click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="worker processes: inside a step, or for so many scenes at a time",
)


@click.group(invoke_without_command=True)
@click.pass_context
def study(context: click.Context) -> None:
    """Reproduce the sources on a simulated dive: the published methods and figures."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@study.command("list", short_help="list the studies")
def list_studies() -> None:
    """List the studies: id, dive or scene of its own, what it shows, source."""
    from hullrecon.studies import STUDIES

    document = {
        s.id: {"source": s.source, "shows": s.shows, "needs_dive": s.needs_dive} for s in STUDIES
    }
    width = max(len(s.id) for s in STUDIES)
    state_of().emit(
        document,
        (
            f"{s.id:{width}}  {'dive ' if s.needs_dive else 'scene'}  {s.shows} {s.source}"
            for s in STUDIES
        ),
    )


@study.command("run", short_help="run studies, with one page of their results")
@click.argument("ids", nargs=-1, required=True, metavar="ID...|all")
@click.option("--out", type=FOLDER, required=True, help="folder of the results and their page")
@click.option(
    "--dive",
    "package",
    type=FOLDER,
    help="package of a simulated dive  [default: the sample dive of a checkout]",
)
@_JOBS
@set_option
@runs_option
@allow_outside_option
def run_command(
    ids: tuple[str, ...],
    out: Path,
    package: Path | None,
    runs: Path,
    overrides: tuple[str, ...],
    jobs: int,
    allow_outside: bool,
) -> None:
    """Run studies and set them beside the sources on one page, OUT/index.html.

    Each leaves pictures, tables and its result as JSON in OUT/<id>. The page shows all that the
    folder holds, from this run and earlier ones. A study that fails costs itself.
    """
    from hullrecon.studies import STUDIES, failure_of, run_and_keep
    from hullrecon.studies.page.page import write_page
    from hullrecon.studies.registry import find_study

    chosen = [s.id for s in STUDIES] if "all" in ids else list(dict.fromkeys(ids))
    studies = [find_study(name) for name in chosen]
    dive = None
    if any(s.needs_dive for s in studies):
        first = next(s.id for s in studies if s.needs_dive)
        dive = open_dive(package or _sample(first), runs, overrides, allow_outside=allow_outside)
    progress = choose_progress(quiet=state_of().quiet)
    outcomes = []
    try:
        for outcome in run_and_keep(chosen, out, dive, jobs=jobs, progress=progress):
            outcomes.append(outcome)
    finally:
        page = write_page(out) if outcomes else None
    document = {
        "page": str(page),
        "studies": {o.kept.id: o.kept.failure or "done" for o in outcomes},
    }
    lines = [f"{o.kept.id}: {o.kept.failure or 'done'}, {o.kept.seconds:g} s" for o in outcomes]
    state_of().emit(document, [*lines, f"page: {page}"])
    failure = failure_of(outcomes, out)
    if failure is not None:
        raise failure


def _sample(study_id: str) -> Path:
    """Find the sample dive of a checkout. Raises UsageError where there is none."""
    from hullrecon.synthetic.sample import FOLDER as SAMPLE_DIVE

    if not SAMPLE_DIVE.is_dir():
        raise UsageError(
            f"{study_id} runs on a simulated dive, and the sample dive is not here",
            where=str(SAMPLE_DIVE),
            remedy="give one with --dive, `hullrecon simulate` makes it",
        )
    return SAMPLE_DIVE


def _table_command(name: str, about: str, short: str) -> click.Command:
    """Make the command of a study that ends in a table."""

    @click.argument("package", type=FOLDER)
    @_JOBS
    @set_option
    @runs_option
    @allow_outside_option
    def run(
        package: Path, runs: Path, overrides: tuple[str, ...], jobs: int, allow_outside: bool
    ) -> None:
        """Run the study on a dive, and print its table."""
        from hullrecon.evaluation.score import without_nan
        from hullrecon.studies import run_studies

        dive = open_dive(package, runs, overrides, allow_outside=allow_outside)
        progress = choose_progress(quiet=state_of().quiet)
        (found,) = run_studies(dive, [name], jobs=jobs, progress=progress)
        state_of().emit(without_nan(found.values), _table(found.heads, found.rows))

    return study.command(name, help=about, short_help=short)(run)


methods = _table_command(
    "methods",
    """Compare naive, geva and maxmix on one simulated dive, in one table.

    Each is solved as published and as weighted by us. The steps before `adjust` run once if they
    are out of date; `adjust` runs six times. As published is one solve from the registration on,
    without a deviation field, outliers left to the Huber loss.
    """,
    "compare naive, geva and maxmix",
)
surfaces = _table_command(
    "surfaces",
    """Compare surfaces as the sources make them with the product's, on one simulated dive.

    The DVL's surface by linear interpolation, by the radial kernel and Wendland's, and without the
    CAD model as reference; the hull as found by fusion along rays. The chain runs up to `detect` if
    it is out of date, `surface` five times more, `detect` once more.
    """,
    "compare ways to fit the surface",
)
links = _table_command(
    "links",
    """Compare links of images as the sources find and guard them with the product's.

    With Harris corners beside SIFT features, guarded by switches, and without a guard. The chain
    runs up to `links` if it is out of date, `features` once more and `links` three times.
    """,
    "compare ways to link images",
)


@study.command(short_help="draw the figures of the sources")
@click.argument("package", type=FOLDER)
@_JOBS
@set_option
@runs_option
@allow_outside_option
def figures(
    package: Path, runs: Path, overrides: tuple[str, ...], jobs: int, allow_outside: bool
) -> None:
    """Draw the sources' figures on one simulated dive, as pictures and tables.

    They are written to RUNS/<dive>/compare/figures.

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


for _command in (list_studies, run_command, methods, surfaces, links, figures):
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
