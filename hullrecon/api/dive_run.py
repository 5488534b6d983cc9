# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A dive package with its chain of steps and the folder of its run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.manifest import hash_file
from hullrecon.artifacts.workspace import PUBLISHED, Workspace
from hullrecon.errors import InputError


@dataclass(frozen=True)
class DiveRun:
    """A dive package, read, with the folder of its artifacts."""

    name: str
    chain: Chain
    workspace: Workspace

    @property
    def deliver(self) -> Path:
        """Return the folder of the deliverables, whether it is there yet or not."""
        return self.workspace.root / PUBLISHED


def open_dive(
    target: Path | str,
    runs: Path | str = "runs",
    overrides: Sequence[str] = (),
    *,
    allow_outside: bool = False,
) -> DiveRun:
    """Return a dive, given its package, or the folder of a run, whose package is the one that it
    last read.

    runs: folder of all runs. overrides: `section.key=value` in place of those of dive.toml.
    allow_outside: the package may name files outside its folder. Raises InputError when the target
    is neither package nor run and for such files, UsageError for a wrong configuration.
    """
    from hullrecon.dive.config.load import FILE, load_config
    from hullrecon.dive.package_files import check_files
    from hullrecon.steps.chain import stages

    given = Path(target)
    workspace = Workspace(given) if Workspace(given).exists() else None
    package = given if workspace is None else package_of(workspace)
    steps = stages()
    read_before = {FILE: hash_file(package / FILE)} if (package / FILE).is_file() else {}
    config = load_config(package, {stage.name: stage.parameters for stage in steps}, overrides)
    check_files(
        config,
        allow_outside=allow_outside,
        trusted_keys=[text.partition("=")[0].strip() for text in overrides],
    )
    name = config.config.dive.name
    return DiveRun(
        name,
        Chain(steps, config.sections, package, read_before),
        workspace or Workspace(Path(runs) / name),
    )


def package_of(workspace: Workspace) -> Path:
    """Return the package that a run read last. Raises InputError where the run does not say."""
    package = workspace.package
    if package is None:
        raise InputError(
            "this run does not say which dive package it read",
            where=str(workspace.root),
            remedy="give the package's folder",
        )
    return package
