# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The steps of a dive in order, and which of them it cannot have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path

from hullrecon.artifacts.graph.settings import settings_for
from hullrecon.artifacts.graph.stage import Stage
from hullrecon.artifacts.storage.manifest import FileRecord
from hullrecon.artifacts.storage.workspace import Workspace
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
