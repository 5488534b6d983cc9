# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every option of dive.toml: which steps' settings it changes, and that explain names it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import pytest

from hullrecon.artifacts.manifest import Recipe
from hullrecon.artifacts.recipe import differences
from hullrecon.artifacts.stage import Stage, resolve_settings, settings_for
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


def recipe(stage: Stage, sections: Mapping[str, Any]) -> Recipe:
    settings = resolve_settings(settings_for(stage, sections))
    return Recipe(stage=stage.name, version=stage.version, settings=settings)


@pytest.fixture(scope="module")
def affected(sections: Mapping[str, Any]) -> dict[tuple[str, str], dict[str, list[str]]]:
    """By (section, key): the steps whose recipe changes with that key, and what is said of it."""
    before = {stage.name: recipe(stage, sections) for stage in STAGES}
    found = {}
    for section, key in keys():
        fields = msgspec.structs.fields(sections[section])
        (name,) = [field.name for field in fields if field.encode_name == key]
        other = msgspec.structs.replace(sections[section], **{name: "another value"})
        changed = {**sections, section: other}
        said = {s.name: differences(before[s.name], recipe(s, changed)) for s in STAGES}
        found[section, key] = {step: lines for step, lines in said.items() if lines}
    return found


def test_every_option_changes_a_step_and_is_named_there(affected: Any) -> None:
    for (section, key), found in affected.items():
        assert found, f"no step reads {section}.{key}"
        for said in found.values():
            assert len(said) == 1, (section, key)
            assert f"{section}.{key} changed from " in said[0]
            assert said[0].endswith('to "another value"')


def test_own_options_change_the_steps_that_read_them(affected: Any) -> None:
    for stage in STAGES:
        for key in stage.parameters.__struct_fields__:
            reads = {stage.name, f"{stage.name}.{key}"}
            readers = {other.name for other in STAGES if reads & set(other.uses)}
            assert affected[stage.name, key].keys() == {stage.name} | readers, (stage.name, key)


def test_what_a_step_says_it_reads_exists(sections: Mapping[str, Any]) -> None:
    known = {*sections, *(f"{section}.{key}" for section, key in keys())}
    before = set[str]()
    for stage in STAGES:
        assert set(stage.uses) <= known, stage.name
        assert {*stage.inputs, *stage.optional} <= before, f"{stage.name} takes a later step"
        before.add(stage.name)
