# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every option of dive.toml, one by one: which steps' settings it changes, and that explain names
it.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import pytest

from hullrecon.artifacts.manifest import Recipe
from hullrecon.artifacts.recipe import differences
from hullrecon.artifacts.stage import resolve_settings, settings_for
from hullrecon.dive.config.load import load_config
from hullrecon.dive.config.schema import CameraBottom, CameraTop, Hull, Sonar
from hullrecon.steps.chain import stages

STAGES = stages()
PACKAGE = """
[dive]
name = "a"
[logs]
files = ["a.mcap"]
[camera.top]
calibration = "top.yaml"
[camera.bottom]
calibration = "bottom.yaml"
[sonar]
[hull]
mesh = "hull.stl"
"""
KINDS = {"camera.top": CameraTop, "camera.bottom": CameraBottom, "sonar": Sonar, "hull": Hull}


@pytest.fixture(scope="module")
def sections(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Any]:
    """A configuration in which every section is present."""
    folder: Path = tmp_path_factory.mktemp("package")
    (folder / "dive.toml").write_text(PACKAGE)
    return load_config(folder, {stage.name: stage.parameters for stage in STAGES}).sections


def keys() -> list[tuple[str, str]]:
    """(section, key) of everything that dive.toml may say."""
    from hullrecon.dive.config.schema import DiveConfig

    plain = {
        f.name: f.type
        for f in msgspec.structs.fields(DiveConfig)
        if f.name not in ("camera", "sonar", "hull")
    }
    kinds = {**plain, **KINDS, **{stage.name: stage.parameters for stage in STAGES}}
    return [
        (section, field.encode_name)
        for section, kind in kinds.items()
        for field in msgspec.structs.fields(kind)
    ]


def recipes(sections: Mapping[str, Any]) -> dict[str, Recipe]:
    return {
        stage.name: Recipe(
            stage=stage.name,
            version=stage.version,
            settings=resolve_settings(settings_for(stage, sections)),
        )
        for stage in STAGES
    }


def affected(section: str, key: str, sections: Mapping[str, Any]) -> dict[str, list[str]]:
    """The steps whose recipe changes when that key does, with what is said of it."""
    (name,) = [
        field.name
        for field in msgspec.structs.fields(sections[section])
        if field.encode_name == key
    ]
    other = msgspec.structs.replace(sections[section], **{name: "another value"})
    before, after = recipes(sections), recipes({**sections, section: other})
    return {name: said for name in before if (said := differences(before[name], after[name]))}


@pytest.mark.parametrize(("section", "key"), keys(), ids=lambda part: part)
def test_an_option_changes_some_step_and_is_named_there(
    section: str, key: str, sections: Mapping[str, Any]
) -> None:
    found = affected(section, key, sections)
    assert found, f"no step reads {section}.{key}"
    for said in found.values():
        assert len(said) == 1
        assert f"{section}.{key} changed from " in said[0]
        assert said[0].endswith('to "another value"')


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_a_steps_own_options_change_that_step_and_those_that_say_they_read_them(
    stage: Any, sections: Mapping[str, Any]
) -> None:
    for key in stage.parameters.__struct_fields__:
        readers = {
            other.name for other in STAGES if {stage.name, f"{stage.name}.{key}"} & set(other.uses)
        }
        assert affected(stage.name, key, sections).keys() == {stage.name} | readers


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_what_a_step_says_it_reads_exists(stage: Any, sections: Mapping[str, Any]) -> None:
    known = {*sections, *(f"{section}.{key}" for section, key in keys())}
    assert set(stage.uses) <= known
    names = [s.name for s in STAGES]
    before = names[: names.index(stage.name)]
    assert {*stage.inputs, *stage.optional} <= set(before), "a step takes one that comes after it"
