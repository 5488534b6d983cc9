# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write everything that people take away, and the page that they open first."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Protocol

from hullrecon.report.content.object_images import Crop, object_crops, photo_jpeg
from hullrecon.report.content.page import render_page
from hullrecon.report.content.page_context import page_context
from hullrecon.report.export.chart_export import chart_document, chart_mesh, chart_ply
from hullrecon.report.export.csv_export import csv_text
from hullrecon.report.export.geometry_export import alignment_document, landmarks_ply, surface_ply
from hullrecon.report.export.las import las_bytes
from hullrecon.report.export.object_layers import (
    object_layers,
    objects_geojson,
    objects_gpkg,
    photo_name,
)
from hullrecon.report.export.objects_table import objects_table
from hullrecon.report.export.summary import summary_document
from hullrecon.report.export.table import csv_metadata
from hullrecon.report.export.trajectory import trajectory_table, trajectory_tum
from hullrecon.report.figures.all_plots import draw_all_plots
from hullrecon.report.foxglove.dive_result import FILE as FOXGLOVE
from hullrecon.report.foxglove.dive_result import dive_result_mcap
from hullrecon.report.pdf.render import PDF, render_pdf
from hullrecon.report.survey import Survey

FOLDER, SCHEMAS = "deliver", "schemas"


class FileWriter(Protocol):
    """Writes files of an artifact, each in one step."""

    def bytes(self, name: str, value: bytes) -> None:
        """Write a file."""

    def json(self, name: str, value: object) -> None:
        """Write indented JSON with sorted keys."""

    def path(self, name: str) -> AbstractContextManager[Path]:
        """Return a temporary path to write to, made durable and renamed at the end of the `with`."""


@dataclass(frozen=True, kw_only=True)
class FileEntry:
    """Size and hash of one delivered file."""

    bytes: int
    sha256: str


class DeliverableWriter:
    """Writes deliverables and keeps their sizes and hashes."""

    def __init__(self, out: FileWriter) -> None:
        self._out = out
        self._entries: dict[str, FileEntry] = {}

    @property
    def entries(self) -> Mapping[str, FileEntry]:
        """Return what was written so far, by name."""
        return dict(sorted(self._entries.items()))

    def write(self, name: str, data: bytes | str) -> None:
        """Write a file below deliver/."""
        raw = data.encode() if isinstance(data, str) else data
        self._out.bytes(f"{FOLDER}/{name}", raw)
        self._entries[name] = FileEntry(bytes=len(raw), sha256=hashlib.sha256(raw).hexdigest())

    def write_json(self, name: str, value: object) -> None:
        """Write a document with sorted keys. Raises ValueError for a NaN."""
        self.write(
            name,
            json.dumps(value, indent=1, sort_keys=True, allow_nan=False, ensure_ascii=False) + "\n",
        )

    def copy(self, name: str, source: Path) -> None:
        """Copy a file of a step."""
        with source.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
        with self._out.path(f"{FOLDER}/{name}") as target:
            shutil.copyfile(source, target)
        self._entries[name] = FileEntry(bytes=source.stat().st_size, sha256=digest)


def deliver(survey: Survey, out: FileWriter) -> None:
    """Write all deliverables of a survey, then the report, then summary.json, which lists them."""
    writer = DeliverableWriter(out)
    photos = object_crops(survey)
    _write_motion(writer, survey)
    _write_surfaces(writer, survey)
    _write_chart(writer, survey)
    _write_objects(writer, survey, photos)
    writer.write(FOXGLOVE, dive_result_mcap(survey))
    for name, source in survey.provenance.copies.items():
        writer.copy(name, source)
    plots = draw_all_plots(survey)
    for plot in plots:
        writer.write(f"plots/{plot.name}.png", plot.png)
        writer.write(f"plots/{plot.name}.csv", csv_text(plot.table))
    _write_schemas(writer)
    context = page_context(survey, plots, writer.entries, photos)
    if PDF not in survey.provenance.missing:
        writer.write(PDF, render_pdf(context))
    writer.write("report/index.html", render_page({**context, "deliverables": writer.entries}))
    out.json(f"{FOLDER}/summary.json", summary_document(survey, writer.entries))


def _write_schemas(writer: DeliverableWriter) -> None:
    """Write the schema of each document that is delivered, summary.json's among them."""
    schemas = resources.files("hullrecon.report") / SCHEMAS
    for name in sorted({*writer.entries, "summary.json"}):
        schema = schemas / f"{Path(name).stem}.schema.json"
        if name.endswith(".json") and schema.is_file():
            writer.write(f"{SCHEMAS}/{schema.name}", schema.read_bytes())


def _write_motion(writer: DeliverableWriter, survey: Survey) -> None:
    trajectory = trajectory_table(survey)
    tables = (
        [trajectory]
        if survey.findings.objects is None
        else [trajectory, objects_table(survey.findings.objects)]
    )
    for table in tables:
        writer.write(table.file, table.csv)
    writer.write_json("csv-metadata.json", csv_metadata(tables))
    writer.write("trajectory.tum", trajectory_tum(survey.track))
    adjusted = survey.adjusted
    if adjusted is None:
        return
    if survey.facts.hull is not None and adjusted.solution.hull_pose is not None:
        alignment = alignment_document(
            adjusted.solution.hull_pose, survey.facts.hull, adjusted.weak_directions
        )
        writer.write_json("alignment.json", alignment)
    if len(adjusted.solution.landmarks):
        writer.write("landmarks.ply", landmarks_ply(survey, adjusted.solution))


def _write_surfaces(writer: DeliverableWriter, survey: Survey) -> None:
    surfaces = survey.surfaces
    for name, surface in (("surface.ply", surfaces.surveyed), ("as_found.ply", surfaces.as_found)):
        if surface is not None:
            writer.write(name, surface_ply(survey, surface, surfaces.deviation))
    if surfaces.as_found is not None and (surfaces.as_found.support > 0).any():
        points = las_bytes(
            surfaces.as_found,
            surfaces.deviation,
            survey.track.frame,
            int(survey.track.t_ns[-1]),
            by_images=surfaces.found_by_images,
            up=(0.0, 0.0, 1.0) if surfaces.chart is None else surfaces.chart.ship_axes[2],
        )
        writer.write("as_found.las", points)
    for name, document in survey.findings.documents.items():
        writer.write_json(name, document)


def _write_chart(writer: DeliverableWriter, survey: Survey) -> None:
    surfaces = survey.surfaces
    if surfaces.chart is None or surfaces.outside is None or surfaces.surveyed is None:
        return
    mesh = chart_mesh(surfaces.chart, surfaces.surveyed.vertices)
    writer.write("chart.ply", chart_ply(survey, mesh))
    writer.write_json("chart.json", chart_document(surfaces.chart, surfaces.outside, mesh))


def _write_objects(writer: DeliverableWriter, survey: Survey, photos: Mapping[int, Crop]) -> None:
    objects, surfaces = survey.findings.objects, survey.surfaces
    for number, crop in photos.items():
        writer.write(photo_name(number), photo_jpeg(crop))
    if objects is None or surfaces.chart is None or surfaces.outside is None:
        return
    layers = object_layers(objects, photos, surfaces.chart, surfaces.outside)
    writer.write_json("objects.geojson", objects_geojson(layers, surfaces.outside))
    writer.write("objects.gpkg", objects_gpkg(layers, surfaces.outside, int(survey.track.t_ns[-1])))
