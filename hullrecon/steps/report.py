# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Everything that people take away, and the page that they open first."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import msgspec

from hullrecon.artifacts.stage import Context
from hullrecon.dive.config.schema import Dive, Hull
from hullrecon.geometry.charts.outside_map import outside_map
from hullrecon.records.deliverables import Coverage, ReportedObject
from hullrecon.report.change.chapter import ChangeChapter
from hullrecon.report.deliver import deliver
from hullrecon.report.deliverables import missing_deliverables
from hullrecon.report.logo import read_logo
from hullrecon.report.options import ReportOptions
from hullrecon.report.survey import (
    AdjustedDive,
    AdjustSummary,
    Carried,
    DetectFacts,
    DiveFacts,
    Document,
    EarlierComparison,
    Findings,
    LogFindings,
    Mosaic,
    MosaicFacts,
    Mosaics,
    NavigationFacts,
    PairFacts,
    Provenance,
    StepRun,
    SurfaceFacts,
    Surfaces,
    Survey,
)
from hullrecon.rig import Rig, rig_from_settings
from hullrecon.steps.artifacts import AdjustArtifact, DetectArtifact, InputArtifacts
from hullrecon.steps.chain import NAMES
from hullrecon.steps.finished_run import TRACEBACKS
from hullrecon.steps.mosaics import TILES, TILESET

CHAIN = NAMES[:-1]  # without this step
MOSAICS = {"mosaic-optical": "optical", "mosaic-sonar": "sonar"}
DELIVERED = {  # files of a mosaic step, and their names in deliver/ ({}: optical or sonar)
    "ortho.tif": "ortho_{}.tif",
    "ortho.png": "ortho_{}.png",
    "mosaic.glb": "mosaic_{}.glb",
    "variance.tif": "variance_{}.tif",
    "views.tif": "views_{}.tif",
}
SURFACE_RASTERS = tuple(
    f"{name}.tif" for name in ("deviation", "deviation_sigma", "form", "form_sigma", "support")
)


def run(context: Context[ReportOptions]) -> None:
    """Write deliver/ from the artifacts of the chain.

    A deliverable that cannot be written gives a warning. Its traceback is in TRACEBACKS of the
    step's folder.
    """
    failures = deliver(read_survey(context), context.out, stream=context.stream)
    for failure in failures:
        context.warn(f"{failure.name} could not be written: {failure.reason}")
    if failures:
        traces = "\n".join(f"{failure.name}\n{failure.traceback}" for failure in failures)
        context.out.bytes(TRACEBACKS, traces.encode())


def read_survey(context: Context[ReportOptions]) -> Survey:
    """Collect what the steps found from their artifacts, and why deliverables are missing.

    What a step would have found is None or empty if the dive has no such step, or it failed alone.
    """
    artifacts = InputArtifacts(context.inputs)
    adjusted = _adjusted(artifacts.adjust) if artifacts.adjust is not None else None
    solution = adjusted.solution if adjusted is not None else None
    rig = rig_from_settings(artifacts.mounted(context.settings), artifacts.camera_models)
    mosaics = {
        name: _read_mosaic(context.inputs[step])
        for step, name in MOSAICS.items()
        if step in context.inputs
    }
    facts = artifacts.detect.facts if artifacts.detect is not None else {}
    detect = msgspec.convert({**facts, "objects": _reason(facts)}, DetectFacts)
    track = artifacts.track
    survey = Survey(
        facts=_dive_facts(
            context, artifacts, rig if solution is None else rig.with_mounts(solution.mounts)
        ),
        track=track,
        trajectory=artifacts.navigate.trajectory,
        adjusted=adjusted,
        surfaces=_surfaces(
            context, artifacts, track.frame, found_by_images=detect.as_found is None
        ),
        findings=_findings(artifacts.detect, detect),
        mosaics=Mosaics(optical=mosaics.get("optical"), sonar=mosaics.get("sonar")),
        change=_change(artifacts),
        provenance=Provenance(
            steps=tuple(
                _step_run(context.inputs[name], name) for name in CHAIN if name in context.inputs
            ),
            carried=Carried(
                camera=rig.tray_from_top is not None,
                sonar=context.settings["sonar.mount"] is not None
                and artifacts.ingest.sonar is not None,
                cad_model=context.settings["hull"] is not None,
                earlier_dive=context.settings["change.earlier"] is not None,
            ),
            failures=context.failures,
            copies=_copies(context),
        ),
    )
    missing = missing_deliverables(survey)
    return replace(survey, provenance=replace(survey.provenance, missing=missing))


def _reason(facts: Document) -> str | None:
    """Read why objects were not looked for. None if they were: detect.json then holds a number."""
    objects = facts.get("objects")
    return objects if isinstance(objects, str) else None


def _adjusted(artifact: AdjustArtifact) -> AdjustedDive:
    """Collect the solution with its summary, and the record of the solve if there is one.

    The record holds figures of each iteration. It is empty if the folder has none.
    """
    weak = artifact.summary.get("weak_directions")
    return AdjustedDive(
        solution=artifact.solution,
        summary=msgspec.convert(artifact.summary, AdjustSummary),
        weak_directions=tuple(weak) if isinstance(weak, list) else (),
        iterations=artifact.iterations if (artifact.folder / "iterations.npz").exists() else {},
        depth_sigma_m=artifact.depth_sigma_m,
    )


