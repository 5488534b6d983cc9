# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Everything that people take away, and the page that they open first."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from msgspec import Struct

from hullrecon.artifacts.graph.stage import Context, Stage, load_arrays
from hullrecon.dive.config.schema import Dive
from hullrecon.dive.images.store import ImageStore
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.charts.chart import chart_from_arrays
from hullrecon.geometry.poses import Poses
from hullrecon.records.sensors import DvlPings
from hullrecon.records.serialisation import Record, from_arrays
from hullrecon.records.solution import Solution
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Trajectory
from hullrecon.report.content.headline import weak_directions
from hullrecon.report.content.missing_deliverables import absences
from hullrecon.report.content.objects import objects_csv
from hullrecon.report.content.page import render
from hullrecon.report.content.page_context import page_view
from hullrecon.report.content.survey import Eye, Mosaic, StepRun, Survey
from hullrecon.report.export.csv_export import csv_text
from hullrecon.report.export.geometry_export import alignment_json, landmarks_ply, surface_ply
from hullrecon.report.export.summary import summary_json
from hullrecon.report.export.trajectory import track_of, trajectory_csv, trajectory_tum
from hullrecon.report.figures.gallery import all_plots
from hullrecon.steps.cameras import cameras_file, mount_of
from hullrecon.steps.features import external

FOLDER = "deliver"
CHAIN = ("ingest", "navigate", "features", "matches", "adjust", "surface", "detect", "mosaic-optical", "mosaic-sonar")
SECTIONS = ("dive", "logs", "tray", "camera.top", "camera.bottom", "sonar", "hull")
MOSAICS = {"mosaic-optical": "optical", "mosaic-sonar": "sonar"}


class ReportOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Of the report: it has none."""


class Shelf:
    """Writes deliverables and keeps their sizes and hashes."""

    def __init__(self, context: Context) -> None:
        self._out = context.out
        self.entries: dict[str, dict[str, Any]] = {}

    def put(self, name: str, data: bytes | str) -> None:
        raw = data.encode() if isinstance(data, str) else data
        self._out.bytes(f"{FOLDER}/{name}", raw)
        self.entries[name] = {"bytes": len(raw), "sha256": hashlib.sha256(raw).hexdigest()}

    def put_json(self, name: str, value: object) -> None:
        self.put(name, json.dumps(value, indent=1, sort_keys=True, allow_nan=False, ensure_ascii=False) + "\n")

    def copy(self, name: str, source: Path) -> None:
        with source.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
        with self._out.path(f"{FOLDER}/{name}") as target:
            shutil.copyfile(source, target)
        self.entries[name] = {"bytes": source.stat().st_size, "sha256": digest}


def run(context: Context) -> None:
    survey = read_survey(context)
    shelf = Shelf(context)
    _write_motion(shelf, survey)
    _write_surfaces(shelf, survey)
    _copy_models(shelf, context)
    plots = all_plots(survey)
    for plot in plots:
        shelf.put(f"plots/{plot.name}.png", plot.png)
        shelf.put(f"plots/{plot.name}.csv", csv_text(plot.table))
    view = page_view(survey, plots, dict(sorted(shelf.entries.items())))
    shelf.put("report/index.html", render(view))
    context.out.json(f"{FOLDER}/summary.json", summary_json(survey, dict(sorted(shelf.entries.items()))))


def _write_motion(shelf: Shelf, survey: Survey) -> None:
    shelf.put("trajectory.csv", trajectory_csv(survey.track))
    shelf.put("trajectory.tum", trajectory_tum(survey.track))
    if survey.solution is None:
        return
    if survey.hull is not None and survey.track.frame == "M":
        shelf.put_json("alignment.json", alignment_json(survey.solution, survey.hull, weak_directions(survey)))
    if len(survey.solution.landmarks):
        shelf.put("landmarks.ply", landmarks_ply(survey.solution))


def _write_surfaces(shelf: Shelf, survey: Survey) -> None:
    for name, surface in (("surface.ply", survey.surface), ("as_found.ply", survey.as_found)):
        if surface is not None:
            shelf.put(name, surface_ply(surface))
    if survey.objects is not None:
        shelf.put_json("objects.json", {"objects": list(survey.objects)})
        shelf.put("objects.csv", objects_csv(survey.objects))
    if survey.coverage is not None:
        shelf.put_json("coverage.json", survey.coverage)


def _copy_models(shelf: Shelf, context: Context) -> None:
    model = context.inputs.get("adjust", Path("absent")) / "colmap"
    for file in sorted(model.rglob("*")) if model.is_dir() else []:
        if file.is_file():
            shelf.copy(f"colmap/{file.relative_to(model).as_posix()}", file)
    for step, name in MOSAICS.items():
        if step in context.inputs:
            folder = context.inputs[step]
            for source, target in (
                ("ortho.tif", f"ortho_{name}.tif"),
                ("ortho.png", f"ortho_{name}.png"),
                ("mosaic.glb", f"mosaic_{name}.glb"),
            ):
                if (folder / source).exists():
                    shelf.copy(target, folder / source)


def read_survey(context: Context) -> Survey:
    """What the chain left, read into memory."""
    folder, sections = context.inputs, context.settings
    trajectory = _record(Trajectory, folder, "navigate", "trajectory.npz")
    assert trajectory is not None
    solution = _record(Solution, folder, "adjust", "solution.npz")
    chart = next((load_arrays(folder[s] / "chart.npz") for s in ("surface", "adjust") if _has(folder, s, "chart.npz")), None)
    detect = _document(folder, "detect", "detect.json") or {}
    objects = None if isinstance(detect.get("objects"), str) else _document(folder, "detect", "objects.json")
    absent = absences(sections, folder, solution)
    if isinstance(detect.get("objects"), str):
        absent |= dict.fromkeys(("objects.json", "objects.csv"), detect["objects"])
    mosaics = {name: _mosaic(folder, step) for step, name in MOSAICS.items()}
    for name, mosaic in mosaics.items():
        if mosaic is not None and not mosaic.meshed:
            absent[f"mosaic_{name}.glb"] = "too little was seen for a textured mesh"
    return Survey(
        dive=sections["dive"] or Dive(name="dive"),
        hull=sections["hull"],
        track=track_of(trajectory, solution),
        trajectory=trajectory,
        navigation=_document(folder, "navigate", "navigation.json") or {},
        findings=_document(folder, "ingest", "findings.json") or {},
        tray_origin_m=sections["tray"].origin if sections["tray"] else (0.0, 0.0, 0.0),
        solution=solution,
        adjust=_document(folder, "adjust", "adjust.json") or {},
        iterations=load_arrays(folder["adjust"] / "iterations.npz") if _has(folder, "adjust", "iterations.npz") else None,
        chart=chart_from_arrays(chart) if chart is not None else None,
        surface=_record(Surface, folder, "surface", "surface.npz"),
        as_found=_record(Surface, folder, "detect", "as_found.npz"),
        objects=tuple(objects["objects"]) if objects is not None else None,
        not_reported=tuple(detect.get("not_reported") or ()),
        coverage=_document(folder, "detect", "coverage.json"),
        optical=mosaics["optical"],
        sonar=mosaics["sonar"],
        dvl=_record(DvlPings, folder, "ingest", "dvl.npz"),
        eyes=_eyes(context, solution),
        pairs=_document(folder, "matches", "pairs.json") or {},
        steps=tuple(_step(folder[name], name) for name in CHAIN if name in folder),
        absent=absent,
    )


def _has(folder: Mapping[str, Path], step: str, file: str) -> bool:
    return step in folder and (folder[step] / file).exists()


def _record(kind: type[Record], folder: Mapping[str, Path], step: str, file: str) -> Record | None:
    return from_arrays(kind, load_arrays(folder[step] / file)) if _has(folder, step, file) else None


def _document(folder: Mapping[str, Path], step: str, file: str) -> dict[str, Any] | None:
    return json.loads((folder[step] / file).read_text(encoding="utf-8")) if _has(folder, step, file) else None


def _mosaic(folder: Mapping[str, Path], step: str) -> Mosaic | None:
    document = _document(folder, step, "mosaic.json")
    if not document or not _has(folder, step, "ortho.png"):
        return None
    return Mosaic(document, (folder[step] / "ortho.png").read_bytes(), _has(folder, step, "mosaic.glb"))


def _step(folder: Path, name: str) -> StepRun:
    """From its manifest; a folder made by hand has none."""
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


def _eyes(context: Context, solution: Solution | None) -> tuple[Eye, ...]:
    """The cameras with the mounts that the adjustment found, else the nominal ones."""
    path = cameras_file(context.inputs)
    cameras = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    top, bottom = context.settings["camera.top"], context.settings["camera.bottom"]
    eyes = []
    tray_from_top = mount_of(solution.mounts.tray_from_camera if solution else None, top.mount) if top else None
    if tray_from_top is not None and "top" in cameras:
        eyes.append(_eye(context, "camera_top", cameras["top"], tray_from_top))
        if bottom and "bottom" in cameras:
            pose = tray_from_top @ mount_of(solution.mounts.top_from_bottom if solution else None, bottom.pose_in_top)
            eyes.append(_eye(context, "camera_bottom", cameras["bottom"], pose))
    return tuple(eyes)


def _eye(context: Context, name: str, camera: Mapping[str, Any], tray_from_camera: Poses) -> Eye:
    store = ImageStore(context.inputs["ingest"], context.source, name)
    return Eye(name, CameraModel(**camera), store.index, tray_from_camera, store.read)


STAGE = Stage(
    name="report",
    summary="write the deliverables and the report",
    inputs=("ingest", "navigate"),
    optional=CHAIN[2:],
    parameters=ReportOptions,
    version=2,
    run=run,
    uses=SECTIONS,
    external=external,
)
