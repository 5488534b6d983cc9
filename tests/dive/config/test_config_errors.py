# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from datetime import date

import msgspec
import pytest

from hullrecon.dive.config.config_errors import explain_error, known_keys, refuse_not_finite
from hullrecon.dive.config.schema import DiveConfig
from hullrecon.errors import UsageError
from hullrecon.vision.options import MatchOptions


def told(raw: dict, kind: type = DiveConfig, prefix: str = "", more: tuple[str, ...] = ()) -> str:
    with pytest.raises(msgspec.ValidationError) as caught:
        msgspec.convert(raw, kind)
    return explain_error(str(caught.value), raw, kind, prefix, more, "dive.toml").line()


PLAIN = {"dive": {"name": "x"}, "logs": {"files": ["l"]}}


def test_every_key_of_the_vehicle_is_known_by_its_dotted_name():
    keys = set(known_keys(DiveConfig))
    assert {
        "dive",
        "dive.name",
        "camera.top.sigma_px",
        "hull.deviation_length",
        "topics.camera_bottom",
    } <= keys
    assert not any(key.startswith("top.") for key in keys)


def test_key_in_wrong_section_suggests_the_right_section():
    assert told(PLAIN | {"tray": {"elevation_deg": 3}}) == (
        "unknown key tray.elevation_deg (dive.toml): the nearest known key is sonar.elevation_deg"
    )


def test_unknown_section_suggests_nearest_step_section():
    assert told(PLAIN | {"feature": {}}, more=("features",)).endswith(
        "the nearest known key is features"
    )


def test_a_step_section_has_its_name_in_front():
    class Step(msgspec.Struct, forbid_unknown_fields=True):
        clahe: float = 3.0

    assert told({"clahee": 1}, Step, "features").startswith(
        "unknown key features.clahee (dive.toml)"
    )
    assert (
        told({"clahe": "x"}, Step, "features")
        == "features.clahe = 'x': expected a number, got text (dive.toml)"
    )


@pytest.mark.parametrize(
    ("raw", "line"),
    [
        (
            {"dive": {"name": "dive 1"}},
            "dive.name = 'dive 1': expected letters A to Z, digits and _, and behind the "
            "first also . and - (dive.toml)",
        ),
        (
            {"dive": {"name": "x", "date": date(2026, 5, 4)}},
            "dive.date = 2026-05-04: expected a date and time such as 2026-05-04T09:30:00Z "
            "(dive.toml)",
        ),
        (
            {"dvl": {"mount": "0 0 0 0 90 0"}},
            "dvl.mount = '0 0 0 0 90 0': expected a list of numbers or \"tf_static\" (dive.toml)",
        ),
        (
            {"hull": {"mesh": "x.stl", "pose_sigma": 1.0}},
            "hull.pose_sigma = 1.0: expected a list, got a number (dive.toml)",
        ),
    ],
)
def test_what_a_key_takes_is_said_in_the_words_of_toml(raw, line):
    assert told(PLAIN | raw) == line


def test_a_key_that_is_gone_is_to_be_deleted():
    for key in ("across", "revisits"):
        line = told({key: 3}, MatchOptions, "matches")
        assert line.startswith(f"the key matches.{key} is gone: images are compared")
        assert line.endswith("delete it")


def test_a_missing_key_has_its_section_in_front():
    assert (
        told({"dive": {"name": "x"}, "logs": {}})
        == "logs.files is missing (dive.toml): this key has no default"
    )
    assert told({"dive": {"name": "x"}}).startswith("logs is missing")


def test_a_long_value_is_shown_in_part():
    line = told(PLAIN | {"dvl": {"mount": list(range(100))}})
    assert "..." in line
    assert len(line) < 160


def test_a_table_in_place_of_a_value_is_called_a_table():
    assert "imu.sigma_roll_pitch_deg = a table: expected a number" in told(
        PLAIN | {"imu": {"sigma_roll_pitch_deg": {"a": 1}}}
    )


@pytest.mark.parametrize(
    ("raw", "path"),
    [
        ({"a": float("nan")}, "a"),
        ({"a": {"b": [1, float("inf")]}}, r"a\.b\[1\]"),
        ({"a": [[-float("inf")]]}, ""),
    ],
)
def test_nonfinite_numbers_are_refused_at_any_depth(raw, path):
    with pytest.raises(UsageError, match=f"{path}.* = .*: expected a finite number"):
        refuse_not_finite(raw, "dive.toml")


def test_strings_that_look_nonfinite_are_accepted():
    raw = {"a": [1, 2.5, "nan"], "b": {"c": True, "d": "inf"}}
    refuse_not_finite(raw, "dive.toml")
    raw["b"]["d"] = float("inf")
    with pytest.raises(UsageError, match=r"b\.d"):  # of all of them this one alone
        refuse_not_finite(raw, "dive.toml")
