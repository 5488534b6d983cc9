# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The registry of what is delivered: each file's name, what it needs, and how it is written.

`deliver`, the reasons of absent files in summary.json and the table in docs/deliverables.md follow
DELIVERABLES. To add a deliverable, add an entry here and a row there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Protocol, TypeVar

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.solution import Solution
from hullrecon.records.surface import Surface
from hullrecon.report.content.objects import Crop, object_crops, photo_jpeg
from hullrecon.report.content.page_context import PageContext, page_context
from hullrecon.report.export.geometry import (
    ChartMesh,
    alignment_document,
    chart_document,
    chart_mesh,
    chart_ply,
    landmarks_ply,
    surface_ply,
)
from hullrecon.report.export.las import las_bytes
from hullrecon.report.export.layers import Layer, geojson, geopackage, object_layers, photo_name
from hullrecon.report.export.summary import FileEntry
from hullrecon.report.export.tables import (
    Table,
    csv_metadata,
    csv_text,
    objects_table,
    trajectory_table,
    trajectory_tum,
)
from hullrecon.report.figures.map_tiles import FOLDER as TILES
from hullrecon.report.figures.map_tiles import Stream, stream_tiles
from hullrecon.report.figures.plots import draw_all_plots
from hullrecon.report.figures.style import Plot
from hullrecon.report.foxglove.dive_result import dive_result_mcap
from hullrecon.report.render import render_page, render_pdf, why_no_pdf
from hullrecon.report.survey import Survey

SCHEMAS = "schemas"
Known = TypeVar("Known")


class FileSink(Protocol):
    """Writes files below deliver/ and lists them."""

    @property
    def entries(self) -> Mapping[str, FileEntry]:
        """Size and hash of each file written so far, by name."""

    def write(self, name: str, data: bytes | str) -> None:
        """Write a file."""

    def write_json(self, name: str, value: object) -> None:
        """Write a document."""

    def copy(self, name: str, source: Path) -> None:
        """Copy a file of a step."""


@dataclass
class Delivery:
    """A survey on its way to deliver/, with what several deliverables share."""

    survey: Survey
    out: FileSink
    stream: Stream  # computes many results, on several processes where there are
    failed: dict[str, str] = field(default_factory=dict)  # reason by name of the deliverable

    @property
    def solution(self) -> Solution:
        return _known(self.survey.adjusted).solution

    @property
    def chart(self) -> Chart:
        return _known(self.survey.surfaces.chart)

    @property
    def outside(self) -> OutsideMap:
        return _known(self.survey.surfaces.outside)

    @property
    def surveyed(self) -> Surface:
        return _known(self.survey.surfaces.surveyed)

    @property
    def as_found(self) -> Surface:
        return _known(self.survey.surfaces.as_found)

    @property
    def objects(self) -> Sequence[ReportedObject]:
        return _known(self.survey.findings.objects)

    @property
    def end_ns(self) -> int:
        """Time of the last pose, written into files so that equal runs give equal bytes."""
        return int(self.survey.track.t_ns[-1])

    @cached_property
    def photos(self) -> Mapping[int, Crop]:
        """The picture of each object that an image shows, by the object's number."""
        return object_crops(self.survey)

    @cached_property
    def plots(self) -> Sequence[Plot]:
        return draw_all_plots(self.survey)

    @cached_property
    def chart_mesh(self) -> ChartMesh:
        return chart_mesh(self.chart, self.surveyed.vertices)

    @cached_property
    def object_layers(self) -> list[Layer]:
        photos = {} if "objects/" in self.failed else self.photos
        return object_layers(self.objects, photos, self.chart, self.outside)

    @cached_property
    def _page(self) -> PageContext:
        plots = [] if "plots/" in self.failed else self.plots
        photos = {} if "objects/" in self.failed else self.photos
        return page_context(self.survey, plots, self.out.entries, photos)

    @property
    def page(self) -> PageContext:
        """The variables of page and PDF, with all that was written or failed so far."""
        return {**self._page, "deliverables": self.out.entries, "failed": self.failed}


def _known(value: Known | None) -> Known:
    if value is None:
        raise ValueError("a deliverable is written without what it needs")
    return value


@dataclass(frozen=True, kw_only=True)
class Deliverable:
    """A file of deliver/, or a folder of files (its name ends in a slash)."""

    name: str
    needs: Callable[[Survey], str]  # why this dive cannot give it, "" if it can
    write: Callable[[Delivery], None]
    is_about_others: bool = False  # made of what was written, so written when all others are


def writing_order() -> list[Deliverable]:
    """List the deliverables in the order to write them: those about others last."""
    return sorted(DELIVERABLES, key=lambda entry: entry.is_about_others)


def missing_deliverables(survey: Survey) -> dict[str, str]:
    """Give the reason for each deliverable that the dive cannot give, by name."""
    reasons = {entry.name: entry.needs(survey) for entry in DELIVERABLES}
    return {name: why for name, why in reasons.items() if why}


# What deliverables need: each returns the reason why the dive does not have it, or "".

