# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The steps of a finished run, for commands that read results and run nothing."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from hullrecon.artifacts.documents import DamagedArtifactError
from hullrecon.artifacts.manifest import Manifest
from hullrecon.artifacts.workspace import PUBLISHED, Workspace
from hullrecon.errors import HullreconError, InputError

# Files from which two dives of one hull are compared, by step in the order of the chain
HULL_SURVEY_FILES = {
    "ingest": ("hull.npz",), "adjust": ("solution.npz",), "surface": ("chart.npz",),
    "detect": ("as_found.npz", "deviation.npz", "objects.json"),
}  # fmt: skip
TRACEBACKS = "tracebacks.txt"  # in the folder of report: of deliverables that could not be written


def workspace_of(run: Path) -> Workspace:
    """Open the workspace of a run, given as RUNS/<dive> or its deliver/.

    Raises InputError for any other folder.
    """
    workspace = Workspace(run.parent if run.name == PUBLISHED else run)
    if not workspace.exists():
        raise InputError(
            "this is no run", where=str(run), remedy="give RUNS/<dive>, as `hullrecon run` left it"
        )
    return workspace


def finished_steps(workspace: Workspace, needed: Sequence[str]) -> Mapping[str, Manifest]:
    """Read the manifests of the steps that a command needs, in the order of the chain.

    Together they are one state of the run. Raises InputError if a step is missing or damaged, or
    was not rerun after one of its inputs was.
    """
    found: dict[str, Manifest] = {}
    for name in needed:
        try:
            manifest = workspace.manifest(name)
        except DamagedArtifactError as error:
            raise InputError(
                f"the step {name} is damaged: {error}",
                where=str(workspace.root),
                remedy="run it again",
            ) from error
        if manifest is None:
            raise InputError(
                f"the run is not finished: it has no step {name}",
                where=str(workspace.root),
                remedy="run it to its end",
            )
        for name_of_input, content in manifest.recipe.inputs.items():
            if name_of_input in found and found[name_of_input].content_hash != content:
                raise InputError(
                    f"the run is not finished: {name_of_input} was rerun and {name} was not",
                    where=str(workspace.root), remedy="run it to its end",
                )  # fmt: skip
        found[name] = manifest
    return found


def failed_delivery(run: Path) -> HullreconError | None:
    """Build the error for deliverables that could not be written. None if all were.

    `run` is RUNS/<dive>. The error's exit code is that of an internal error.
    """
    summary, traces = run / "report" / "deliver" / "summary.json", run / "report" / TRACEBACKS
    if not traces.is_file():
        return None
    failed = json.loads(summary.read_text(encoding="utf-8"))["failed"]
    name, why = next(iter(failed.items()))
    more = f" and {len(failed) - 1} more" if len(failed) > 1 else ""
    return HullreconError(
        f"internal error: {name}{more} could not be written ({why}); all else is delivered",
        remedy=f"traceback in {traces}",
    )
