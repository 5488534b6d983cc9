# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run studies on a simulated dive, from the shell or a notebook."""

from __future__ import annotations

import logging
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.progress import Progress
from hullrecon.artifacts.runner import RunContext
from hullrecon.artifacts.workspace import COMPARE_FOLDER
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.errors import HullreconError, LockedError, StorageError
from hullrecon.studies.registry import FIGURES, find_study
from hullrecon.studies.results import TRACEBACK, KeptStudy, keep_failure, keep_result
from hullrecon.studies.study import DiveStudy, SceneStudy, StudyDive, StudyResult

if TYPE_CHECKING:
    from hullrecon.api.dive_run import DiveRun
    from hullrecon.studies.figure_style import PublishedFigure

log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class StudyOutcome:
    """A study that was run, and the error if it failed."""

    kept: KeptStudy
    error: Exception | None = None


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


def run_and_keep(
    names: Sequence[str],
    out: Path,
    dive: DiveRun | None,
    *,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Iterator[StudyOutcome]:
    """Run studies of the dive, then those of scenes, writing each into OUT/<id> when it ends.

    A study that fails costs itself: its reason is written in place of its result.

    Parameters
    ----------
    dive
        A simulated dive. None if no study named needs one.
    jobs
        Worker processes: inside the steps of the dive, and for so many scenes at a time.

    Raises
    ------
    UsageError
        A study is unknown.
    LockedError, StorageError
        What concerns all studies: another run holds the dive, or nothing can be written.
    """
    studies = [find_study(name) for name in names]
    with choose_executor(jobs) as executor:
        given = None
        if dive is not None:
            context = RunContext(dive.workspace.hashes(), executor, progress or Progress())
            given = StudyDive(dive, context)
        of_dive = [study for study in studies if study.needs_dive]
        scenes = [study.id for study in studies if not study.needs_dive]
        outcomes = chain(
            (_run_and_keep(study, given, out) for study in of_dive),
            executor.map(partial(_run_scene, out=out), scenes),
        )
        for left, outcome in zip(range(len(studies) - 1, -1, -1), outcomes, strict=True):
            ended = "failed" if outcome.error is not None else "done"
            log.info(
                "%s: %s in %.0f s, %d left", outcome.kept.id, ended, outcome.kept.seconds, left
            )
            yield outcome


def _run_scene(name: str, out: Path) -> StudyOutcome:
    """Run a study of scenes, here or in a worker process."""
    return _run_and_keep(find_study(name), None, out)


def _run_and_keep(
    study: DiveStudy | SceneStudy, given: StudyDive | None, out: Path
) -> StudyOutcome:
    """Run a study and write its result, or why it has none."""
    start = time.monotonic()
    try:
        if isinstance(study, SceneStudy):
            result = study.run()
        else:
            assert given is not None  # the caller names a dive for those that need one
            result = study.run(given)
        return StudyOutcome(kept=keep_result(study, result, time.monotonic() - start, out))
    except (LockedError, StorageError, MemoryError):
        raise
    except HullreconError as error:
        kept = keep_failure(study, error.line(), "", time.monotonic() - start, out)
        return StudyOutcome(kept=kept, error=error)
    except Exception as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        trace = "".join(traceback.format_exception(error))
        kept = keep_failure(study, reason, trace, time.monotonic() - start, out)
        return StudyOutcome(kept=kept, error=error)


def failure_of(outcomes: Sequence[StudyOutcome], out: Path) -> HullreconError | None:
    """Build the error for studies that failed, with the exit code of the first. None if none."""
    failed = [outcome for outcome in outcomes if outcome.error is not None]
    if not failed:
        return None
    first, error = failed[0].kept, failed[0].error
    which = f"study {first.id}" + (f" and {len(failed) - 1} more" if len(failed) > 1 else "")
    what = f"{which} failed: {first.failure}; all else is kept"
    if isinstance(error, HullreconError):
        return type(error)(what, where=str(out))
    return HullreconError(
        f"internal error: {what}", remedy=f"traceback in {out / first.id / TRACEBACK}"
    )


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
