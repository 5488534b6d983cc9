# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is written below deliver/, and how it is listed."""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from hullrecon.errors import InputError
from hullrecon.records.deliverables import ReportedObject
from hullrecon.report import deliverables
from hullrecon.report.deliver import deliver
from hullrecon.report.survey import Provenance, Survey
from hullrecon.report.writer import DeliverableWriter


class Folder:
    """Writes files below a folder, as an artifact's writer does."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def bytes(self, name: str, value: bytes) -> None:
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(value)

    def json(self, name: str, value: object) -> None:
        self.bytes(name, json.dumps(value).encode())

    @contextmanager
    def path(self, name: str) -> Iterator[Path]:
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        yield path


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    return Folder(tmp_path / "artifact")


def delivered(folder: Folder) -> set[str]:
    root = folder.root / "deliver"
    return {path.relative_to(root).as_posix() for path in root.rglob("*") if path.is_file()}


def test_an_entry_has_size_and_hash_of_its_file(folder: Folder) -> None:
    writer = DeliverableWriter(folder)
    writer.write("a.txt", "grüße")
    entry = writer.entries["a.txt"]
    raw = (folder.root / "deliver" / "a.txt").read_bytes()
    assert raw.decode() == "grüße"
    assert (entry.bytes, entry.sha256) == (len(raw), hashlib.sha256(raw).hexdigest())


def test_entries_are_sorted_by_name(folder: Folder) -> None:
    writer = DeliverableWriter(folder)
    for name in ("b", "a/z", "a/b"):
        writer.write(name, b"")
    assert list(writer.entries) == ["a/b", "a/z", "b"]


def test_a_document_has_sorted_keys_and_no_nan(folder: Folder) -> None:
    writer = DeliverableWriter(folder)
    writer.write_json("d.json", {"b": 1, "a": "ü"})
    assert (folder.root / "deliver" / "d.json").read_text(
        encoding="utf-8"
    ) == '{\n "a": "ü",\n "b": 1\n}\n'
    with pytest.raises(ValueError, match="JSON compliant"):
        writer.write_json("nan.json", {"x": float("nan")})
    assert "nan.json" not in writer.entries


def test_a_copy_has_bytes_and_hash_of_its_source(folder: Folder, tmp_path: Path) -> None:
    source = tmp_path / "ortho.tif"
    source.write_bytes(b"II*\x00" * 50)
    writer = DeliverableWriter(folder)
    writer.copy("ortho_optical.tif", source)
    assert (folder.root / "deliver" / "ortho_optical.tif").read_bytes() == source.read_bytes()
    assert (
        writer.entries["ortho_optical.tif"].sha256
        == hashlib.sha256(source.read_bytes()).hexdigest()
    )
    assert writer.entries["ortho_optical.tif"].bytes == 200


def test_a_whole_survey_is_delivered_with_schemas_and_summary(
    survey: Survey, folder: Folder
) -> None:
    documents = {"objects.json": {"objects": []}, "coverage.json": {"frame": "M"}}
    found = replace(survey.findings, documents=documents)
    assert deliver(replace(survey, findings=found), folder) == []
    names = delivered(folder)
    plots = {name for name in names if name.startswith("plots/")}
    assert {"plots/convergence.png", "plots/convergence.csv"} <= plots
    documented = ("summary", "alignment", "objects", "coverage", "chart")
    assert names - plots == {
        "trajectory.csv",
        "trajectory.tum",
        "csv-metadata.json",
        "alignment.json",
        "landmarks.ply",
        "surface.ply",
        "chart.ply",
        "chart.json",
        "as_found.ply",
        "as_found.las",
        "objects.json",
        "objects.csv",
        "objects.geojson",
        "objects.gpkg",
        "objects/1.jpg",
        "coverage.json",
        "dive_result.mcap",
        "report/index.html",
        "report/report.pdf",
        "summary.json",
        *(f"schemas/{name}.schema.json" for name in documented),
    }
    summary = json.loads((folder.root / "deliver" / "summary.json").read_text())
    assert set(summary["deliverables"]) == names - {"summary.json"}
    assert summary["failed"] == {}


def test_a_bare_dive_delivers_path_plots_and_report(bare: Survey, folder: Folder) -> None:
    deliver(bare, folder)
    assert {name for name in delivered(folder) if not name.startswith("plots/")} == {
        "trajectory.csv",
        "trajectory.tum",
        "csv-metadata.json",
        "dive_result.mcap",
        "report/index.html",
        "report/report.pdf",
        "summary.json",
        "schemas/summary.schema.json",
    }


def test_a_document_at_the_end_has_its_schema_and_is_on_the_page(
    survey: Survey, folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    chart = [entry for entry in deliverables.DELIVERABLES if entry.name == "chart.json"]
    others = [entry for entry in deliverables.DELIVERABLES if entry.name != "chart.json"]
    monkeypatch.setattr(deliverables, "DELIVERABLES", (*others, *chart))
    deliver(survey, folder, only={"chart.json", "schemas/", "report/index.html"})
    assert "schemas/chart.schema.json" in delivered(folder)
    assert "chart.json" in (folder.root / "deliver" / "report" / "index.html").read_text()


def test_only_the_deliverables_asked_for_are_written(survey: Survey, folder: Folder) -> None:
    deliver(survey, folder, only=("trajectory.tum", "alignment.json"))
    assert delivered(folder) == {"trajectory.tum", "alignment.json", "summary.json"}


def test_files_of_the_steps_are_delivered_by_their_name(
    bare: Survey, folder: Folder, tmp_path: Path
) -> None:
    (tmp_path / "points3D.bin").write_bytes(b"abc")
    copies = Provenance(copies={"colmap/points3D.bin": tmp_path / "points3D.bin"})
    deliver(replace(bare, provenance=copies), folder, only=("colmap/", "report/index.html"))
    assert (folder.root / "deliver" / "colmap" / "points3D.bin").read_bytes() == b"abc"
    page = (folder.root / "deliver" / "report" / "index.html").read_text()
    assert "../colmap/points3D.bin" in page


def test_a_change_document_is_delivered_with_its_schema(
    bare: Survey, folder: Folder, tmp_path: Path
) -> None:
    (tmp_path / "change.json").write_text("{}")
    copies = Provenance(copies={"change/change.json": tmp_path / "change.json"})
    deliver(replace(bare, provenance=copies), folder, only=("change/", "schemas/"))
    assert {"change/change.json", "schemas/change.schema.json"} <= delivered(folder)


def test_without_a_cad_model_no_alignment_is_delivered(survey: Survey, folder: Folder) -> None:
    assert survey.adjusted is not None
    free = replace(survey.adjusted.solution, hull_pose=None)
    unaligned = replace(
        survey, track=free.track(), adjusted=replace(survey.adjusted, solution=free)
    )
    deliver(unaligned, folder, only=("alignment.json", "landmarks.ply"))
    assert delivered(folder) == {"landmarks.ply", "summary.json"}


def test_the_alignment_has_the_weak_directions_of_adjust(survey: Survey, folder: Folder) -> None:
    deliver(survey, folder, only=("alignment.json",))
    alignment = json.loads((folder.root / "deliver" / "alignment.json").read_text())
    assert alignment["weak_directions"][0]["direction"] == [1.0, 0, 0]
    assert alignment["T_g_M"]["translation"] == [10.0, 20.0, 3.0]


def test_objects_csv_has_the_documented_columns(
    survey: Survey, found: ReportedObject, folder: Folder
) -> None:
    second = replace(found, id=2, deviation=None, address='by "the" keel, port')
    objects = replace(survey.findings, objects=(found, second))
    deliver(replace(survey, findings=objects), folder, only=("objects.csv",))
    with (folder.root / "deliver" / "objects.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["id"] for row in rows] == ["1", "2"]
    assert rows[1]["deviation_m"] == ""
    assert rows[1]["address"] == 'by "the" keel, port'
    assert list(rows[0])[:4] == ["id", "center_x_m", "center_y_m", "center_z_m"]
    assert list(rows[0])[16:18] == ["address", "image_count"]


def break_(monkeypatch: pytest.MonkeyPatch, function: str, error: Exception) -> None:
    """Make a function that writes deliverables raise an error."""

    def broken(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(deliverables, function, broken)


@pytest.mark.parametrize(
    ("function", "lost"),
    [
        ("las_bytes", {"as_found.las"}),
        ("chart_mesh", {"chart.ply", "chart.json"}),
        ("object_crops", {"objects/"}),
        ("plot_drawings", {"plots/"}),
        ("print_context", {"report/index.html", "report/report.pdf"}),
        ("draw_page", {"report/index.html"}),
    ],
)
def test_a_deliverable_that_fails_costs_only_itself(
    survey: Survey, folder: Folder, monkeypatch: pytest.MonkeyPatch, function: str, lost: set[str]
) -> None:
    some = {"as_found.las", "chart.ply", "chart.json", "objects/", "plots/", "objects.gpkg"}
    some |= {"report/index.html"} if "report/index.html" not in lost else lost
    break_(monkeypatch, function, ValueError("the picture is 20,000 px\nwide"))
    failures = deliver(survey, folder, only=some)
    assert {failure.name for failure in failures} == lost
    assert all(
        function in failure.traceback or "broken" in failure.traceback for failure in failures
    )
    summary = json.loads((folder.root / "deliver" / "summary.json").read_text())
    assert summary["failed"] == dict.fromkeys(lost, "ValueError: the picture is 20,000 px wide")
    written = delivered(folder)
    for name in some - lost:
        assert any(file == name or file.startswith(name) for file in written), name
    if "report/index.html" not in lost:
        page = (folder.root / "deliver" / "report" / "index.html").read_text()
        assert "Deliverables that could not be written" in page
        assert f"{min(lost)}: ValueError: the picture is 20,000 px wide" in page


def test_a_pdf_that_fails_stands_on_the_page(
    bare: Survey, folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    # an OSError without a number is a library's, not the disk's
    break_(monkeypatch, "render_pdf", OSError("cannot identify image file"))
    deliver(bare, folder, only=("report/report.pdf", "report/index.html"))
    page = (folder.root / "deliver" / "report" / "index.html").read_text()
    assert "report/report.pdf: OSError: cannot identify image file" in page


@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), MemoryError(), InputError("no such ship")]
)
def test_an_error_that_concerns_all_ends_the_step(
    bare: Survey, folder: Folder, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    break_(monkeypatch, "trajectory_tum", error)
    with pytest.raises(type(error)):
        deliver(bare, folder, only=("trajectory.tum",))
