# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Say what a run would do: for each step whether it is up to date, and if not, why not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from hullrecon.artifacts.graph.chain import Chain, inputs_of
from hullrecon.artifacts.graph.job import Job, make_job
from hullrecon.artifacts.graph.stage import Stage
from hullrecon.artifacts.graph.staleness import differences
from hullrecon.artifacts.storage.documents import DamagedArtifactError
from hullrecon.artifacts.storage.hashing import HashCache
from hullrecon.artifacts.storage.manifest import Manifest
from hullrecon.artifacts.storage.workspace import Workspace, damaged_files

State = Literal["up to date", "not run yet", "out of date", "damaged", "skipped"]


@dataclass(frozen=True, kw_only=True)
class StepStatus:
    """The status of one step. reasons: sentences, empty when up to date. manifest: that of the
    present artifact, if readable.
    """

    stage: Stage
    state: State
    reasons: tuple[str, ...] = ()
    manifest: Manifest | None = None

    def why_run(self) -> str:
        """Say in one line why the step runs."""
        return "; ".join(self.reasons) or (
            "first run" if self.state == "not run yet" else "from scratch"
        )

    @property
    def to_do(self) -> bool:
        return self.state not in ("up to date", "skipped")


def assess_chain(chain: Chain, workspace: Workspace, hashes: HashCache) -> list[StepStatus]:
    """Return the status of every step, in the chain's order, without changing anything."""
    skipped = chain.skip_reasons()
    found: list[StepStatus] = []
    for stage in chain.stages:
        if stage.name in skipped:
            found.append(StepStatus(stage=stage, state="skipped", reasons=(skipped[stage.name],)))
            continue
        inputs = inputs_of(stage, chain, workspace, skipped)
        waiting = [s.stage.name for s in found if s.to_do and s.stage.name in inputs]
        found.append(_status_of(stage, chain, workspace, inputs, waiting, hashes))
    return found


def _status_of(
    stage: Stage,
    chain: Chain,
    workspace: Workspace,
    inputs: Mapping[str, Path],
    waiting: Sequence[str],
    hashes: HashCache,
) -> StepStatus:
    ready = {name: folder for name, folder in inputs.items() if name not in waiting}
    status = assess_step(
        make_job(stage, chain.sections, ready, chain.package, hashes), workspace, hashes
    )
    if not waiting or status.state in ("not run yet", "damaged"):
        return status
    own = [r for r in status.reasons if r not in {f"input {name} is gone" for name in waiting}]
    return replace(
        status,
        state="out of date",
        reasons=(*own, *(f"input {name} will rerun" for name in waiting)),
    )


def assess_step(job: Job, workspace: Workspace, hashes: HashCache) -> StepStatus:
    """Return the status of one step whose inputs are up to date."""
    stage = job.stage
    try:
        manifest = workspace.manifest(stage.name)
    except DamagedArtifactError as error:
        return StepStatus(stage=stage, state="damaged", reasons=(str(error),))
    if manifest is None:
        return StepStatus(stage=stage, state="not run yet", reasons=())
    harmed = damaged_files(workspace.artifact(stage.name), manifest, hashes)
    if harmed:
        return StepStatus(stage=stage, state="damaged", reasons=tuple(harmed), manifest=manifest)
    changed = differences(manifest.recipe, job.recipe)
    return StepStatus(
        stage=stage,
        state="out of date" if changed else "up to date",
        reasons=tuple(changed),
        manifest=manifest,
    )
