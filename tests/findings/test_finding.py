# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import ast
from pathlib import Path

import pytest

import hullrecon
from hullrecon.findings.finding import TABLES, WORDS, Finding, sentences

SOURCES = [
    path
    for path in sorted(Path(hullrecon.__file__).parent.rglob("*.py"))
    if path.parent.name != "findings"
]


def texts_of(path: Path) -> set[object]:
    """All texts that stand in a source file."""
    tree = ast.walk(ast.parse(path.read_text()))
    return {node.value for node in tree if isinstance(node, ast.Constant)}


def test_each_code_is_used_by_the_library():
    unused = WORDS.keys() - set().union(*map(texts_of, SOURCES))
    assert unused == set()


def test_each_code_has_one_severity():
    assert len(WORDS) == sum(len(table) for _, table in TABLES)


def test_sentence_has_values_and_place():
    found = Finding("read-beside", {"others": ["imu", "dvl"], "seconds": 2.0, "after": True}, "gps")
    assert found.severity == "warning"
    assert found.sentence.startswith("gps: it was read 2.0 s after imu and dvl")
    assert sentences([found.inside("a.mcap")])[0].startswith("a.mcap: gps: it was read")
    assert found.inside("a.mcap").inside("bag").where == "bag: a.mcap: gps"


def test_document_has_code_severity_values_sentence():
    found = Finding("imu-single-reading", where="imu")
    assert found.document() == {
        "code": "imu-single-reading",
        "severity": "warning",
        "where": "imu",
        "values": {},
        "sentence": f"imu: {WORDS['imu-single-reading']}",
    }


def test_unknown_code_is_refused():
    with pytest.raises(KeyError, match="no-such-code"):
        Finding("no-such-code")
