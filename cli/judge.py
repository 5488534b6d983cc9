# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""evaluate, compare, figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import msgspec

from hullrecon.artifacts.chain import run_chain
from hullrecon.artifacts.executor import Executor, choose_executor
from hullrecon.artifacts.plan import Chain, assess, inputs_of
from hullrecon.artifacts.progress import choose_progress
from hullrecon.artifacts.runner import Means, build, make_job
from hullrecon.artifacts.workspace import Workspace
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.errors import InputError

from .dives import FOLDER, Opened, open_dive, runs_option, set_option
from .state import state_of

if TYPE_CHECKING:
    from hullrecon.evaluation.comparison import Reckoned, Solved

COMPARED = "compare"  # RUNS/<dive>/compare/<variant>/adjust: one workspace a variant, beside the chain's own artifacts


@click.command()
@click.argument("run", type=FOLDER, metavar="RUN_OR_DELIVER")
@click.argument("package", type=FOLDER)
def evaluate(run: Path, package: Path) -> None:
    """Figures of a run (RUNS/<dive> or its deliver/) against the truth in a simulated dive's PACKAGE."""
    from hullrecon.evaluation.judge import judge, plain, rows

    figures = judge(run, package)
    width = max(len(name) for name, _, _ in rows(figures))
    lines = [f"{name:{width}}  {value} {unit}".rstrip() for name, value, unit in rows(figures)]
    state_of().emit(plain(figures), lines)


@click.command()
@click.argument("package", type=FOLDER)
@click.option("--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="worker processes inside a step")
@set_option
@runs_option
def compare(package: Path, runs: Path, overrides: tuple[str, ...], jobs: int) -> None:
    """naive, geva and maxmix, each as printed and as weighted by us, on one simulated dive, in one table.

    The steps before `adjust` run once, or not at all when they are fresh; `adjust` runs six times.
    """
    from hullrecon.evaluation.comparison import compare as side_by_side
    from hullrecon.evaluation.comparison import table_rows
    from hullrecon.evaluation.judge import plain
    from hullrecon.evaluation.truth import read_truth

    dive = open_dive(package, runs, overrides)
    truth = read_truth(dive.chain.package)
    with choose_executor(jobs) as executor:
        solve_all(dive, executor)
    figures = side_by_side(solved_of(dive), reckoned_of(dive), truth)
    heads, rows = table_rows(figures)
    state_of().emit(plain(figures), _table(heads, rows))


@click.command()
@click.argument("package", type=FOLDER)
@set_option
@runs_option
def figures(package: Path, runs: Path, overrides: tuple[str, ...]) -> None:
    """The sources' plots from what `compare` left: pictures and the tables behind them, in RUNS/<dive>/compare/figures."""
    from hullrecon.evaluation.comparison import draw
    from hullrecon.evaluation.truth import read_truth

    dive = open_dive(package, runs, overrides)
    drawn = draw(solved_of(dive), reckoned_of(dive), read_truth(dive.chain.package))
    folder = dive.workspace.root / COMPARED / "figures"
    out = ArtifactWriter(folder)
    for figure in drawn:
        out.bytes(f"{figure.name}.png", figure.png)
        out.text(f"{figure.name}.csv", figure.csv)
    names = [f"{figure.name}.png" for figure in drawn]
    state_of().emit({"folder": str(folder), "figures": names}, [str(folder / name) for name in names])


def variants() -> list[tuple[str, str, bool]]:
    """(method, weighting, as_published) of every solve that is compared."""
    from hullrecon.evaluation.methods import METHODS, WEIGHTINGS

    return [(method, weighting, printed) for weighting, printed in WEIGHTINGS.items() for method in METHODS]


def solve_all(dive: Opened, executor: Executor) -> None:
    """Brings the steps before adjust up to date, then every variant of adjust that is not fresh."""
    hashes = dive.workspace.hashes()
    means = Means(hashes, executor, choose_progress(quiet=state_of().quiet))
    whole = dive.chain.up_to("adjust")
    before = replace(whole, stages=tuple(s for s in whole.stages if s.name != "adjust"))
    run_chain(before, dive.workspace, means)
    with dive.workspace.lock():
        for method, weighting, printed in variants():
            _solve(_with(whole, method, printed), dive.workspace, _place(dive, method, weighting), means)
        hashes.save()


def _solve(chain: Chain, upstream: Workspace, place: Workspace, means: Means) -> None:
    stage = next(s for s in chain.stages if s.name == "adjust")
    job = make_job(stage, chain.sections, inputs_of(stage, chain, upstream, chain.skipped()), chain.package, means.hashes)
    if assess(job, place, means.hashes).to_do:
        build(job, place.root / stage.name, place.building(stage.name), means)


def _with(chain: Chain, method: str, as_published: bool) -> Chain:
    own = msgspec.structs.replace(chain.sections["adjust"], method=method, as_published=as_published)
    return replace(chain, sections={**chain.sections, "adjust": own})


def _place(dive: Opened, method: str, weighting: str) -> Workspace:
    return Workspace(dive.workspace.root / COMPARED / f"{method}-{weighting.replace(' ', '-')}")


def solved_of(dive: Opened) -> list[Solved]:
    """What solve_all left. InputError when a variant is missing."""
    from hullrecon.evaluation.comparison import read_solved

    found = []
    for method, weighting, _ in variants():
        place = _place(dive, method, weighting)
        manifest = place.manifest("adjust")
        if manifest is None:
            raise InputError(
                f"{method} {weighting} was not solved", where=str(place.root), remedy="run `hullrecon compare` first"
            )
        found.append(read_solved(method, weighting, place.artifact("adjust"), float(manifest.run["seconds"])))
    return found


def reckoned_of(dive: Opened) -> Reckoned:
    from hullrecon.evaluation.comparison import read_reckoned
    from hullrecon.geometry.poses import from_mount

    sections = dive.chain.sections
    return read_reckoned(dive.workspace.artifact("navigate"), sections["tray"].origin, from_mount(sections["dvl"].mount))


def _table(heads: Sequence[str], rows: Sequence[Sequence[Any]]) -> Iterable[str]:
    """Columns as wide as they need, the first to the left."""
    cells = [list(heads), *([str(c) for c in row] for row in rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(heads))]
    for row in cells:
        first, *rest = (
            f"{cell:<{w}}" if k == 0 else f"{cell:>{w}}" for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        )
        yield "  ".join([first, *rest])