NOT_FITTING = "the CAD model does not fit the survey and was left out"


def _always(_: Survey) -> str:
    return ""


def _step(survey: Survey, step: str) -> str:
    """Say why a step left no result."""
    carried, failures = survey.provenance.carried, survey.provenance.failures
    if step == "adjust" and not carried.camera:
        return "no camera was carried"
    if step in failures:
        return failures[step]
    if step == "mosaic-optical" and not carried.camera:
        return "no camera was carried"
    if step == "mosaic-sonar" and not carried.sonar:
        return "no imaging sonar was carried"
    if step == "change" and not carried.cad_model:
        return "no CAD model was given, and two dives are compared on their hull's CAD model"
    return f"the step {step} left no result"


def _alignment(survey: Survey) -> str:
    if not survey.provenance.carried.cad_model:
        return "no CAD model was given, so there is nothing to align to"
    if survey.adjusted is None:
        return "the adjustment did not run"
    return "" if survey.adjusted.has_cad_model else NOT_FITTING


def _landmarks(survey: Survey) -> str:
    if survey.adjusted is None or not survey.provenance.carried.camera:
        return _step(survey, "adjust")
    return "" if len(survey.adjusted.solution.landmarks) else "no landmark was adjusted"


def _surface(survey: Survey) -> str:
    return "" if survey.surfaces.surveyed is not None else _step(survey, "surface")


def _chart(survey: Survey) -> str:
    surfaces = survey.surfaces
    charted = surfaces.chart is not None and surfaces.outside is not None
    return _surface(survey) if charted else _step(survey, "surface")


def _as_found(survey: Survey) -> str:
    return "" if survey.surfaces.as_found is not None else _step(survey, "detect")


def _seen(survey: Survey) -> str:
    found = survey.surfaces.as_found
    unseen = found is not None and not (found.support > 0).any()
    return "too little of the hull was seen" if unseen else _as_found(survey)


def _objects(survey: Survey) -> str:
    if survey.findings.objects is not None:
        return ""
    return survey.findings.not_looked_for or _step(survey, "detect")


def _charted_objects(survey: Survey) -> str:
    return _objects(survey) or _chart(survey)


def _document(name: str) -> Callable[[Survey], str]:
    """Require a JSON document that the step detect made."""

    def needs(survey: Survey) -> str:
        if name in survey.findings.documents:
            return ""
        return (_objects(survey) if name == "objects.json" else "") or _step(survey, "detect")

    return needs


def _copied(name: str, step: str) -> Callable[[Survey], str]:
    """Require a file, or the files of a folder, that a step left for delivery."""

    def needs(survey: Survey) -> str:
        not_asked = step == "change" and not survey.provenance.carried.earlier_dive
        if not_asked or _sources(survey, name):
            return ""
        mosaic = survey.mosaics.named().get(step.removeprefix("mosaic-"))
        if mosaic is not None and (name.endswith(".glb") or not mosaic.has_mesh):
            return "too little was seen for a textured mesh"
        if mosaic is not None and name.startswith("tiles/"):
            return f"they could not be written: see the warnings of {step}"
        return _step(survey, step)

    return needs


def _raster(name: str) -> Callable[[Survey], str]:
    """Require a raster of the hull as found, which lies on a mosaic's grid."""

    def needs(survey: Survey) -> str:
        if _sources(survey, name):
            return ""
        if name != "support.tif" and not survey.provenance.carried.cad_model:
            return "no CAD model was given, so there is nothing to deviate from"
        if name != "support.tif" and _alignment(survey) == NOT_FITTING:
            return NOT_FITTING
        if not survey.mosaics.named():
            return "they lie on a mosaic's grid, and there is none"
        return _step(survey, "detect")

    return needs


def _sources(survey: Survey, name: str) -> Mapping[str, Path]:
    """Find the files of the steps that a deliverable is copied from, by name."""
    copies = survey.provenance.copies
    return {file: path for file, path in copies.items() if file == name or _below(file, name)}


def _below(file: str, folder: str) -> bool:
    return folder.endswith("/") and file.startswith(folder)


# How deliverables are written.


def _file(
    name: str, needs: Callable[[Survey], str], data: Callable[[Delivery], bytes | str]
) -> Deliverable:
    return Deliverable(name=name, needs=needs, write=lambda to: to.out.write(name, data(to)))


def _json(
    name: str, needs: Callable[[Survey], str], value: Callable[[Delivery], object]
) -> Deliverable:
    return Deliverable(name=name, needs=needs, write=lambda to: to.out.write_json(name, value(to)))


def _copy(name: str, needs: Callable[[Survey], str]) -> Deliverable:
    def write(to: Delivery) -> None:
        for file, source in _sources(to.survey, name).items():
            to.out.copy(file, source)

    return Deliverable(name=name, needs=needs, write=write)


