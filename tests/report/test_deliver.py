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

import numpy as np
import pytest

from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.solution import Solution
from hullrecon.report.deliver import DeliverableWriter, deliver
from hullrecon.report.survey import Provenance, Survey


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


def test_an_entry_has_size_and_hash_of_what_was_written(folder: Folder) -> None:
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


def test_a_copy_has_the_bytes_and_the_hash_of_its_source(folder: Folder, tmp_path: Path) -> None:
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


def test_a_whole_survey_delivers_what_it_has(survey: Survey, folder: Folder) -> None:
    documents = {"objects.json": {"objects": []}, "coverage.json": {"frame": "M"}}
    deliver(replace(survey, findings=replace(survey.findings, documents=documents)), folder)
    names = delivered(folder)
    assert {
        "trajectory.csv",
        "trajectory.tum",
        "alignment.json",
        "landmarks.ply",
        "surface.ply",
        "as_found.ply",
        "as_found.las",
        "objects.json",
        "objects.csv",
        "coverage.json",
        "report/index.html",
        "report/report.pdf",
        "summary.json",
        "plots/convergence.png",
        "plots/convergence.csv",
    } <= names


def test_each_document_is_delivered_with_its_schema_and_no_other(
    survey: Survey, folder: Folder
) -> None:
    deliver(
        replace(
            survey, findings=replace(survey.findings, documents={"coverage.json": {"frame": "M"}})
        ),
        folder,
    )
    found = {name for name in delivered(folder) if name.startswith("schemas/")}
    documents = {
        "summary",
        "alignment",
        "coverage",
        *({"chart"} if "chart.json" in delivered(folder) else ()),
    }
    assert found == {f"schemas/{name}.schema.json" for name in documents}


def test_the_summary_lists_every_file_but_itself(survey: Survey, folder: Folder) -> None:
    deliver(survey, folder)
    summary = json.loads((folder.root / "deliver" / "summary.json").read_text())
    assert set(summary["deliverables"]) == delivered(folder) - {"summary.json"}


def test_a_bare_dive_delivers_its_path_plots_and_report(bare: Survey, folder: Folder) -> None:
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


def test_files_of_the_steps_are_delivered_by_their_name(
    bare: Survey, folder: Folder, tmp_path: Path
) -> None:
    (tmp_path / "points3D.bin").write_bytes(b"abc")
    copies = Provenance(copies={"colmap/points3D.bin": tmp_path / "points3D.bin"})
    deliver(replace(bare, provenance=copies), folder)
    assert (folder.root / "deliver" / "colmap" / "points3D.bin").read_bytes() == b"abc"
    assert (
        "../colmap/points3D.bin" in (folder.root / "deliver" / "report" / "index.html").read_text()
    )


def test_what_changed_is_delivered_with_the_schema_of_its_document(
    bare: Survey, folder: Folder, tmp_path: Path
) -> None:
    (tmp_path / "change.json").write_text("{}")
    copies = Provenance(copies={"change/change.json": tmp_path / "change.json"})
    deliver(replace(bare, provenance=copies), folder)
    assert {"change/change.json", "schemas/change.schema.json"} <= delivered(folder)


def test_without_a_cad_model_no_alignment_is_delivered(
    survey: Survey, solution: Solution, folder: Folder
) -> None:
    assert survey.adjusted is not None
    free = replace(solution, hull_pose=None)
    deliver(
        replace(survey, track=free.track(), adjusted=replace(survey.adjusted, solution=free)),
        folder,
    )
    names = delivered(folder)
    assert "alignment.json" not in names
    assert "landmarks.ply" in names


def test_without_a_landmark_there_is_no_cloud(
    survey: Survey, solution: Solution, folder: Folder
) -> None:
    assert survey.adjusted is not None
    none = replace(
        solution.landmarks,
        position=np.zeros((0, 3)),
        label=np.zeros(0, np.int64),
        deviation=np.zeros(0),
        covariance=np.zeros((0, 3, 3)),
        views=np.zeros(0, np.int64),
        color=np.zeros((0, 3), np.uint8),
    )
    deliver(
        replace(
            survey, adjusted=replace(survey.adjusted, solution=replace(solution, landmarks=none))
        ),
        folder,
    )
    assert "landmarks.ply" not in delivered(folder)


def test_the_alignment_has_the_weak_directions_as_adjust_gave_them(
    survey: Survey, folder: Folder
) -> None:
    deliver(survey, folder)
    alignment = json.loads((folder.root / "deliver" / "alignment.json").read_text())
    assert alignment["weak_directions"][0]["direction"] == [1.0, 0, 0]
    assert alignment["T_g_M"]["translation"] == [10.0, 20.0, 3.0]


def test_objects_csv_has_the_columns_of_the_documents_page(
    survey: Survey, found: ReportedObject, folder: Folder
) -> None:
    second = replace(found, id=2, deviation=None, address='by "the" keel, port')
    deliver(replace(survey, findings=replace(survey.findings, objects=(found, second))), folder)
    with (folder.root / "deliver" / "objects.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["id"] for row in rows] == ["1", "2"]
    assert rows[1]["deviation_m"] == ""
    assert rows[1]["address"] == 'by "the" keel, port'
    assert list(rows[0])[:4] == ["id", "center_x_m", "center_y_m", "center_z_m"]
    assert list(rows[0])[16:18] == ["address", "image_count"]
