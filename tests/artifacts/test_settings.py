# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.settings: a stage sees what it declared and nothing else."""

from __future__ import annotations

import pytest
from msgspec import Struct

from hullrecon.artifacts.stage import Stage, flatten, resolve_settings, settings_for
from hullrecon.errors import UsageError


class Top(Struct, frozen=True):
    mount: tuple[float, float] = (1.0, 2.0)


class Camera(Struct, frozen=True):
    top: Top | None = None


class Options(Struct, frozen=True):
    size: float = 3.0


def stage(*uses: str) -> Stage:
    return Stage("find", "find", (), Options, 1, lambda context: None, uses=uses)


def test_the_stages_own_section_has_its_defaults_when_absent() -> None:
    assert settings_for(stage(), {})["find"] == Options(3.0)
    assert settings_for(stage(), {"find": None})["find"] == Options(3.0)
    assert settings_for(stage(), {"find": Options(4.0)})["find"] == Options(4.0)


@pytest.mark.parametrize("sections", [{"camera": Camera(Top())}, {"camera.top": Top()}])
def test_dotted_name_finds_nested_sections_and_keys(
    sections: dict[str, object],
) -> None:
    settings = settings_for(stage("camera.top", "camera.top.mount"), sections)
    assert settings["camera.top"] == Top()
    assert settings["camera.top.mount"] == (1.0, 2.0)


@pytest.mark.parametrize("sections", [{}, {"camera": Camera()}, {"camera.top": None}])
def test_what_is_absent_is_none(sections: dict[str, object]) -> None:
    settings = settings_for(stage("camera.top", "camera.top.mount"), sections)
    assert (settings["camera.top"], settings["camera.top.mount"]) == (None, None)


def test_a_key_that_no_section_has_is_a_fault_of_the_declaration() -> None:
    with pytest.raises(RuntimeError, match=r"camera\.top has no option mnt"):
        settings_for(stage("camera.top.mnt"), {"camera.top": Top()})


def test_undeclared_section_is_a_fault_even_with_get() -> None:
    settings = settings_for(stage("camera.top"), {"camera.top": Top(), "imu": Top()})
    with pytest.raises(RuntimeError, match="reads section 'imu'"):
        settings["imu"]
    with pytest.raises(RuntimeError, match="reads section 'imu'"):
        settings.get("imu")
    assert list(settings) == ["camera.top", "find"]


def test_resolved_settings_are_plain_values() -> None:
    settings = settings_for(stage("camera.top", "sonar"), {"camera.top": Top()})
    assert resolve_settings(settings) == {
        "camera.top": {"mount": [1.0, 2.0]},
        "sonar": None,
        "find": {"size": 3.0},
    }


def test_an_option_that_is_not_finite_is_named() -> None:
    with pytest.raises(UsageError, match=r"find\.size is nan"):
        resolve_settings(settings_for(stage(), {"find": Options(float("nan"))}))


def test_flatten_names_leaves_by_path_and_keeps_lists() -> None:
    assert flatten({"a": {"b": {"c": 1}, "d": [1, 2]}, "e": {}}) == {
        "a.b.c": 1,
        "a.d": [1, 2],
        "e": {},
    }
