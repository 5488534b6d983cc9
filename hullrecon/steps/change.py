# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What changed on the hull since an earlier dive: the step `change`, and runs for `diff`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from hullrecon.artifacts.manifest import Manifest, hash_file
from hullrecon.artifacts.stage import Context
from hullrecon.change.compare_surveys import SAME_CAD_M, cad_model_gap, compare_surveys
from hullrecon.change.options import ChangeOptions, EarlierDive
from hullrecon.errors import InputError, StageError
from hullrecon.geometry.charts.address import AddressSigma, address
from hullrecon.geometry.charts.outside_map import OutsideMap, outside_map
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.change import HullChange, HullSurvey
from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.change.chapter import change_chapter, is_predicted
from hullrecon.report.change.files import change_files
from hullrecon.steps.artifacts import (
    CHANGE_CHAPTER,
    AdjustArtifact,
    DetectArtifact,
    IngestArtifact,
    SurfaceArtifact,
)
from hullrecon.steps.finished_run import HULL_SURVEY_FILES, finished_steps, workspace_of
from hullrecon.typing import Array

NEEDED = tuple(HULL_SURVEY_FILES)  # steps whose artifacts are compared


@dataclass(frozen=True, kw_only=True)
class FinishedRun:
    """A run to compare with another."""

    survey: HullSurvey
    cad_model: Mesh
    frame_spacing_m: float | None  # of the ship's frames, None if unknown
    last_t_ns: int  # time of the path's last pose


def read_run(run: Path) -> FinishedRun:
    """Read a run's survey, given as RUNS/<dive>.

    Raises InputError if the run is not finished, is damaged, or has no CAD model.
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
    """Read a survey from the artifacts of the steps in NEEDED.

    Raises InputError if it has no CAD model or found too little of the hull.
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
    """Compare two runs of one hull.

    The result tells which objects are new, gone or changed, and where the surface moved.
    Raises InputError when the CAD models are of different hulls, StageError when too little hull
    was seen by both runs.
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
    """Build the map of the run's rasters, in which a comparison with a later dive is drawn.

    It reaches as far as this run measured the hull as found.
    """
    as_found = run.survey.as_found
    return outside_map(run.survey.chart, as_found.vertices[as_found.support > 0], "M")


def _refuse_damaged(folders: Mapping[str, Path], manifests: Mapping[str, Manifest]) -> None:
    """Raise InputError if a file to read is not as its step wrote it.

    Files that the step never wrote are no error here: a dive may lack them.
    """
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


def run(context: Context[EarlierDive]) -> None:
    """Write what changed since the earlier dive, and the texts of the report's chapter.

    It warns where both dives lie farther apart than their hull poses' sigmas explain. Raises
    StageError if they cannot be compared.
    """
    before, change = _compare(context)
    files = change_files(change, map_of(before), _this_dive(context).last_t_ns)
    for name, data in files.items():
        context.out.bytes(name, data)
    context.out.json(CHANGE_CHAPTER, msgspec.to_builtins(change_chapter(change)))
    if not is_predicted(change.offset):
        context.warn(
            f"{change.first} and this dive lie farther apart on the CAD model than their hull "
            "poses foresaw: one of these is worse than it says"
        )


def _compare(context: Context[EarlierDive]) -> tuple[FinishedRun, HullChange]:
    """Compare this dive with the earlier dive.

    Raises StageError for any obstacle: with it this step fails alone, and the report is made
    without the comparison.
    """
    earlier = str(context.parameters.earlier)
    try:
        before, after = _earlier_dive(context), _this_dive(context)
        return before, compare_runs(before, after)
    except InputError as error:
        what, remedy = error.what, error.remedy
    except OSError as error:
        what, remedy = f"its files cannot be read: {error.strerror}", "give leave to read it"
    raise StageError(
        f"no comparison with an earlier dive: {what}",
        where=f"change.earlier = {earlier}",
        remedy=remedy,
    )


def _earlier_dive(context: Context[EarlierDive]) -> FinishedRun:
    """Read the earlier dive, and name it by its run's folder.

    If both dives have the same name, the parent folder is part of its name, so that the report can
    tell them apart. Raises InputError if the run is this dive's own, or cannot be compared.
    """
    root = workspace_of(context.source / str(context.parameters.earlier)).root.resolve()
    if root == context.inputs["detect"].resolve().parent:
        raise InputError("that is this dive's own run", remedy="name the run of an earlier dive")
    found = read_run(root)
    if found.survey.name != context.settings["dive.name"]:
        return found
    return replace(found, survey=replace(found.survey, name=f"{root.parent.name}/{root.name}"))


def _this_dive(context: Context[EarlierDive]) -> FinishedRun:
    """Read the results of this dive as of a finished run."""
    spacing = context.settings.read_optional("hull.frame_spacing", float)
    return read_survey(context.inputs, context.settings.read("dive.name", str), spacing)
