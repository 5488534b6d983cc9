# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import csv
import io
import json
import re
import sqlite3
from pathlib import Path

import numpy as np
import pytest
from end_to_end.json_schema import violations
from PIL import Image
from report.change.conftest import T_NS, each_kind, hull_change, seen_from_port

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.change import HullChange
from hullrecon.report.change.files import HEADINGS, change_files, change_layer, comparison_files

DOCS = Path(__file__).resolve().parents[3] / "docs"
SCHEMAS = DOCS.parent / "hullrecon" / "report" / "schemas"


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    return change_files(each_kind(), seen_from_port(), T_NS)


@pytest.fixture
def document(files: dict[str, bytes]):
    return json.loads(files["change.json"])


def described() -> list[str]:
    """First cells of the table of change.csv in docs/deliverables.md."""
    text = (DOCS / "deliverables.md").read_text()
    section = re.search(r"^### change\.csv\n(.*?)(?=^##|\Z)", text, re.MULTILINE | re.DOTALL)
    assert section
    return [
        row.split("|")[1].strip().strip("`")
        for row in re.findall(r"^\|.*\|$", section[1], re.MULTILINE)[2:]
    ]


def test_all_files_are_there(files: dict[str, bytes]) -> None:
    assert sorted(files) == [
        "change.csv",
        "change.geojson",
        "change.gpkg",
        "change.json",
        "change.png",
    ]
    assert all(files.values())


def test_a_comparison_alone_has_a_page_and_its_document_last(
    change: HullChange, outside: OutsideMap, files
) -> None:
    alone = comparison_files(change, outside, T_NS)
    assert list(alone) == [
        "change.csv",
        "change.geojson",
        "change.gpkg",
        "change.png",
        "change.html",
        "change.json",
    ]
    assert {name: data for name, data in alone.items() if name != "change.html"} == files


def test_the_same_comparison_gives_the_same_bytes(
    files: dict[str, bytes], change: HullChange, outside: OutsideMap
) -> None:
    assert change_files(change, outside, T_NS) == files


def test_the_document_keeps_to_its_schema(document) -> None:
    schema = json.loads((SCHEMAS / "change.schema.json").read_text())
    assert violations(document, schema) == []
    assert violations({**document, "frame": "g"}, schema)
    assert violations(
        {**document, "objects": [{**document["objects"][0], "status": "odd"}]}, schema
    )


def test_a_comparison_without_a_change_keeps_to_the_schema_too(outside: OutsideMap) -> None:
    schema = json.loads((SCHEMAS / "change.schema.json").read_text())
    assert (
        violations(json.loads(change_files(hull_change(), outside, T_NS)["change.json"]), schema)
        == []
    )


def test_the_document_has_objects_of_both_dives_by_their_numbers(document) -> None:
    assert [(row["status"], row["first_id"], row["second_id"]) for row in document["objects"]] == [
        ("gone", 4, None),
        ("new", None, 5),
        ("new", None, None),
        ("grown", 1, 1),
        ("not seen again", 7, None),
        ("unchanged", 2, 3),
    ]


def test_what_is_not_known_is_null_and_not_nan(files: dict[str, bytes], document) -> None:
    row = document["objects"][4]
    assert row["change"] is row["p_value"] is row["height_after"] is row["area"] is None
    assert b"NaN" not in files["change.json"]


def test_the_offset_is_given_with_its_covariances(document) -> None:
    offset = document["offset"]
    assert offset["translation_m"] == [0.05, 0.0, -0.01]
    assert offset["rotation_rad"] == [0.0, 0.001, 0.0]
    assert (
        np.array(offset["covariance"]).shape == np.array(offset["prior_covariance"]).shape == (6, 6)
    )


def test_the_table_has_a_line_for_each_and_units_in_its_headings(files: dict[str, bytes]) -> None:
    rows = list(csv.DictReader(io.StringIO(files["change.csv"].decode())))
    assert list(rows[0]) == list(HEADINGS.values()) == described()
    assert [row["status"] for row in rows][-1] == "surface moved"
    assert (rows[3]["change_m"], rows[3]["change_sigma_m"]) == ("0.031", "0.004")
    assert rows[4]["change_m"] == ""
    assert rows[-1]["change_m"] == "-0.012"


def test_the_layer_lies_on_the_map_seen_from_outside(files: dict[str, bytes]) -> None:
    layer = json.loads(files["change.geojson"])
    corners = np.array(layer["features"][1]["geometry"]["coordinates"][0])
    assert corners[:, 0].mean() == pytest.approx(-31.2, abs=0.03)
    assert corners[:, 1].mean() == pytest.approx(5.0, abs=0.03)
    assert (corners[0] == corners[-1]).all()
    assert "x = -along" in layer["crs"]["properties"]["name"]


def test_a_place_without_an_outline_is_a_square(change: HullChange, outside: OutsideMap) -> None:
    layer = change_layer(change, outside)
    assert len(layer.shapes) == 7
    assert np.ptp(layer.shapes[2], axis=0) == pytest.approx([0.1, 0.1])


def test_the_geopackage_holds_the_layer_with_its_fields(
    files: dict[str, bytes], tmp_path: Path
) -> None:
    (tmp_path / "change.gpkg").write_bytes(files["change.gpkg"])
    with sqlite3.connect(tmp_path / "change.gpkg") as database:
        rows = database.execute("SELECT status, first_id, change FROM changes").fetchall()
        assert database.execute("SELECT count(*) FROM gpkg_contents").fetchone() == (1,)
    assert rows[0] == ("gone", 4, -0.139)
    assert rows[-1] == ("surface moved", None, -0.012)


def test_the_map_is_a_picture_of_the_window(files: dict[str, bytes]) -> None:
    with Image.open(io.BytesIO(files["change.png"])) as picture:
        assert picture.size[0] > 1000
        assert picture.size[1] > 300
        colours = {colour[:3] for _, colour in picture.convert("RGB").getcolors(1 << 24)}
    assert len(colours) > 50


def test_a_map_of_a_hull_without_changes_can_be_drawn(outside: OutsideMap) -> None:
    assert change_files(hull_change(), outside, T_NS)["change.png"].startswith(b"\x89PNG")
