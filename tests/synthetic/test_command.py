# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest

from hullrecon.errors import UsageError
from hullrecon.synthetic.command import BOUNDS, OPTIONS, simulate
from hullrecon.synthetic.spec import DiveSpec


def test_every_option_is_a_field_of_the_spec_with_its_default() -> None:
    defaults = {f.name: f.default for f in fields(DiveSpec)}
    for option in OPTIONS:
        assert defaults[option.field] == option.default
        assert option.name == option.field.replace("_", "-")
        assert option.help


def test_every_field_but_the_items_is_an_option() -> None:
    assert {option.field for option in OPTIONS} == {f.name for f in fields(DiveSpec)} - {"items"}


def test_bounds_hold_the_defaults() -> None:
    for option in OPTIONS:
        low, high = BOUNDS.get(option.field, (float("-inf"), float("inf")))
        assert isinstance(option.default, str | None) or low <= option.default <= high


def test_choices_hold_the_default() -> None:
    assert all(option.default in option.choices for option in OPTIONS if option.choices)


def test_simulate_writes_a_package_and_counts(tmp_path: Path) -> None:
    options = {"legs": 1, "leg_length_m": 0.8, "structures": 1, "marks": 0, "barnacles": 0, "cameras": "none", "sonar": False}
    counts = simulate(tmp_path / "dive", **options)
    assert (tmp_path / "dive" / "dive.toml").exists()
    assert counts["objects"] == 1
    assert counts["frames"] > 0
    assert counts["seconds"] == pytest.approx(0.8 / 0.3 + 2, abs=0.5)


def test_an_option_out_of_bounds_is_refused_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="legs is 0"):
        simulate(tmp_path / "dive", legs=0)
    assert not (tmp_path / "dive").exists()


def test_an_unknown_option_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="wings"):
        simulate(tmp_path / "dive", wings=2)
