# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Steps of a studied dive: what they read, and variants of them in RUNS/<dive>/compare."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.chain import Chain, assess_step, inputs_of
from hullrecon.artifacts.recipe import make_job
from hullrecon.artifacts.runner import RunContext, build
from hullrecon.artifacts.stage import Stage
from hullrecon.artifacts.workspace import COMPARE_FOLDER, Workspace
from hullrecon.steps.artifacts import InputArtifacts


def inputs_of_step(dive: DiveRun, name: str) -> InputArtifacts:
    """Read the input artifacts of a step."""
    return InputArtifacts(
        inputs_of(dive.chain.stage(name), dive.chain, dive.workspace, dive.chain.skip_reasons())
    )


def with_stages(chain: Chain, *stages: Stage) -> Chain:
    """Put stages in place of those of their names."""
    own = {stage.name: stage for stage in stages}
    return replace(chain, stages=tuple(own.get(stage.name, stage) for stage in chain.stages))


def workspace_beside(dive: DiveRun, name: str) -> Workspace:
    """Choose where a variant of a name lies."""
    return Workspace(dive.workspace.root / COMPARE_FOLDER / name.replace(" ", "-"))


def build_beside(
    dive: DiveRun,
    name: str,
    step: str,
    chain: Chain,
    run_context: RunContext,
    replaced: Mapping[str, Path] = MappingProxyType({}),
) -> Workspace:
    """Bring a step of a variant's chain up to date beside the dive's own. Returns where it lies."""
    workspace = workspace_beside(dive, name)
    with dive.workspace.lock():
        build_step(step, chain, dive.workspace, workspace, run_context, replaced)
        run_context.hashes.save()
    return workspace


def build_step(
    name: str,
    chain: Chain,
    upstream: Workspace,
    target: Workspace,
    run_context: RunContext,
    replaced: Mapping[str, Path] = MappingProxyType({}),
) -> None:
    """Bring one step up to date in another workspace than that of its inputs.

    `replaced`: inputs that are not those of `upstream`, by step.
    """
    stage = chain.stage(name)
    job = make_job(
        stage,
        chain.sections,
        {**inputs_of(stage, chain, upstream, chain.skip_reasons()), **replaced},
        chain.package,
        run_context.hashes,
    )
    if assess_step(job, target, run_context.hashes).to_do:
        build(job, target.root / stage.name, target.build_folder(stage.name), run_context)