def _dive_facts(context: Context[ReportOptions], artifacts: InputArtifacts, rig: Rig) -> DiveFacts:
    """Collect the dive, the sensors that it carried, and what its log says.

    The DVL is left out where the path is that of the stereo cameras. rig: with the adjusted mounts,
    if there are any.
    """
    ingest, matches, logo = artifacts.ingest, artifacts.matches, context.parameters.logo
    return DiveFacts(
        dive=context.settings.read_optional("dive", Dive) or Dive(name="dive"),
        hull=context.settings.read_optional("hull", Hull),
        dvl=None if artifacts.navigate.facts.get("source") == "stereo" else ingest.dvl,
        returns=artifacts.navigate.returns,
        has_depth=ingest.pressure is not None,
        has_attitude=ingest.imu is not None,
        rig=rig,
        images={camera: ingest.images(camera, context.source) for camera in rig.cameras},
        log=msgspec.convert(ingest.findings, LogFindings),
        navigation=msgspec.convert(artifacts.navigate.facts, NavigationFacts),
        pairs=msgspec.convert(matches.pairs if matches is not None else {}, PairFacts),
        node_pairs=artifacts.links.compared if artifacts.links is not None else None,
        about=context.parameters,
        logo=None if logo is None else read_logo(context.source / logo),
    )


def _surfaces(
    context: Context[ReportOptions], artifacts: InputArtifacts, frame: str, *, found_by_images: bool
) -> Surfaces:
    """Collect the chart and the surfaces that the dive has. What it lacks is None.

    Without the step surface the chart is the adjustment's, and there is no map of the rasters.

    frame: of the path, for that map. found_by_images: the hull as found is of landmarks, not of the
    DVL's returns.
    """
    surface = artifacts.surface if "surface" in context.inputs else None
    detect = artifacts.detect
    as_found = detect.as_found if detect is not None else None
    if surface is None:
        return Surfaces(
            chart=artifacts.adjust.chart if artifacts.adjust is not None else None,
            as_found=as_found,
            found_by_images=found_by_images,
        )
    chart, surveyed = surface.chart, surface.surface
    return Surfaces(
        chart=chart,
        outside=outside_map(chart, surveyed.vertices, frame),
        surveyed=surveyed,
        as_found=as_found,
        deviation=detect.deviation if detect is not None else None,
        comparison=msgspec.convert(surface.facts, SurfaceFacts).comparison or "",
        cad_model=artifacts.ingest.hull,
        found_by_images=found_by_images,
    )


def _findings(artifact: DetectArtifact | None, detect: DetectFacts) -> Findings:
    """Collect objects and coverage as found. Empty without the step detect.

    Where objects were not looked for, the reason stands in their place. `documents` are the JSON
    files as they are delivered.
    """
    if artifact is None:
        return Findings()
    rows = artifact.objects.get("objects") if detect.objects is None else None
    documents: dict[str, Document] = {}
    if rows is not None:
        documents["objects.json"] = {"objects": rows}
    if artifact.coverage:
        documents["coverage.json"] = artifact.coverage
    return Findings(
        not_looked_for=detect.objects or "",
        objects=None if rows is None else msgspec.convert(rows, tuple[ReportedObject, ...]),
        not_reported=detect.not_reported,
        coverage=msgspec.convert(artifact.coverage, Coverage) if artifact.coverage else None,
        documents=documents,
    )


def _read_mosaic(folder: Path) -> Mosaic | None:
    """Read facts and preview of a mosaic step. None if it left no mosaic."""
    facts, preview = folder / "mosaic.json", folder / "ortho.png"
    if not facts.exists() or not preview.exists():
        return None
    return Mosaic(
        facts=msgspec.json.decode(facts.read_bytes(), type=MosaicFacts),
        preview=preview.read_bytes(),
        has_mesh=(folder / "mosaic.glb").exists(),
    )


def _change(artifacts: InputArtifacts) -> EarlierComparison | None:
    """Collect the chapter on change since the earlier dive. None without one."""
    found = artifacts.change
    if found is None:
        return None
    return EarlierComparison(chapter=msgspec.convert(found.chapter, ChangeChapter), map=found.map)


def _copies(context: Context[ReportOptions]) -> dict[str, Path]:
    """Find the files that are delivered as a step left them, by their name in deliver/.

    Files that a step did not leave are skipped, so there may be none.
    """
    copies = {}
    if "adjust" in context.inputs:
        copies = _files_of(context.inputs["adjust"] / "colmap", "colmap")
    for step, name in MOSAICS.items():
        for source, target in DELIVERED.items():
            if step in context.inputs and (context.inputs[step] / source).exists():
                copies[target.format(name)] = context.inputs[step] / source
        if step in context.inputs and (context.inputs[step] / TILES / TILESET).exists():
            copies |= _files_of(context.inputs[step] / TILES, f"tiles/{name}")
    for step in reversed(MOSAICS):  # on the optical mosaic's grid if there is an optical mosaic
        for name in SURFACE_RASTERS if step in context.inputs else ():
            if (context.inputs[step] / name).exists():
                copies[name] = context.inputs[step] / name
    change = InputArtifacts(context.inputs).change
    return copies | {
        f"change/{file.name}": file for file in (change.delivered if change is not None else ())
    }


def _files_of(folder: Path, name: str) -> dict[str, Path]:
    """Find all files below a folder, by their name in deliver/, which begins with `name`.

    Empty if the folder is missing.
    """
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {f"{name}/{file.relative_to(folder).as_posix()}": file for file in files}


def _step_run(folder: Path, name: str) -> StepRun:
    """Read a step's run from its manifest. Empty for a folder made by hand, without manifest."""
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    recipe = manifest.get("recipe", {})
    return StepRun(
        name=name,
        version=int(recipe.get("version", 0)),
        settings=recipe.get("settings", {}),
        inputs=recipe.get("inputs", {}),
        warnings=tuple(manifest.get("warnings", ())),
        run=manifest.get("run", {}),
    )