def _mosaic(kind: str) -> tuple[Deliverable, ...]:
    names = (
        *("ortho_{}.tif", "ortho_{}.png", "mosaic_{}.glb", "variance_{}.tif", "views_{}.tif"),
        "tiles/{}/",
    )
    return tuple(
        _copy(name.format(kind), _copied(name.format(kind), f"mosaic-{kind}")) for name in names
    )


def _tables(survey: Survey) -> list[Table]:
    objects = survey.findings.objects
    return [trajectory_table(survey), *([] if objects is None else [objects_table(objects)])]


def _alignment_document(to: Delivery) -> Mapping[str, object]:
    adjusted = _known(to.survey.adjusted)
    pose = _known(adjusted.solution.hull_pose)
    return alignment_document(pose, _known(to.survey.facts.hull), adjusted.weak_directions)


def _outlines(layer: Layer, outside: OutsideMap) -> Mapping[str, object]:
    return geojson(layer, outside, [fields["id"] for fields in layer.fields])


def _las(to: Delivery) -> bytes:
    chart = to.survey.surfaces.chart
    return las_bytes(
        to.as_found,
        to.survey.surfaces.deviation,
        to.survey.track.frame,
        to.end_ns,
        by_images=to.survey.surfaces.found_by_images,
        up=(0.0, 0.0, 1.0) if chart is None else chart.ship_axes[2],
    )


def _write_photos(to: Delivery) -> None:
    for number, crop in to.photos.items():
        to.out.write(photo_name(number), photo_jpeg(crop))


def _write_plots(to: Delivery) -> None:
    for plot in to.plots:
        to.out.write(f"plots/{plot.name}.png", plot.png)
        to.out.write(f"plots/{plot.name}.csv", csv_text(plot.table))


def _write_tiles(to: Delivery) -> None:
    for name, webp in stream_tiles(to.survey, to.stream):
        to.out.write(name, webp)


def _write_schemas(to: Delivery) -> None:
    """Write the schema of each document that was delivered, and of summary.json."""
    folder = resources.files("hullrecon.report") / SCHEMAS
    for name in sorted({*to.out.entries, "summary.json"}):
        schema = folder / f"{Path(name).stem}.schema.json"
        if name.endswith(".json") and schema.is_file():
            to.out.write(f"{SCHEMAS}/{schema.name}", schema.read_bytes())


DELIVERABLES: tuple[Deliverable, ...] = (
    _file("trajectory.csv", _always, lambda to: trajectory_table(to.survey).csv),
    _file("trajectory.tum", _always, lambda to: trajectory_tum(to.survey.track)),
    _json("alignment.json", _alignment, _alignment_document),
    _file("landmarks.ply", _landmarks, lambda to: landmarks_ply(to.survey, to.solution)),
    _copy("colmap/", _copied("colmap/", "adjust")),
    _file(
        "surface.ply",
        _surface,
        lambda to: surface_ply(to.survey, to.surveyed, to.survey.surfaces.deviation),
    ),
    _file("chart.ply", _chart, lambda to: chart_ply(to.survey, to.chart_mesh)),
    _json("chart.json", _chart, lambda to: chart_document(to.chart, to.outside, to.chart_mesh)),
    _file(
        "as_found.ply",
        _as_found,
        lambda to: surface_ply(to.survey, to.as_found, to.survey.surfaces.deviation),
    ),
    _file("as_found.las", _seen, _las),
    _json(
        "objects.json",
        _document("objects.json"),
        lambda to: to.survey.findings.documents["objects.json"],
    ),
    _file("objects.csv", _objects, lambda to: objects_table(to.objects).csv),
    Deliverable(name="objects/", needs=_objects, write=_write_photos),
    _json(
        "objects.geojson",
        _charted_objects,
        lambda to: _outlines(to.object_layers[0], to.outside),
    ),
    _file(
        "objects.gpkg",
        _charted_objects,
        lambda to: geopackage(to.object_layers, to.outside, to.end_ns),
    ),
    _json(
        "coverage.json",
        _document("coverage.json"),
        lambda to: to.survey.findings.documents["coverage.json"],
    ),
    _json("csv-metadata.json", _always, lambda to: csv_metadata(_tables(to.survey))),
    *_mosaic("optical"),
    *_mosaic("sonar"),
    *(
        _copy(name, _raster(name))
        for name in (
            "deviation.tif",
            "deviation_sigma.tif",
            "form.tif",
            "form_sigma.tif",
            "support.tif",
        )
    ),
    _copy("change/", _copied("change/", "change")),
    _file("dive_result.mcap", _always, lambda to: dive_result_mcap(to.survey)),
    Deliverable(name="plots/", needs=_always, write=_write_plots),
    Deliverable(name=f"{TILES}/", needs=_always, write=_write_tiles),
    Deliverable(name=f"{SCHEMAS}/", needs=_always, write=_write_schemas, is_about_others=True),
    replace(
        _file("report/report.pdf", lambda _: why_no_pdf() or "", lambda to: render_pdf(to.page)),
        is_about_others=True,
    ),
    replace(
        _file("report/index.html", _always, lambda to: render_page(to.page)), is_about_others=True
    ),
)
