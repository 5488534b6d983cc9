# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tables that say unit and meaning of their columns."""

from __future__ import annotations

import csv
import io
import json
from typing import Any

import pytest

from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.export.tables import (
    UNITS,
    Column,
    Table,
    csv_metadata,
    objects_table,
    trajectory_table,
)
from hullrecon.report.survey import Survey


@pytest.fixture
def table() -> Table:
    return Table(
        file="lengths.csv",
        title="some lengths",
        columns=[
            Column(name="length", unit="m", meaning="how long", values=["1.5", ""]),
            Column(name="count", unit="", meaning="how many", values=[3, 4]),
            Column(
                name="name",
                unit="",
                meaning="what it is called",
                values=['a "b", c', "d"],
                words=True,
            ),
        ],
    )


def entries(tables: list[Table]) -> list[dict[str, Any]]:
    described: Any = json.loads(json.dumps(csv_metadata(tables)))
    return [entry["tableSchema"]["columns"] for entry in described["tables"]]


def test_a_table_is_a_csv_of_its_columns(table: Table) -> None:
    rows = list(csv.DictReader(io.StringIO(table.csv)))
    assert rows == [
        {"length_m": "1.5", "count": "3", "name": 'a "b", c'},
        {"length_m": "", "count": "4", "name": "d"},
    ]


def test_the_metadata_are_those_of_csv_on_the_web(table: Table) -> None:
    document: Any = csv_metadata([table])
    assert document["@context"] == "http://www.w3.org/ns/csvw"
    assert [entry["url"] for entry in document["tables"]] == ["lengths.csv"]
    length, count, name = entries([table])[0]
    assert (length["name"], length["datatype"], length["unit"]) == ("length_m", "number", "m")
    assert length["qudt:hasUnit"] == "http://qudt.org/vocab/unit/M"
    assert "unit" not in count
    assert name["datatype"] == "string"


def test_an_unknown_unit_is_refused(table: Table) -> None:
    furlong = Table(
        file="a.csv",
        title="a",
        columns=[Column(name="a", unit="furlong", meaning="far", values=[])],
    )
    with pytest.raises(KeyError, match="furlong"):
        csv_metadata([furlong])


def test_every_column_of_lengths_angles_and_times_has_a_unit(
    survey: Survey, found: ReportedObject
) -> None:
    trajectory, objects = entries([trajectory_table(survey), objects_table([found])])
    without = {c["name"] for c in [*trajectory, *objects] if "unit" not in c}
    quaternion, normal = {"qx", "qy", "qz", "qw"}, {"normal_x", "normal_y", "normal_z"}
    assert without == quaternion | normal | {
        "side",
        "frame",
        "id",
        "views",
        "open_edge",
        "p_value",
        "address",
        "image_count",
    }
    assert {c["unit"] for c in [*trajectory, *objects] if "unit" in c} == set(UNITS)


def test_every_heading_ends_in_the_unit_of_its_column(
    survey: Survey, found: ReportedObject
) -> None:
    for table in (trajectory_table(survey), objects_table([found])):
        headings = table.csv.splitlines()[0].split(",")
        assert headings == [f"{c.name}_{c.unit}" if c.unit else c.name for c in table.columns]
        assert {"t_s", "x_m", "sigma_roll_rad", "tray_rad"} <= set(headings) or {
            "center_x_m",
            "area_m2",
            "volume_m3",
        } <= set(headings)


def test_a_name_means_the_same_in_table_and_document(found: ReportedObject) -> None:
    (row,) = csv.DictReader(io.StringIO(objects_table([found]).csv))
    assert "images" not in row  # objects.json lists them under that name
    assert row["image_count"] == str(len(found.images))


def test_the_contracts_columns_come_first_and_keep_their_names(
    survey: Survey, found: ReportedObject
) -> None:
    trajectory, objects = (
        [c.name for c in t.columns] for t in (trajectory_table(survey), objects_table([found]))
    )
    assert trajectory[:15] == (
        "t x y z qx qy qz qw sigma_x sigma_y sigma_z sigma_roll sigma_pitch sigma_yaw tray".split()  # noqa: SIM905
    )
    assert {
        "id",
        "center_x",
        "extent_1",
        "height",
        "height_sigma",
        "deviation",
        "area",
        "volume",
    } < set(objects[:18])


def test_an_object_without_sigmas_leaves_cells_empty() -> None:
    bare = ReportedObject(id=1, center=(0.0, 0.0, 0.0), height=0.1)
    (row,) = csv.DictReader(io.StringIO(objects_table([bare]).csv))
    assert (
        row["position_sigma_x_m"] == row["extent_1_sigma_m"] == row["depth_m"] == row["side"] == ""
    )
    assert row["height_m"] == "0.1"
