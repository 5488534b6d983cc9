# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""diff: what changed on a hull from one run to another."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from hullrecon.api.finished_run import finished_steps, workspace_of
from hullrecon.artifacts.storage.writer import ArtifactWriter
from hullrecon.change.compare_surveys import compare_surveys
from hullrecon.change.options import ChangeOptions
from hullrecon.errors import InputError, StorageError
from hullrecon.geometry.charts.address import AddressSigma, address
from hullrecon.geometry.charts.outside_map import outside_map
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.change import HullChange, HullSurvey
from hullrecon.records.deliverables import ReportedObject
from hullrecon.steps.artifacts import AdjustArtifact, DetectArtifact, IngestArtifact, SurfaceArtifact
from hullrecon.typing import Array

NEEDED = ("ingest", "adjust", "surface", "detect")
SAME_CAD_M = 0.002  # CAD models nowhere farther apart than this are of one hull
DOCUMENT = "change.json"


@dataclass(frozen=True, kw_only=True)
class FinishedRun:
    """A run as diff reads it. frame_spacing_m: of the ship's frames, None where it is not known; last_t_ns: of its path."""

    survey: HullSurvey
    cad_model: Mesh
    frame_spacing_m: float | None
    last_t_ns: int


@dataclass(frozen=True, kw_only=True)
class RunComparison:
    """What changed, and the second run, on whose time and ship the files are written."""

    change: HullChange
    first: FinishedRun
    second: FinishedRun


def diff(first: Path | str, second: Path | str, options: ChangeOptions = ChangeOptions()) -> RunComparison:  # noqa: B008
    """Return what changed on a hull from one run (RUNS/<dive>) to another.

    Raises InputError when one of them is no finished run with a CAD model or when the CAD models are of different hulls,
    StageError when they saw too little of the same hull.
    """
    before, after = read_run(Path(first)), read_run(Path(second))
    _refuse_other_hull(before, after)
    spacing = after.frame_spacing_m or before.frame_spacing_m

    def address_of(point: Array, sigma: AddressSigma) -> str:
        return address(before.survey.chart, point[None], spacing, None, sigma)[0]

    change = compare_surveys(before.survey, after.survey, address_of, options)
    return RunComparison(change=change, first=before, second=after)


def write_change(folder: Path, found: RunComparison) -> tuple[str, ...]:
    """Write change.json, change.csv, the layers, the map and the page into a folder, and return their names.

    Raises StorageError when the folder holds anything but an earlier comparison.
    """
    from hullrecon.report.change.deliver import change_files

    if folder.is_dir() and any(folder.iterdir()) and not (folder / DOCUMENT).is_file():
        raise StorageError("the folder is not empty", where=str(folder), remedy="name a new one by --out")
    first = found.first.survey
    outside = outside_map(first.chart, first.as_found.vertices[first.as_found.support > 0], "M")
    files = change_files(found.change, outside, found.second.last_t_ns)
    out = ArtifactWriter(folder)
    for name, data in files.items():
        out.bytes(name, data)
    return tuple(files)


def read_run(run: Path) -> FinishedRun:
    """Return a run's survey. Raises InputError, in one line, where the run is not finished or has no CAD model."""
    workspace = workspace_of(run)
    manifests = finished_steps(workspace, NEEDED)
    folder = {name: workspace.artifact(name) for name in NEEDED}
    solution, detect = AdjustArtifact(folder["adjust"]).solution, DetectArtifact(folder["detect"])
    cad_model, as_found, split = IngestArtifact(folder["ingest"]).hull, detect.as_found, detect.deviation
    if cad_model is None or solution.hull_pose is None:
        raise InputError(
            "the run has no CAD model that fits: two dives are compared on their hull's CAD model",
            where=str(workspace.root), remedy="give [hull] in dive.toml and run it again",
        )  # fmt: skip
    if as_found is None or split is None:
        raise InputError("the run found too little of the hull to be compared", where=str(workspace.root))
    spacing = manifests["detect"].recipe.settings.get("hull.frame_spacing")
    return FinishedRun(
        survey=HullSurvey(
            name=workspace.root.resolve().name,
            chart=SurfaceArtifact(folder["surface"]).chart,
            as_found=as_found,
            form_sigma=split.form_sigma,
            hull_pose=solution.hull_pose,
            objects=msgspec.convert(detect.objects.get("objects", ()), tuple[ReportedObject, ...]),
        ),
        cad_model=cad_model,
        frame_spacing_m=float(spacing) if isinstance(spacing, int | float) else None,
        last_t_ns=int(solution.t_ns[-1]),
    )


def cad_model_gap(first: Mesh, second: Mesh) -> float:
    """Return how far apart the surfaces of two CAD models lie at most, in metres, however they are meshed."""
    return max(_farthest_vertex(first, second), _farthest_vertex(second, first))


def _refuse_other_hull(before: FinishedRun, after: FinishedRun) -> None:
    """Raise InputError where the CAD models differ by geometry."""
    gap = cad_model_gap(before.cad_model, after.cad_model)
    if not gap <= SAME_CAD_M:
        raise InputError(
            f"the CAD models are of different hulls: they lie up to {gap:.3g} m apart",
            where=f"{before.survey.name}, {after.survey.name}", remedy="compare dives of one hull with one CAD model",
        )  # fmt: skip


def _farthest_vertex(mesh: Mesh, other: Mesh, most: int = 20_000) -> float:
    """Return the greatest distance in metres of a vertex of a mesh (of some `most` of them) from another mesh."""
    some = mesh.vertices[:: max(1, len(mesh.vertices) // most)]
    return float(np.abs(Scene(other).closest(some).distance).max(initial=0.0))
