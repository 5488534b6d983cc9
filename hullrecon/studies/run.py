# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of one dive: the comparison of the methods, and the sources' figures."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.progress import Progress
from hullrecon.artifacts.runner import RunContext
from hullrecon.artifacts.workspace import COMPARE_FOLDER
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.studies.methods.variants import (
    find_objects,
    read_dead_reckoning,
    read_objects,
    read_solutions,
    solve_all,
)

if TYPE_CHECKING:
    from hullrecon.api.dive_run import DiveRun
    from hullrecon.studies.figure_style import PublishedFigure
    from hullrecon.studies.methods.method_figures import MethodFigures


@dataclass(frozen=True, kw_only=True)
class MethodComparison:
    """Figures of every method and weighting, and the table of them."""

    figures: dict[str, MethodFigures]  # by method and weighting, then by part
    heads: list[str]
    rows: list[list[str]]


def compare_methods(
    dive: DiveRun, *, jobs: int = 1, progress: Progress | None = None
) -> MethodComparison:
    """Solve a simulated dive by every method, as published and as weighted by us, and score each.

    Raises InputError when the package holds no truth.
    """
    from hullrecon.evaluation.scoring.truth import read_truth
    from hullrecon.studies.methods.comparison import compare_solutions, comparison_table

    truth = read_truth(dive.chain.package)
    with _run_context(dive, jobs, progress) as run_context:
        solve_all(dive, run_context)
    figures = compare_solutions(read_solutions(dive), read_dead_reckoning(dive), truth)
    heads, rows = comparison_table(figures)
    return MethodComparison(figures=figures, heads=heads, rows=rows)


def draw_figures(
    dive: DiveRun, *, jobs: int = 1, progress: Progress | None = None
) -> tuple[Path, list[PublishedFigure]]:
    """Draw the sources' figures on a simulated dive into RUNS/<dive>/compare/figures.

    Solves what `compare_methods` has not solved, runs the chain up to `detect`, whose heights are
    the ones delivered, and with one camera `links` for each two-view model.

    Returns
    -------
    folder
        where pictures and tables were written.
    figures
        as drawn.

    Raises
    ------
    InputError
        when the package holds no truth.
    """
    from hullrecon.evaluation.scoring.truth import read_truth
    from hullrecon.studies.methods.figures import draw_method_figures
    from hullrecon.studies.paths.path_figures import draw_path_figures
    from hullrecon.studies.scenes.scene_figures import draw_scene_figures

    truth = read_truth(dive.chain.package)
    with _run_context(dive, jobs, progress) as run_context:
        solve_all(dive, run_context)
        find_objects(dive, run_context)
        start = read_dead_reckoning(dive)
        figures = draw_method_figures(read_solutions(dive), start, truth, read_objects(dive))
        figures += [*draw_path_figures(dive, start, truth, run_context), *draw_scene_figures()]
    folder = dive.workspace.root / COMPARE_FOLDER / "figures"
    out = ArtifactWriter(folder)
    for figure in figures:
        out.bytes(f"{figure.name}.png", figure.png)
        out.text(f"{figure.name}.csv", figure.csv)
    return folder, figures


@contextmanager
def _run_context(dive: DiveRun, jobs: int, progress: Progress | None) -> Iterator[RunContext]:
    with choose_executor(jobs) as executor:
        yield RunContext(dive.workspace.hashes(), executor, progress or Progress())
