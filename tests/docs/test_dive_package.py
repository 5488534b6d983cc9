# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""docs/dive_package.md names what is read: every type of message, every column of the plain form,
and what is refused.
"""

from __future__ import annotations

import ast
import inspect
import re
from pathlib import Path

import pytest

from hullrecon.dive.logs.formats import foreign_forms
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.dive.logs.readers import plain

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "dive_package.md").read_text()
OLD_NAMES = {"mavros_msgs/VFR_HUD": "mavros_msgs/VfrHud"}  # the same message as ROS 1 calls it


def row_of(first: str) -> str:
    """Return the row of a table whose first cell names that in code."""
    (row,) = [
        line
        for line in PAGE.splitlines()
        if line.startswith("|") and f"`{first}`" in line.split("|")[1]
    ]
    return row


@pytest.mark.parametrize("sensor", sorted(TYPES))
def test_sensor_row_names_exactly_the_types_read(sensor: str) -> None:
    read = {kind.replace("/msg/", "/") for kind in TYPES[sensor]}
    assert set(re.findall(r"`(\w+/\w+)`", row_of(sensor))) == {
        OLD_NAMES.get(kind, kind) for kind in read
    }


@pytest.mark.parametrize("sensor", sorted(plain.COLUMNS))
def test_a_tables_row_names_the_columns_that_it_must_have(sensor: str) -> None:
    file = "camera_top" if sensor == "camera_bottom" else sensor  # "likewise"
    assert "likewise" in row_of("camera_bottom.csv")
    named = set(re.findall(r"`(\w+)`", row_of(f"{file}.csv").split("|")[2]))
    assert set(plain.COLUMNS[sensor]) <= named


def columns_in_code() -> set[str]:
    """Return every cell of a row that the reader asks for: row["name"], row.get("name"), and names
    in tuples around them.
    """
    tree = ast.parse(inspect.getsource(plain))
    asked: set[str] = set()
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Subscript)
            and isinstance(node.value, ast.Name)
            and node.value.id == "row"
        ):
            asked |= _texts(node.slice)
        elif (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Attribute)
            and node.func.attr == "get"
        ):
            asked |= (
                _texts(node.args[0])
                if isinstance(node.func.value, ast.Name) and node.func.value.id == "row"
                else set()
            )
        elif isinstance(node, ast.comprehension) and "row" in {
            n.id for n in ast.walk(node.iter) if isinstance(n, ast.Name)
        }:
            continue
        elif isinstance(node, ast.comprehension):
            asked |= _texts(node.iter)
    return asked | set(plain.RATES) | set(plain.ACCELERATION) | set(plain.WINDOW)


def _texts(node: ast.AST) -> set[str]:
    found = (
        n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)
    )
    return {text for text in found if re.fullmatch(r"[a-z_]+", text)} - {"dvl", *plain.COLUMNS}


def test_the_page_names_every_column_that_the_code_reads() -> None:
    section = PAGE.split("### A folder of CSVs")[1].split("###")[0]
    asked = columns_in_code()
    assert {
        "t",
        "vx",
        "qw",
        "pascal",
        "rad",
        "file",
        "frame",
        "ping",
        "range_from",
        "wx",
        "az",
    } <= asked
    assert sorted(asked - set(re.findall(r"`(\w+)`", section))) == []
    assert "`range_1`" in section  # and so on: by their beginning


def test_the_page_names_every_form_that_is_refused_by_its_name() -> None:
    told = PAGE.split("### Files that are refused")[1].split("\n## ")[0]
    for suffix in (".tlog", ".svlog", ".bin", ".xtf", ".jsf", ".mat", ".npz", ".zip"):
        known = suffix in foreign_forms.BY_SUFFIX or suffix == ".bin"  # by its first bytes
        assert known, suffix
        assert suffix in told, suffix
