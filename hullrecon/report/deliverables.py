# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The registry of deliverables: each file's name, why a dive cannot give it, how it is written.

`deliver`, the reasons of absent files in summary.json and the table in docs/deliverables.md follow
DELIVERABLES. What else a new deliverable takes (tests, a schema, the step's version) is listed in
CONTRIBUTING.md, *Add a deliverable*.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import TypeVar

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.solution import Solution
from hullrecon.records.surface import Surface
from hullrecon.report.content.objects import Crop, object_crops, photo_jpeg
from hullrecon.report.content.page_context import (
    PageContext,
    draw_page,
    join_drawings,
    print_context,
)
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
from hullrecon.report.export.tables import (
    Table,
    csv_metadata,
    csv_text,
    objects_table,
    trajectory_table,
    trajectory_tum,
)
from hullrecon.report.figures.hull_map import HullMap, hull_map
from hullrecon.report.figures.map_pictures import form_drawing
from hullrecon.report.figures.map_tiles import FOLDER as TILES
from hullrecon.report.figures.map_tiles import stream_tiles
from hullrecon.report.figures.plots import plot_drawings
from hullrecon.report.figures.style import Plot
from hullrecon.report.foxglove.dive_result import dive_result_mcap
from hullrecon.report.render import render_page, render_pdf, why_no_pdf
from hullrecon.report.stream import Stream, draw
from hullrecon.report.survey import Survey
from hullrecon.report.writer import DeliverableWriter

SCHEMAS = "schemas"
Required = TypeVar("Required")


@dataclass(frozen=True, kw_only=True)
class Pictures:
    """What matplotlib draws for page and PDF."""

    plots: Sequence[Plot] = ()
    form: bytes | None = None  # the map of the deviation's form, PNG


@dataclass
class Delivery:
    """A survey and the sink for its files, with what several deliverables share.

    The functions of DELIVERABLES are given it. What is optional in the survey is not None here: a
    deliverable is written only if `why_absent` is empty.
    """

    survey: Survey
    out: DeliverableWriter
    stream: Stream  # computes many results, on several processes where there are
    failed: dict[str, str] = field(default_factory=dict)  # reason by name of the deliverable

    @property
    def solution(self) -> Solution:
        return _required(self.survey.adjusted).solution

    @property
    def chart(self) -> Chart:
        return _required(self.survey.surfaces.chart)

    @property
    def outside(self) -> OutsideMap:
        return _required(self.survey.surfaces.outside)

    @property
    def surveyed(self) -> Surface:
        return _required(self.survey.surfaces.surveyed)

    @property
    def as_found(self) -> Surface:
        return _required(self.survey.surfaces.as_found)

    @property
    def objects(self) -> Sequence[ReportedObject]:
        return _required(self.survey.findings.objects)

    @property
    def end_ns(self) -> int:
        """Time of the last pose, written into files so that equal runs give equal bytes."""
        return int(self.survey.track.t_ns[-1])

    @cached_property
    def photos(self) -> Mapping[int, Crop]:
        """The picture of each object that an image shows, by the object's number."""
        return object_crops(self.survey)

    @cached_property
    def pictures(self) -> Pictures:
        """What matplotlib draws, on several processes where there are."""
        form = form_drawing(self.survey, self._view)
        plots = plot_drawings(self.survey)
        drawn = list(self.stream(draw, [*plots, *filter(None, [form])], "pictures"))
        return Pictures(
            plots=[plot for plot in drawn[: len(plots)] if plot is not None],
            form=drawn[-1] if form is not None else None,
        )

    @cached_property
    def chart_mesh(self) -> ChartMesh:
        return chart_mesh(self.chart, self.surveyed.vertices)

    @cached_property
    def object_layers(self) -> list[Layer]:
        photos = {} if "objects/" in self.failed else self.photos
        return object_layers(self.objects, photos, self.chart, self.outside)

    @cached_property
    def _view(self) -> HullMap | None:
        return hull_map(self.survey)

    @cached_property
    def _printed(self) -> PageContext:
        if "plots/" in self.failed:  # a plot is what failed: the map is drawn alone
            form = form_drawing(self.survey, self._view)
            pictures = Pictures(form=draw(form) if form is not None else None)
        else:
            pictures = self.pictures
        photos = {} if "objects/" in self.failed else self.photos
        return print_context(
            self.survey, self._view, pictures.plots, pictures.form, self.out.entries, photos
        )

    @cached_property
    def drawn(self) -> Future[PageContext]:
        """What only the page shows. It is drawn in a thread, from the first use on."""
        beside = ThreadPoolExecutor(1)
        drawn = beside.submit(draw_page, self.survey, self._view, self.out.entries)
        beside.shutdown(wait=False)
        return drawn

    @property
    def printed(self) -> PageContext:
        """The variables of the PDF, with all that was written or failed so far."""
        return {**self._printed, "deliverables": self.out.entries, "failed": self.failed}

    @property
    def page(self) -> PageContext:
        """The variables of the page, with all that was written or failed so far."""
        return join_drawings(self.printed, self.drawn.result())


def _required(value: Required | None) -> Required:
    """Narrow a part of the survey that a deliverable's `why_absent` has found to be there."""
    if value is None:
        raise ValueError("a deliverable is written without what it needs")
    return value


@dataclass(frozen=True, kw_only=True)
class Deliverable:
    """A file of deliver/, or a folder of files (its name ends in a slash)."""

    name: str
    why_absent: Callable[[Survey], str]  # why this dive cannot give it, "" if it can
    write: Callable[[Delivery], None]
    # describes the other files (schemas, page, PDF), so written after all of them
    is_about_others: bool = False
    waits: bool = False  # for workers or the disk while it is written, more than it computes


def missing_deliverables(survey: Survey) -> dict[str, str]:
    """Give the reason for each deliverable that the dive cannot give, by name."""
    reasons = {entry.name: entry.why_absent(survey) for entry in DELIVERABLES}
    return {name: why for name, why in reasons.items() if why}


# Why a dive cannot give a deliverable: each function returns the reason, "" if it can.

NOT_FITTING = "the CAD model does not fit the survey and was left out"


def _never_absent(_: Survey) -> str:
    return ""


def _why_no_result(survey: Survey, step: str) -> str:
    """Say why a step left no result. Never empty: called only where the result is missing."""
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


def _why_no_alignment(survey: Survey) -> str:
    """Say why there is no alignment of dive and CAD model. "" where there is one."""
    if not survey.provenance.carried.cad_model:
        return "no CAD model was given, so there is nothing to align to"
    if survey.adjusted is None:
        return "the adjustment did not run"
    return "" if survey.adjusted.has_cad_model else NOT_FITTING


def _why_no_landmarks(survey: Survey) -> str:
    if survey.adjusted is None or not survey.provenance.carried.camera:
        return _why_no_result(survey, "adjust")
    return "" if len(survey.adjusted.solution.landmarks) else "no landmark was adjusted"


def _why_no_surface(survey: Survey) -> str:
    return "" if survey.surfaces.surveyed is not None else _why_no_result(survey, "surface")


def _why_no_chart(survey: Survey) -> str:
    surfaces = survey.surfaces
    charted = surfaces.chart is not None and surfaces.outside is not None
    return _why_no_surface(survey) if charted else _why_no_result(survey, "surface")


def _why_no_hull_as_found(survey: Survey) -> str:
    return "" if survey.surfaces.as_found is not None else _why_no_result(survey, "detect")


def _why_nothing_seen(survey: Survey) -> str:
    found = survey.surfaces.as_found
    unseen = found is not None and not (found.support > 0).any()
    return "too little of the hull was seen" if unseen else _why_no_hull_as_found(survey)


def _why_no_objects(survey: Survey) -> str:
    if survey.findings.objects is not None:
        return ""
    return survey.findings.not_looked_for or _why_no_result(survey, "detect")


def _why_no_charted_objects(survey: Survey) -> str:
    return _why_no_objects(survey) or _why_no_chart(survey)


def _why_no_document(name: str) -> Callable[[Survey], str]:
    """Make the function that says why the step detect did not make a JSON document."""

    def why_absent(survey: Survey) -> str:
        """Say why it is absent. Empty where it is there."""
        if name in survey.findings.documents:
            return ""
        return (_why_no_objects(survey) if name == "objects.json" else "") or _why_no_result(
            survey, "detect"
        )

    return why_absent


def _why_not_copied(name: str, step: str) -> Callable[[Survey], str]:
    """Make the function that says why a step did not leave a file, or a folder, for delivery.

    Without an earlier dive to compare with, the folder of changes is empty, not absent.
    """

    def why_absent(survey: Survey) -> str:
        """Say why it is absent. Empty where it is there, or not asked for."""
        not_asked = step == "change" and not survey.provenance.carried.earlier_dive
        if not_asked or _sources(survey, name):
            return ""
        mosaic = survey.mosaics.named().get(step.removeprefix("mosaic-"))
        if mosaic is not None and (name.endswith(".glb") or not mosaic.has_mesh):
            return "too little was seen for a textured mesh"
        if mosaic is not None and name.startswith("tiles/"):
            return f"they could not be written: see the warnings of {step}"
        return _why_no_result(survey, step)

    return why_absent


def _why_no_raster(name: str) -> Callable[[Survey], str]:
    """Make the function that says why there is no raster of the hull as found.

    Such rasters lie on the grid of a mosaic.
    """

    def why_absent(survey: Survey) -> str:
        """Say why it is absent. Empty where it is there."""
        if _sources(survey, name):
            return ""
        if name != "support.tif" and not survey.provenance.carried.cad_model:
            return "no CAD model was given, so there is nothing to deviate from"
        if name != "support.tif" and _why_no_alignment(survey) == NOT_FITTING:
            return NOT_FITTING
        if not survey.mosaics.named():
            return "they lie on a mosaic's grid, and there is none"
        return _why_no_result(survey, "detect")

    return why_absent


def _sources(survey: Survey, name: str) -> Mapping[str, Path]:
    """Find the files of the steps that a deliverable is copied from, by name."""
    copies = survey.provenance.copies
    return {file: path for file, path in copies.items() if file == name or _is_below(file, name)}


def _is_below(file: str, folder: str) -> bool:
    """Decide whether a file is in a folder. A name that does not end in a slash is no folder."""
    return folder.endswith("/") and file.startswith(folder)


# Entries of the registry, by how the file is written.


def _written(
    name: str, why_absent: Callable[[Survey], str], data: Callable[[Delivery], bytes | str]
) -> Deliverable:
    """Register a file whose bytes or text `data` makes."""

    def write(delivery: Delivery) -> None:
        delivery.out.write(name, data(delivery))

    return Deliverable(name=name, why_absent=why_absent, write=write)


def _written_json(
    name: str, why_absent: Callable[[Survey], str], value: Callable[[Delivery], object]
) -> Deliverable:
    """Register a JSON document that `value` makes."""

    def write(delivery: Delivery) -> None:
        delivery.out.write_json(name, value(delivery))

    return Deliverable(name=name, why_absent=why_absent, write=write)


def _copied(name: str, why_absent: Callable[[Survey], str]) -> Deliverable:
    """Register a file, or a folder of files, that is copied as a step left it."""

    def write(delivery: Delivery) -> None:
        for file, source in _sources(delivery.survey, name).items():
            delivery.out.copy(file, source)

    return Deliverable(name=name, why_absent=why_absent, write=write, waits=True)


def _mosaic_files(kind: str) -> tuple[Deliverable, ...]:
    """Register the files of the optical or the sonar mosaic."""
    names = (
        *("ortho_{}.tif", "ortho_{}.png", "mosaic_{}.glb", "variance_{}.tif", "views_{}.tif"),
        "tiles/{}/",
    )
    return tuple(
        _copied(name.format(kind), _why_not_copied(name.format(kind), f"mosaic-{kind}"))
        for name in names
    )


def _tables(survey: Survey) -> list[Table]:
    """List the delivered tables that csv-metadata.json describes."""
    objects = survey.findings.objects
    return [trajectory_table(survey), *([] if objects is None else [objects_table(objects)])]


def _alignment_document(delivery: Delivery) -> Mapping[str, object]:
    adjusted = _required(delivery.survey.adjusted)
    pose = _required(adjusted.solution.hull_pose)
    return alignment_document(pose, _required(delivery.survey.facts.hull), adjusted.weak_directions)


def _outlines(layer: Layer, outside: OutsideMap) -> Mapping[str, object]:
    return geojson(layer, outside, [fields["id"] for fields in layer.fields])


def _las(delivery: Delivery) -> bytes:
    """Encode the hull as found as LAS, with z up where there is no chart to say what is up."""
    chart = delivery.survey.surfaces.chart
    return las_bytes(
        delivery.as_found,
        delivery.survey.surfaces.deviation,
        delivery.survey.track.frame,
        delivery.end_ns,
        by_images=delivery.survey.surfaces.found_by_images,
        up=(0.0, 0.0, 1.0) if chart is None else chart.ship_axes[2],
    )


def _write_photos(delivery: Delivery) -> None:
    for number, crop in delivery.photos.items():
        delivery.out.write(photo_name(number), photo_jpeg(crop))


def _write_plots(delivery: Delivery) -> None:
    for plot in delivery.pictures.plots:
        delivery.out.write(f"plots/{plot.name}.png", plot.png)
        delivery.out.write(f"plots/{plot.name}.csv", csv_text(plot.table))


def _write_tiles(delivery: Delivery) -> None:
    for name, tile in stream_tiles(delivery.survey, delivery.stream):
        delivery.out.write(name, tile)
    _ = delivery.drawn  # begun: of all files it needs the tiles alone


def _pdf(delivery: Delivery) -> bytes:
    """Render the PDF, while what only the page shows is drawn."""
    _ = delivery.drawn
    return render_pdf(delivery.printed)


def _write_schemas(delivery: Delivery) -> None:
    """Write the schema of each document that was delivered, and of summary.json."""
    folder = resources.files("hullrecon.report") / SCHEMAS
    for name in sorted({*delivery.out.entries, "summary.json"}):
        schema = folder / f"{Path(name).stem}.schema.json"
        if name.endswith(".json") and schema.is_file():
            delivery.out.write(f"{SCHEMAS}/{schema.name}", schema.read_bytes())


# `d` is the Delivery: the survey and the folder that it is written to.
DELIVERABLES: tuple[Deliverable, ...] = (
    _written("trajectory.csv", _never_absent, lambda d: trajectory_table(d.survey).csv),
    _written("trajectory.tum", _never_absent, lambda d: trajectory_tum(d.survey.track)),
    _written_json("alignment.json", _why_no_alignment, _alignment_document),
    _written("landmarks.ply", _why_no_landmarks, lambda d: landmarks_ply(d.survey, d.solution)),
    _copied("colmap/", _why_not_copied("colmap/", "adjust")),
    _written(
        "surface.ply",
        _why_no_surface,
        lambda d: surface_ply(d.survey, d.surveyed, d.survey.surfaces.deviation),
    ),
    _written("chart.ply", _why_no_chart, lambda d: chart_ply(d.survey, d.chart_mesh)),
    _written_json(
        "chart.json", _why_no_chart, lambda d: chart_document(d.chart, d.outside, d.chart_mesh)
    ),
    _written(
        "as_found.ply",
        _why_no_hull_as_found,
        lambda d: surface_ply(d.survey, d.as_found, d.survey.surfaces.deviation),
    ),
    _written("as_found.las", _why_nothing_seen, _las),
    _written_json(
        "objects.json",
        _why_no_document("objects.json"),
        lambda d: d.survey.findings.documents["objects.json"],
    ),
    _written("objects.csv", _why_no_objects, lambda d: objects_table(d.objects).csv),
    Deliverable(name="objects/", why_absent=_why_no_objects, write=_write_photos),
    _written_json(
        "objects.geojson",
        _why_no_charted_objects,
        lambda d: _outlines(d.object_layers[0], d.outside),
    ),
    _written(
        "objects.gpkg",
        _why_no_charted_objects,
        lambda d: geopackage(d.object_layers, d.outside, d.end_ns),
    ),
    _written_json(
        "coverage.json",
        _why_no_document("coverage.json"),
        lambda d: d.survey.findings.documents["coverage.json"],
    ),
    _written_json("csv-metadata.json", _never_absent, lambda d: csv_metadata(_tables(d.survey))),
    *_mosaic_files("optical"),
    *_mosaic_files("sonar"),
    *(
        _copied(name, _why_no_raster(name))
        for name in (
            "deviation.tif",
            "deviation_sigma.tif",
            "form.tif",
            "form_sigma.tif",
            "support.tif",
        )
    ),
    _copied("change/", _why_not_copied("change/", "change")),
    _written("dive_result.mcap", _never_absent, lambda d: dive_result_mcap(d.survey)),
    Deliverable(name=f"{TILES}/", why_absent=_never_absent, write=_write_tiles, waits=True),
    Deliverable(name="plots/", why_absent=_never_absent, write=_write_plots, waits=True),
    Deliverable(
        name=f"{SCHEMAS}/", why_absent=_never_absent, write=_write_schemas, is_about_others=True
    ),
    replace(
        _written("report/report.pdf", lambda _: why_no_pdf() or "", _pdf),
        is_about_others=True,
    ),
    replace(
        _written("report/index.html", _never_absent, lambda d: render_page(d.page)),
        is_about_others=True,
    ),
)
