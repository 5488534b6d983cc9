# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""evaluate, compare, figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import click

from hullrecon.artifacts.execution.executor import choose_executor
from hullrecon.artifacts.storage.writer import ArtifactWriter

from .dives import FOLDER, open_dive, runs_option, set_option
from .method_variants import COMPARED, find_objects, read_dead_reckoning, read_solutions, solve_all
from .state import state_of

_JOBS = click.option("--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="worker processes inside a step")


@click.command()
@click.argument("run", type=FOLDER, metavar="RUN_OR_DELIVER")
@click.argument("package", type=FOLDER)
def evaluate(run: Path, package: Path) -> None:
    """Figures of a run (RUNS/<dive> or its deliver/) against the truth in a simulated dive's PACKAGE."""
    from hullrecon.evaluation.scoring.score import judge, plain, rows

    figures = judge(run, package)
    width = max(len(name) for name, _, _ in rows(figures))
    lines = [f"{name:{width}}  {value} {unit}".rstrip() for name, value, unit in rows(figures)]
    state_of().emit(plain(figures), lines)


@click.command()
@click.argument("package", type=FOLDER)
@_JOBS
@set_option
@runs_option
def compare(package: Path, runs: Path, overrides: tuple[str, ...], jobs: int) -> None:
    """naive, geva and maxmix, each as printed and as weighted by us, on one simulated dive, in one table.

    The steps before `adjust` run once if they are out of date; `adjust` runs six times. As printed is one solve from
    the registration on, without a deviation field, outliers left to the Huber loss.
    """
    from hullrecon.evaluation.comparison.comparison import compare as side_by_side
    from hullrecon.evaluation.comparison.comparison import table_rows
    from hullrecon.evaluation.scoring.score import plain
    from hullrecon.evaluation.scoring.truth import read_truth

    dive = open_dive(package, runs, overrides)
    truth = read_truth(dive.chain.package)
    with choose_executor(jobs) as executor:
        solve_all(dive, executor)
    figures = side_by_side(read_solutions(dive), read_dead_reckoning(dive), truth)
    heads, rows = table_rows(figures)
    state_of().emit(plain(figures), _table(heads, rows))


@click.command()
@click.argument("package", type=FOLDER)
@_JOBS
@set_option
@runs_option
def figures(package: Path, runs: Path, overrides: tuple[str, ...], jobs: int) -> None:
    """The sources' figures on one simulated dive: pictures and the tables behind them, in RUNS/<dive>/compare/figures.

    Cross-sections of the three methods (Ozog's Fig. 4.10), labels by iteration (4.12), cost by iteration and by time (4.13),
    the DVL's residuals before and after (4.14), the height of a structure (4.16). Solves what `compare` has not solved, and
    runs the chain up to `detect`, whose heights are the ones delivered.
    """
    from hullrecon.evaluation.figures.figures import draw
    from hullrecon.evaluation.scoring.truth import read_truth

    dive = open_dive(package, runs, overrides)
    truth = read_truth(dive.chain.package)
    with choose_executor(jobs) as executor:
        solve_all(dive, executor)
        find_objects(dive, executor)
    drawn = draw(read_solutions(dive), read_dead_reckoning(dive), truth, dive.workspace.artifact("detect"))
    folder = dive.workspace.root / COMPARED / "figures"
    out = ArtifactWriter(folder)
    for figure in drawn:
        out.bytes(f"{figure.name}.png", figure.png)
        out.text(f"{figure.name}.csv", figure.csv)
    said = [f"{folder / figure.name}.png: {figure.words}" for figure in drawn]
    state_of().emit({"folder": str(folder), "figures": {f.name: f.words for f in drawn}}, said)


def _table(heads: Sequence[str], rows: Sequence[Sequence[Any]]) -> Iterable[str]:
    """Columns as wide as they need, the first to the left."""
    cells = [list(heads), *([str(c) for c in row] for row in rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(heads))]
    for row in cells:
        first, *rest = (
            f"{cell:<{w}}" if k == 0 else f"{cell:>{w}}" for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        )
        yield "  ".join([first, *rest])
