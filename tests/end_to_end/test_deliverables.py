# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The demo's deliverables are those that docs/deliverables.md and the schemas describe: file by
file, field by field.
"""

import csv
import json
import re
from pathlib import Path

import pytest
from end_to_end.json_schema import violations

DOCS = Path(__file__).resolve().parents[2] / "docs"
SCHEMAS = DOCS.parent / "hullrecon" / "report" / "schemas"
JSON = ("summary", "alignment", "objects", "coverage", "chart")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def deliver(demo_run):
    return demo_run / "deliver"


def schema(name):
    return json.loads((SCHEMAS / f"{name}.schema.json").read_text())


def described(file):
    """First cells of the table under the heading of that file."""
    text = (DOCS / "deliverables.md").read_text()
    section = re.search(rf"^### {re.escape(file)}\n(.*?)(?=^##|\Z)", text, re.MULTILINE | re.DOTALL)
    assert section, f"{file} has no section"
    return [
        row.split("|")[1].strip().strip("`")
        for row in re.findall(r"^\|.*\|$", section[1], re.MULTILINE)[2:]
    ]


@pytest.mark.parametrize("name", JSON)
def test_a_document_keeps_to_its_schema(deliver, name):
    document = json.loads((deliver / f"{name}.json").read_text())
    assert violations(document, schema(name)) == []
    assert json.loads((deliver / "schemas" / f"{name}.schema.json").read_text()) == schema(name)


@pytest.mark.parametrize("name", JSON)
def test_a_schema_names_every_field_and_says_what_it_is(name):
    def silent(node, path):
        members = node.get("properties", {})
        bare = [
            f"{path}.{k}"
            for k, v in members.items()
            if not v.get("description") and "const" not in v and "properties" not in v
        ]
        inner = [silent(v, f"{path}.{k}") for k, v in members.items()] + (
            [silent(node["items"], f"{path}[]")] if "items" in node else []
        )
        return bare + [name for part in inner for name in part]

    assert silent(schema(name), name) == []


def test_missing_unknown_or_mistyped_field_breaks_the_schema(deliver):
    document = json.loads((deliver / "objects.json").read_text())
    first = document["objects"][0]
    for spoiled in (
        {**first, "height": "high"},
        {**first, "colour": 1},
        {name: value for name, value in first.items() if name != "area"},
        {**first, "center": [1.0, 2.0]},
        {**first, "p_value": 1.5},
    ):
        assert violations({"objects": [spoiled]}, schema("objects"))


TABLES = (
    "trajectory.csv",
    "objects.csv",
    "plots/labels.csv",
    "plots/residuals.csv",
    "plots/position_sigma.csv",
    "plots/depth_standoff.csv",
    "plots/deviation_histogram.csv",
)


@pytest.mark.parametrize("name", TABLES)
def test_a_table_has_the_columns_described(deliver, name):
    rows = list(csv.reader((deliver / name).read_text().splitlines()))
    assert rows[0] == described(name)
    assert all(len(row) == len(rows[0]) for row in rows)


def test_the_costs_of_the_factors_add_up_to_the_cost(deliver):
    rows = list(csv.DictReader((deliver / "plots/convergence.csv").read_text().splitlines()))
    assert described("plots/convergence.csv")[:3] == list(rows[0])[:3]
    for row in rows:
        parts = sum(float(v) for k, v in row.items() if k not in ("round", "iteration", "cost"))
        assert parts == pytest.approx(float(row["cost"]), rel=1e-6)


@pytest.mark.parametrize("name", ["landmarks.ply", "surface.ply", "as_found.ply", "chart.ply"])
def test_a_point_cloud_has_the_properties_described(deliver, name):
    head = (deliver / name).read_bytes().split(b"end_header")[0].decode()
    properties = re.findall(r"^property (?!list)\S+ (\S+)$", head, re.MULTILINE)
    assert properties == described(name)


def test_the_point_cloud_has_the_dimensions_described(deliver):
    import laspy

    with laspy.open(deliver / "as_found.las") as cloud:
        assert list(cloud.header.point_format.extra_dimension_names) == described("as_found.las")


def test_mcap_has_described_topics_with_valid_messages(deliver):
    from mcap.reader import make_reader

    found = set()
    with (deliver / "dive_result.mcap").open("rb") as file:
        for form, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            found.add(channel.topic)
            assert violations(json.loads(message.data), json.loads(form.data)) == []
    assert sorted(found) == sorted(described("dive_result.mcap"))


def test_delivered_files_are_those_listed(deliver):
    section = (DOCS / "deliverables.md").read_text().split("## JSON documents")[0]
    listed = re.findall(r"^\| `([^`]+)` \|", section, re.MULTILINE)
    files = {p.relative_to(deliver).as_posix() for p in deliver.rglob("*") if p.is_file()}
    assert {
        f
        for f in files
        if f not in listed and not any(f.startswith(d) for d in listed if d.endswith("/"))
    } == set()
    missing = {
        d
        for d in listed
        if d not in files and not any(f.startswith(d) for f in files if d.endswith("/"))
    }
    # only where an earlier dive is named (test_change.py), and of mosaics too large for the page
    assert missing == {"change/", "report/tiles/"}


def test_the_rasters_carry_the_place_described(deliver):
    import tifffile

    text = (DOCS / "deliverables.md").read_text()
    keys = re.findall(
        r"^\| `(\w+)` \|", text.split("| key of ImageDescription |")[1].split("##")[0], re.MULTILINE
    )
    for name in ("ortho_optical.tif", "ortho_sonar.tif"):
        with tifffile.TiffFile(deliver / name) as tif:
            assert set(json.loads(tif.pages[0].tags["ImageDescription"].value)) == set(keys)
