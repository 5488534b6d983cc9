# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.recipe: what decides a stage's result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from msgspec import Struct

from hullrecon.artifacts.manifest import HashCache, Recipe
from hullrecon.artifacts.recipe import content_hash, external_files, make_job
from hullrecon.artifacts.stage import Stage, settings_for
from hullrecon.errors import InputError


class Options(Struct, frozen=True):
    size: float = 3.0


def stage(*files: str) -> Stage:
    return Stage(
        name="read",
        summary="read",
        inputs=(),
        parameters=Options,
        version=1,
        run=lambda context: None,
        external=lambda settings, source: [Path(name) for name in files],
    )


def recipe_of(source: Path, *files: str, inputs: dict[str, Path] | None = None) -> Recipe:
    read = stage(*files)
    return make_job(read, {}, inputs or {}, source, HashCache()).recipe


def test_external_files_are_listed_by_path_in_the_package(tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    for name in ("logs/b.csv", "logs/a.csv", "top.yaml"):
        (tmp_path / name).write_text(name)
    assert list(recipe_of(tmp_path, "logs", "top.yaml").external) == [
        "logs/a.csv",
        "logs/b.csv",
        "top.yaml",
    ]


def test_a_missing_file_is_an_input_error_that_names_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"dive\.mcap is missing .*correct dive\.toml"):
        recipe_of(tmp_path, "dive.mcap")
    (tmp_path / "dive.mcap").touch()
    assert list(recipe_of(tmp_path, "dive.mcap").external) == ["dive.mcap"]


def test_impossible_file_name_is_a_short_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        recipe_of(tmp_path, "x" * 5000)
    assert "cannot be read: File name too long" in caught.value.line()
    assert len(caught.value.what) < 150


def test_impossible_file_name_in_external_is_an_input_error(tmp_path: Path) -> None:
    def look(settings: object, source: Path) -> list[Path]:
        return [source] if (source / ("x" * 5000)).is_dir() else []

    read = Stage(
        name="read",
        summary="",
        inputs=(),
        parameters=Options,
        version=1,
        run=lambda context: None,
        external=look,
    )
    with pytest.raises(InputError, match="File name too long"):
        external_files(read, settings_for(read, {}), tmp_path, HashCache())
    named = replace(read, external=lambda settings, source: [])  # a name that can be
    assert external_files(named, settings_for(named, {}), tmp_path, HashCache()) == {}


def test_key_depends_on_content_of_input_not_its_place(
    tmp_path: Path,
) -> None:
    for name, text in (("a", "one"), ("b", "one"), ("c", "two")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "data.txt").write_text(text)
    keys = [recipe_of(tmp_path, inputs={"before": tmp_path / name}).key for name in "abc"]
    assert keys[0] == keys[1] != keys[2]
    assert content_hash(tmp_path / "a", HashCache()) == content_hash(tmp_path / "b", HashCache())


def test_a_stage_without_files_of_the_package_has_none(tmp_path: Path) -> None:
    plain = Stage(
        name="read", summary="", inputs=(), parameters=Options, version=1, run=lambda context: None
    )
    assert external_files(plain, settings_for(plain, {}), tmp_path, HashCache()) == {}
