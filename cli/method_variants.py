# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solve the variants of the adjustment that `compare` and `figures` show, and read them back."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import msgspec

from hullrecon.artifacts.execution.chain_runner import run_chain
from hullrecon.artifacts.execution.executor import Executor
from hullrecon.artifacts.execution.progress import choose_progress
from hullrecon.artifacts.execution.runner import RunContext, build
from hullrecon.artifacts.graph.chain import Chain, inputs_of
from hullrecon.artifacts.graph.job import make_job
from hullrecon.artifacts.graph.plan import assess_step
from hullrecon.artifacts.storage.workspace import Workspace
from hullrecon.errors import InputError

from .dives import DiveRun
from .state import state_of

if TYPE_CHECKING:
    from hullrecon.evaluation.comparison.comparison import Reckoned, Solved

COMPARED = "compare"  # RUNS/<dive>/compare/<variant>/adjust: one workspace a variant, beside the chain's own artifacts
WHOLE_SOLVE_ITERATIONS = 200  # 26 to 51 in [Ozog2016 Fig. 4.13]


def variants() -> list[tuple[str, str, bool]]:
    """Return (method, weighting, as_published) of every solve of the comparison."""
    from hullrecon.evaluation.comparison.method_comparison import METHODS, WEIGHTINGS

    return [(method, weighting, printed) for weighting, printed in WEIGHTINGS.items() for method in METHODS]


def solve_all(dive: DiveRun, executor: Executor) -> None:
    """Bring the steps before adjust up to date, then every variant of adjust that is not up to date."""
    hashes = dive.workspace.hashes()
    run_context = RunContext(hashes, executor, choose_progress(quiet=state_of().quiet))
    whole = dive.chain.up_to("adjust")
    before = replace(whole, stages=tuple(s for s in whole.stages if s.name != "adjust"))
    run_chain(before, dive.workspace, run_context)
    with dive.workspace.lock():
        for method, weighting, printed in variants():
            _solve(
                _variant_chain(whole, method, printed),
                dive.workspace,
                variant_workspace(dive, method, weighting, printed),
                run_context,
            )
        hashes.save()


def find_objects(dive: DiveRun, executor: Executor) -> None:
    """Bring the chain's own steps up to `detect` up to date, where the dive can have it: the heights that are delivered."""
    if any(s.name == "detect" for s in dive.chain.stages):
        run_context = RunContext(dive.workspace.hashes(), executor, choose_progress(quiet=state_of().quiet))
        run_chain(dive.chain.up_to("detect"), dive.workspace, run_context)


def _solve(chain: Chain, upstream: Workspace, variant: Workspace, run_context: RunContext) -> None:
    stage = next(s for s in chain.stages if s.name == "adjust")
    job = make_job(
        stage, chain.sections, inputs_of(stage, chain, upstream, chain.skip_reasons()), chain.package, run_context.hashes
    )
    if assess_step(job, variant, run_context.hashes).to_do:
        build(job, variant.root / stage.name, variant.build_folder(stage.name), run_context)


def _variant_chain(chain: Chain, method: str, as_published: bool) -> Chain:
    """Return the chain with a variant's options of adjust.

    As published is one solve from the registration on, as in [Ozog2016], so that its history is that of one cost function.
    """
    from hullrecon.adjustment.options import AdjustOptions

    own = chain.sections["adjust"]
    assert isinstance(own, AdjustOptions)
    own = msgspec.structs.replace(own, method=method, as_published=as_published)
    if as_published:
        own = msgspec.structs.replace(own, rounds=1, max_iterations=max(own.max_iterations, WHOLE_SOLVE_ITERATIONS))
    return replace(chain, sections={**chain.sections, "adjust": own})


def variant_workspace(dive: DiveRun, method: str, weighting: str, as_published: bool) -> Workspace:
    """Return the run's own workspace for the variant that the chain itself solves, else one below `compare`."""
    if _variant_chain(dive.chain, method, as_published).sections["adjust"] == dive.chain.sections["adjust"]:
        return dive.workspace
    return Workspace(dive.workspace.root / COMPARED / f"{method}-{weighting.replace(' ', '-')}")


def read_solutions(dive: DiveRun) -> list[Solved]:
    """Return what solve_all left. Raises InputError when a variant is missing."""
    from hullrecon.evaluation.comparison.comparison import read_solved

    found = []
    for method, weighting, printed in variants():
        variant = variant_workspace(dive, method, weighting, printed)
        manifest = variant.manifest("adjust")
        if manifest is None:
            raise InputError(f"{method} {weighting} was not solved", where=str(variant.root), remedy="run `hullrecon compare`")
        found.append(read_solved(method, weighting, variant.artifact("adjust"), manifest.run))
    return found


def read_dead_reckoning(dive: DiveRun) -> Reckoned:
    """Return the dead-reckoned dive, which the solves start from."""
    from hullrecon.evaluation.comparison.comparison import read_reckoned
    from hullrecon.geometry.poses import from_mount

    config = dive.config.config
    return read_reckoned(dive.workspace.artifact("navigate"), config.tray.origin, from_mount(config.dvl.mount))
