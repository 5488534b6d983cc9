# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A run as another dive of the same hull is compared with it, for the step `change` and for `diff`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec

from hullrecon.artifacts.manifest import Manifest, hash_file
from hullrecon.change.compare_surveys import compare_surveys
from hullrecon.change.options import ChangeOptions
from hullrecon.change.same_hull import SAME_CAD_M, cad_model_gap
from hullrecon.errors import InputError
from hullrecon.geometry.charts.address import AddressSigma, address
from hullrecon.geometry.charts.outside_map import OutsideMap, outside_map
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.change import HullChange, HullSurvey
from hullrecon.records.deliverables import ReportedObject
from hullrecon.steps.artifacts import (
    HULL_SURVEY_FILES,
    AdjustArtifact,
    DetectArtifact,
    IngestArtifact,
    SurfaceArtifact,
)
from hullrecon.steps.finished_run import finished_steps, workspace_of
from hullrecon.typing import Array

NEEDED = tuple(HULL_SURVEY_FILES)


@dataclass(frozen=True, kw_only=True)
class FinishedRun:
    """A run as it is compared. frame_spacing_m: of the ship's frames, None where it is not known;
    last_t_ns: of its path.
    """

    survey: HullSurvey
    cad_model: Mesh
    frame_spacing_m: float | None
    last_t_ns: int


def read_run(run: Path) -> FinishedRun:
    """Return a run's survey, given as RUNS/<dive>. Raises InputError, in one line, where the run is
    not finished, is damaged, or has no CAD model.
    """
    workspace = workspace_of(run)
    manifests = finished_steps(workspace, NEEDED)
    folders = {name: workspace.artifact(name) for name in NEEDED}
    _refuse_damaged(folders, manifests)
    spacing = manifests["detect"].recipe.settings.get("hull.frame_spacing")
    return read_survey(
        folders,
        workspace.root.resolve().name,
        float(spacing) if isinstance(spacing, int | float) else None,
        where=str(workspace.root),
    )


def read_survey(
    folders: Mapping[str, Path], name: str, frame_spacing_m: float | None, where: str = ""
) -> FinishedRun:
    """Return the survey that the artifacts of the steps in NEEDED hold. Raises InputError, with
    `where`, where it has no CAD model or found too little of the hull.
    """
    solution, detect = AdjustArtifact(folders["adjust"]).solution, DetectArtifact(folders["detect"])
    cad_model, as_found, split = (
        IngestArtifact(folders["ingest"]).hull,
        detect.as_found,
        detect.deviation,
    )
    if cad_model is None or solution.hull_pose is None:
        raise InputError(
            "the run has no CAD model that fits: two dives are compared on their hull's CAD model",
            where=where, remedy="give [hull] in dive.toml and run it again",
        )  # fmt: skip
    if as_found is None or split is None:
        raise InputError("the run found too little of the hull to be compared", where=where)
    return FinishedRun(
        survey=HullSurvey(
            name=name,
            chart=SurfaceArtifact(folders["surface"]).chart,
            as_found=as_found,
            form_sigma=split.form_sigma,
            hull_pose=solution.hull_pose,
            objects=msgspec.convert(detect.objects.get("objects", ()), tuple[ReportedObject, ...]),
        ),
        cad_model=cad_model,
        frame_spacing_m=frame_spacing_m,
        last_t_ns=int(solution.t_ns[-1]),
    )


def compare_runs(
    before: FinishedRun,
    after: FinishedRun,
    options: ChangeOptions = ChangeOptions(),  # noqa: B008
) -> HullChange:
    """Return what changed on a hull from one run to another.

    Raises InputError when the CAD models are of different hulls, StageError when the runs saw too
    little of the same hull.
    """
    gap = cad_model_gap(before.cad_model, after.cad_model)
    if not gap <= SAME_CAD_M:
        raise InputError(
            f"the CAD models are of different hulls: they lie up to {gap:.3g} m apart",
            where=f"{before.survey.name}, {after.survey.name}",
            remedy="compare dives of one hull with one CAD model",
        )
    spacing = after.frame_spacing_m or before.frame_spacing_m

    def address_of(point: Array, sigma: AddressSigma) -> str:
        return address(before.survey.chart, point[None], spacing, None, sigma)[0]

    return compare_surveys(before.survey, after.survey, address_of, options)


def map_of(run: FinishedRun) -> OutsideMap:
    """Return the map in which the run's rasters lie, which is that of a comparison with a later
    dive.
    """
    as_found = run.survey.as_found
    return outside_map(run.survey.chart, as_found.vertices[as_found.support > 0], "M")


def _refuse_damaged(folders: Mapping[str, Path], manifests: Mapping[str, Manifest]) -> None:
    """Raise InputError where a file that is read is not what its step wrote."""
    for step, names in HULL_SURVEY_FILES.items():
        for name in names:
            written = manifests[step].outputs.get(name)
            if written is not None and (
                not (folders[step] / name).is_file() or hash_file(folders[step] / name) != written
            ):
                raise InputError(
                    f"{step}/{name} is damaged",
                    where=str(folders[step].parent),
                    remedy="run that dive again",
                )
