# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""docs/configuration.md is what the code declares."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from hullrecon.steps.chain import stages

DOCS = Path(__file__).resolve().parents[2] / "docs"
SUFFIX_UNITS = {
    "_m": "m",
    "_s": "s",
    "_px": "px",
    "_deg": "deg",
    "_deg_per_hour": "deg/h",
    "_chi2": "chi2",
    "_sigmas": "sigmas",
}


@pytest.fixture(scope="module")
def generator() -> ModuleType:
    spec = importlib.util.spec_from_file_location(
        "generate_configuration", DOCS / "generate_configuration.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_page_is_what_the_code_declares(generator: ModuleType) -> None:
    written = (DOCS / "configuration.md").read_text()
    assert written == generator.text(), "run python docs/generate_configuration.py"


def test_every_key_says_what_it_means(generator: ModuleType) -> None:
    silent = [key.name for table in generator.tables() for key in table.keys if not key.meaning]
    assert not silent


def test_a_key_that_is_a_measure_has_its_unit(generator: ModuleType) -> None:
    bare = [
        key.name
        for table in generator.tables()
        for key in table.keys
        if not key.unit and key.kind.startswith(("number", "3 numbers", "6 numbers", "2 numbers"))
    ]
    assert not bare


def test_a_unit_in_a_key_is_the_unit_of_its_description(generator: ModuleType) -> None:
    for table in generator.tables():
        for key in table.keys:
            said = next(
                (unit for ending, unit in SUFFIX_UNITS.items() if key.name.endswith(ending)),
                key.unit,
            )
            assert key.unit == said, key.name


def test_an_option_of_a_step_ends_in_its_unit(generator: ModuleType) -> None:
    steps = {stage.name for stage in stages()}
    keys = [
        key
        for table in generator.tables()
        if table.name in steps
        for key in table.keys
        if "_per_" not in key.name
    ]
    endings = {
        unit: ending
        for ending, unit in SUFFIX_UNITS.items()
        if unit in ("m", "s", "px", "deg", "deg/h")
    }
    assert [
        key.name for key in keys if key.unit in endings and not key.name.endswith(endings[key.unit])
    ] == []


def test_tables_of_the_dive_and_of_the_steps_are_there(generator: ModuleType) -> None:
    names = [table.name for table in generator.tables()]
    assert names[:3] == ["dive", "logs", "topics"]
    assert {
        "camera.top",
        "camera.bottom",
        "sonar",
        "hull",
        "links",
        "matches",
        "adjust",
        "detect",
    } <= set(names)
    assert len(names) == len(set(names))
