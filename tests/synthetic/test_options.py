# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import pytest

from hullrecon.errors import UsageError
from hullrecon.synthetic.options import (
    Cameras,
    DeviationField,
    DiveSpec,
    InitialHullPose,
    Items,
    Positions,
    SensorErrors,
    Ship,
    Survey,
    options,
    spec_from,
    with_options,
)


def test_every_described_field_is_option_under_name_of_its_own() -> None:
    names = [option.name for option in options()]
    assert len(names) == len(set(names)) == 50
    assert {
        "legs",
        "cameras",
        "deviation_mean_m",
        "guess_along_m",
        "heading_drift_deg_per_hour",
        "seed",
    } <= set(names)


def test_options_carry_their_defaults_and_descriptions() -> None:
    for option in options():
        where = getattr(DiveSpec(), option.part) if option.part else DiveSpec()
        assert getattr(where, option.field) == option.default
        assert option.meta.description[0].isupper() or option.meta.description[0] == "`"


def test_name_ends_in_its_unit() -> None:
    endings = {
        "m": "_m",
        "m/s": "_m_per_s",
        "deg": "_deg",
        "deg/h": "_deg_per_hour",
        "px": ("_width", "_height", "_px"),
        "s": "_s",
    }
    for option in options():
        if option.meta.unit:
            assert option.name.endswith(endings[option.meta.unit])
        else:
            assert not option.name.endswith(("_m", "_deg", "_s", "_hour"))


def test_every_number_has_bounds() -> None:
    for option in options():
        if isinstance(option.default, int | float) and not isinstance(option.default, bool):
            assert option.meta.low > -1e6
            assert option.meta.bounds()


def test_flat_names_reach_their_records() -> None:
    spec = spec_from(
        seed=4,
        legs=2,
        cameras="mono",
        deviation_mean_m=0.01,
        guess_turn_deg=5.0,
        backlash_deg=0.1,
        marks=0,
        beam_m=12.0,
        position_every_s=2.0,
    )
    assert spec == DiveSpec(
        seed=4,
        survey=Survey(legs=2),
        cameras=Cameras(carried="mono"),
        deviation=DeviationField(mean_m=0.01),
        guess=InitialHullPose(turn_deg=5.0),
        errors=SensorErrors(backlash_deg=0.1),
        items=Items(marks=0),
        ship=Ship(beam_m=12.0),
        positions=Positions(every_s=2.0),
    )


def test_changing_one_option_keeps_others() -> None:
    spec = with_options(spec_from(legs=2, leg_length_m=3.0, seed=9), leg_length_m=4.0)
    assert spec == spec_from(legs=2, leg_length_m=4.0, seed=9)


def test_unknown_option_is_refused() -> None:
    with pytest.raises(UsageError, match="unknown option wings"):
        spec_from(wings=2)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("legs", 0, "legs is 0: choose 1 to 200"),
        ("leg_length_m", 501.0, "leg_length_m is 501.0: choose 0.5 to 500 m"),
        ("leg_length_m", float("nan"), "leg_length_m is nan"),
        ("deviation_sigma_m", -0.1, "deviation_sigma_m is -0.1: choose 0 to 0.2 m"),
        ("guess_turn_deg", 181.0, "guess_turn_deg is 181.0"),
        ("dvl_scale_error", 0.2, "dvl_scale_error is 0.2: choose -0.1 to 0.1"),
        ("seed", -1, "seed is -1: choose at least 0"),
        ("form", "csv", "form is 'csv': choose one of mcap, plain"),
    ],
)
def test_value_out_of_bounds_is_refused_with_bounds(name: str, value: object, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        spec_from(**{name: value})


def test_records_check_themselves_without_flat_names() -> None:
    with pytest.raises(UsageError, match="image_width is 10"):
        Cameras(image_width=10)


def test_absent_middle_of_legs_is_within_bounds() -> None:
    assert Survey(along_m=None).along_m is None


def test_each_purpose_has_random_numbers_of_its_own() -> None:
    spec = DiveSpec()
    first, again, other = (spec.random(purpose).random(4).tolist() for purpose in ("a", "a", "b"))
    assert first == again
    assert first != other
    assert DiveSpec(seed=2).random("a").random(4).tolist() != first


def test_what_belongs_to_hull_is_drawn_from_hulls_seed() -> None:
    first, second = DiveSpec(seed=3), DiveSpec(seed=4, hull_seed=3)
    assert (
        first.hull_random("steel").random(3).tolist()
        == second.hull_random("steel").random(3).tolist()
    )
    assert first.random("dvl").random(3).tolist() != second.random("dvl").random(3).tolist()


def test_seed_that_may_be_absent_is_whole_number() -> None:
    (option,) = (option for option in options() if option.name == "hull_seed")
    assert option.kind is int
    assert option.default is None


@pytest.mark.parametrize(
    "name", ["bad name/x", "", ".dive", "-dive", "dive\n", "d\u00efve", "x" * 101]
)
def test_name_that_no_command_accepts_is_refused(name: str) -> None:
    with pytest.raises(
        UsageError, match=r"name is '.*': choose up to 100 ASCII letters"
    ) as refused:
        spec_from(name=name)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["x" * 100, "_dive", "2026-05.Dive_3"])
def test_name_of_dive_toml_is_taken(name: str) -> None:
    assert spec_from(name=name).name == name
