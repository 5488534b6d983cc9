# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The steps of a dive in order, and which of them a run would make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Literal

from hullrecon.artifacts.documents import DamagedArtifactError
from hullrecon.artifacts.manifest import FileRecord, HashCache, Manifest
from hullrecon.artifacts.recipe import Job, differences, make_job
from hullrecon.artifacts.stage import Stage, settings_for
from hullrecon.artifacts.workspace import Workspace, damaged_files
from hullrecon.errors import UsageError


@dataclass(frozen=True)
class Chain:
    """Stages in an order in which each comes after its inputs, with the configuration and the
    package that they run on.

    read_before: the files of the package that the configuration came from, by their path relative
    to it.
    """

    stages: tuple[Stage, ...]
    sections: Mapping[str, object]
    package: Path
    read_before: Mapping[str, FileRecord] = field(default_factory=dict)

    def stage(self, name: str) -> Stage:
        """Return the stage of that name. Raises UsageError when there is no such step."""
        by_name = {stage.name: stage for stage in self.stages}
        if name not in by_name:
            raise unknown_step(name, tuple(by_name))
        return by_name[name]

    def up_to(self, name: str) -> Chain:
        """Return the part of the chain that `name` needs. Raises UsageError when there is no such
        step.
        """
        by_name = {stage.name: stage for stage in self.stages}
        needed, open_names = set[str](), [self.stage(name).name]
        while open_names:
            needed.add(current := open_names.pop())
            stage = by_name[current]
            open_names += [
                n for n in (*stage.inputs, *stage.optional) if n in by_name and n not in needed
            ]
        return replace(self, stages=tuple(s for s in self.stages if s.name in needed))

    def skip_reasons(self) -> dict[str, str]:
        """Return steps that this dive cannot have, with the reason; a step whose needed input is
        one of them is one too.
        """
        reasons: dict[str, str] = {}
        for stage in self.stages:
            own = (
                stage.applies(settings_for(stage, self.sections), self.package)
                if stage.applies is not None
                else None
            )
            lost = next((name for name in stage.inputs if name in reasons), None)
            if own is not None:
                reasons[stage.name] = own
            elif lost is not None:
                reasons[stage.name] = f"it needs {lost}, which is skipped: {reasons[lost]}"
        return reasons


def unknown_step(name: str, names: Sequence[str]) -> UsageError:
    """Return the error for a step that does not exist, with the nearest name or all of them."""
    near = get_close_matches(name, names, 1)
    remedy = f"the steps are {', '.join(names)}"
    return UsageError(
        f"unknown step {name!r}" + (f"; did you mean {near[0]!r}?" if near else ""),
        remedy="" if near else remedy,
    )


def inputs_of(
    stage: Stage, chain: Chain, workspace: Workspace, skipped: Mapping[str, str]
) -> dict[str, Path]:
    """Return the folders of the inputs that are part of this dive's chain."""
    part = {s.name for s in chain.stages} - set(skipped)
    return {
        name: workspace.artifact(name) for name in (*stage.inputs, *stage.optional) if name in part
    }


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
