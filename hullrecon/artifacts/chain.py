# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The steps of a dive in order, and which steps a run would rebuild."""

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

State = Literal["up to date", "not run yet", "out of date", "damaged", "skipped"]


@dataclass(frozen=True)
class Chain:
    """Stages, each after its inputs, with the configuration and the package that they run on."""

    stages: tuple[Stage, ...]
    sections: Mapping[str, object]  # of dive.toml, by dotted name
    package: Path  # folder
    # files of the package that the configuration came from, by their path in it
    read_before: Mapping[str, FileRecord] = field(default_factory=dict)

    def stage(self, name: str) -> Stage:
        """Look up the stage of that name. Raises UsageError if there is no such step."""
        for stage in self.stages:
            if stage.name == name:
                return stage
        raise unknown_step(name, [stage.name for stage in self.stages])

    def up_to(self, name: str) -> Chain:
        """Select the stages that a step needs or can use, and the step itself.

        Raises UsageError if there is no such step.
        """
        by_name = {stage.name: stage for stage in self.stages}
        needed, to_visit = set[str](), [self.stage(name)]
        while to_visit:
            stage = to_visit.pop()
            needed.add(stage.name)
            names = {*stage.inputs, *stage.optional} - needed
            to_visit += [by_name[n] for n in names if n in by_name]
        return replace(self, stages=tuple(s for s in self.stages if s.name in needed))

    def pairs_beside(self) -> list[tuple[str, str]]:
        """List the pairs of stages that could run at the same time: neither waits for the other.

        Waiting is transitive: a stage also waits for the inputs of its inputs.
        """
        pairs, waits_for = list[tuple[str, str]](), dict[str, set[str]]()
        for stage in self.stages:
            named = {*stage.inputs, *stage.optional} & waits_for.keys()
            waits_for[stage.name] = named.union(*(waits_for[name] for name in named))
            earlier = [name for name in waits_for if name != stage.name]
            pairs += [(name, stage.name) for name in earlier if name not in waits_for[stage.name]]
        return pairs

    def skip_reasons(self) -> dict[str, str]:
        """Find the steps that this dive cannot have, with the reason.

        A step whose needed input is skipped is skipped too.
        """
        reasons: dict[str, str] = {}
        for stage in self.stages:
            own = None
            if stage.applies is not None:
                own = stage.applies(settings_for(stage, self.sections), self.package)
            lost = next((name for name in stage.inputs if name in reasons), None)
            if own is not None:
                reasons[stage.name] = own
            elif lost is not None:
                reasons[stage.name] = f"it needs {lost}, which is skipped: {reasons[lost]}"
        return reasons


def unknown_step(name: str, names: Sequence[str]) -> UsageError:
    """Build the error for a step that does not exist, with the nearest name or all names."""
    near = get_close_matches(name, names, 1)
    if near:
        return UsageError(f"unknown step {name!r}; did you mean {near[0]!r}?")
    return UsageError(f"unknown step {name!r}", remedy=f"the steps are {', '.join(names)}")


def inputs_of(
    stage: Stage, chain: Chain, workspace: Workspace, skipped: Mapping[str, str]
) -> dict[str, Path]:
    """Look up the folders of a stage's inputs that are part of this dive's chain."""
    part = {s.name for s in chain.stages} - set(skipped)
    names = (*stage.inputs, *stage.optional)
    return {name: workspace.artifact(name) for name in names if name in part}


@dataclass(frozen=True, kw_only=True)
class StepStatus:
    """Whether one step is up to date, and if not, why not."""

    stage: Stage
    state: State
    reasons: tuple[str, ...] = ()  # sentences, none when up to date
    manifest: Manifest | None = None  # of the present artifact, if readable

    def why_run(self) -> str:
        """Say in one line why the step runs."""
        if self.reasons:
            return "; ".join(self.reasons)
        return "first run" if self.state == "not run yet" else "from scratch"

    @property
    def to_do(self) -> bool:
        return self.state not in ("up to date", "skipped")


def assess_chain(chain: Chain, workspace: Workspace, hashes: HashCache) -> list[StepStatus]:
    """Assess every step, in the chain's order, without changing anything.

    A step is also out of date if an input of it will be rebuilt.
    """
    skipped = chain.skip_reasons()
    found: list[StepStatus] = []
    for stage in chain.stages:
        if stage.name in skipped:
            found.append(StepStatus(stage=stage, state="skipped", reasons=(skipped[stage.name],)))
            continue
        inputs = inputs_of(stage, chain, workspace, skipped)
        waiting = [s.stage.name for s in found if s.to_do and s.stage.name in inputs]
        ready = {name: folder for name, folder in inputs.items() if name not in waiting}
        job = make_job(stage, chain.sections, ready, chain.package, hashes)
        status = assess_step(job, workspace, hashes)
        if waiting and status.state not in ("not run yet", "damaged"):
            # Such inputs were left out of the job, so that its recipe lacks them: say why instead.
            gone = {f"input {name} is gone" for name in waiting}
            own = [reason for reason in status.reasons if reason not in gone]
            reasons = (*own, *(f"input {name} will rerun" for name in waiting))
            status = replace(status, state="out of date", reasons=reasons)
        found.append(status)
    return found


def assess_step(job: Job, workspace: Workspace, hashes: HashCache) -> StepStatus:
    """Assess one step whose inputs are up to date.

    Its artifact is damaged if a file differs from the manifest, and out of date if the recipe in
    the manifest differs from the job's.
    """
    stage = job.stage
    try:
        manifest = workspace.manifest(stage.name)
    except DamagedArtifactError as error:
        return StepStatus(stage=stage, state="damaged", reasons=(str(error),))
    if manifest is None:
        return StepStatus(stage=stage, state="not run yet")
    reasons = damaged_files(workspace.artifact(stage.name), manifest, hashes)
    state: State = "damaged"
    if not reasons:
        reasons = differences(manifest.recipe, job.recipe)
        state = "out of date" if reasons else "up to date"
    return StepStatus(stage=stage, state=state, reasons=tuple(reasons), manifest=manifest)
