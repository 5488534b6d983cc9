# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.stage: typed reading of what a step declared."""

from __future__ import annotations

import pytest

from hullrecon.artifacts.stage import StageSettings, resolve_settings
from hullrecon.errors import UsageError

SETTINGS = StageSettings(
    "find", {"imu.frame": "ned", "tray": None, "dvl.sigma_range": 1, "dvl.mount": (0.0, 1.0)}
)


def test_a_value_is_read_with_its_type() -> None:
    assert SETTINGS.read("imu.frame", str) == "ned"
    assert SETTINGS.read("dvl.mount", tuple) == (0.0, 1.0)


def test_a_number_that_is_not_finite_is_refused_until_it_is() -> None:
    with pytest.raises(UsageError, match=r"option a.b is nan .*: give a finite number"):
        resolve_settings({"a": {"b": float("nan")}})
    assert resolve_settings({"a": {"b": 1.0}}) == {"a": {"b": 1.0}}


def test_whole_number_is_read_as_float() -> None:
    value = SETTINGS.read("dvl.sigma_range", float)
    assert (value, type(value)) == (1.0, float)


def test_a_value_of_another_type_is_refused_by_its_name() -> None:
    with pytest.raises(TypeError, match=r"setting imu\.frame is 'ned', where float is expected"):
        SETTINGS.read("imu.frame", float)


def test_an_absent_section_is_none_only_where_it_may_be() -> None:
    assert SETTINGS.read_optional("tray", tuple) is None
    assert SETTINGS.read_optional("imu.frame", str) == "ned"
    with pytest.raises(TypeError, match="setting tray is None"):
        SETTINGS.read("tray", tuple)
    with pytest.raises(TypeError, match=r"imu\.frame"):
        SETTINGS.read_optional("imu.frame", tuple)


def test_what_the_step_did_not_declare_can_not_be_read() -> None:
    with pytest.raises(
        RuntimeError, match="step find reads section 'hull' without naming it in its `uses`"
    ):
        SETTINGS.read_optional("hull", str)


def test_settings_are_a_mapping_of_what_was_declared() -> None:
    assert set(SETTINGS) == {"imu.frame", "tray", "dvl.sigma_range", "dvl.mount"}
    assert len(SETTINGS) == 4
