# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run studies on a simulated dive, from the shell or a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.progress import Progress
from hullrecon.artifacts.runner import RunContext
from hullrecon.artifacts.workspace import COMPARE_FOLDER
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.studies.registry import FIGURES, find_study
from hullrecon.studies.study import DiveStudy, StudyDive, StudyResult

if TYPE_CHECKING:
    from hullrecon.api.dive_run import DiveRun
    from hullrecon.studies.figure_style import PublishedFigure


def run_studies(
    dive: DiveRun, names: Sequence[str], *, jobs: int = 1, progress: Progress | None = None
) -> list[StudyResult]:
    """Run studies in order, making what several need once.

    Raises UsageError for an unknown id, InputError when the package holds no truth.
    """
    studies = [find_study(name) for name in names]
    with choose_executor(jobs) as executor:
        context = RunContext(dive.workspace.hashes(), executor, progress or Progress())
        given = StudyDive(dive, context)
        return [s.run(given) if isinstance(s, DiveStudy) else s.run() for s in studies]


def compare_methods(
    dive: DiveRun, *, jobs: int = 1, progress: Progress | None = None
) -> StudyResult:
    """Solve a simulated dive by every method, as published and as weighted by us, and score each.

    Raises InputError when the package holds no truth.
    """
    return run_studies(dive, ["methods"], jobs=jobs, progress=progress)[0]


def draw_figures(
    dive: DiveRun, *, jobs: int = 1, progress: Progress | None = None
) -> tuple[Path, list[PublishedFigure]]:
    """Draw the sources' figures on a simulated dive into RUNS/<dive>/compare/figures.

    Solves what `compare_methods` has not solved, runs the chain up to `detect`, whose heights are
    the ones delivered, and with one camera `links` for each two-view model. Raises InputError when
    the package holds no truth.
    """
    results = run_studies(dive, FIGURES, jobs=jobs, progress=progress)
    figures = [figure for result in results for figure in result.figures]
    folder = dive.workspace.root / COMPARE_FOLDER / "figures"
    out = ArtifactWriter(folder)
    for figure in figures:
        out.bytes(f"{figure.name}.png", figure.png)
        out.text(f"{figure.name}.csv", figure.csv)
    return folder, figures
