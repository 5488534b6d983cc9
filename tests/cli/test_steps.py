# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""cli.steps: a command for each step, made from its declaration."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hullrecon_cli.commands.steps import command, fields, unwrap_type
from msgspec import inspect as types

from hullrecon.steps.chain import stages


def test_help_gives_words_bounds_and_default_of_each_option(program) -> None:
    text = " ".join(program("navigate", "--help").out.split())
    assert "Count the words." in text
    assert "--times INT how often the log is counted; at least 1, at most 9; default 1" in text
    assert "--margin-m FLOAT m, of nothing; above 0; default 0.5" in text
    assert "--end [badly|fault|never|well] default well" in text
    assert "--loud / --no-loud default false" in text
    assert "default [0.0, 1.0]" in text


def test_a_step_runs_itself_and_what_it_needs_with_its_options(
    program, package: Path, runs: Path
) -> None:
    answer = program(
        "navigate", package, "--runs", runs, "--times", "3", "--loud", "--span", "[1, 2]", "--json"
    )
    assert [step["name"] for step in json.loads(answer.out)["steps"]] == ["ingest", "navigate"]
    manifest = json.loads((runs / "toy" / "navigate" / "manifest.json").read_text())
    assert manifest["recipe"]["settings"]["navigate"] == {
        "end": "well", "loud": True, "margin_m": 0.5, "span": [1.0, 2.0], "times": 3,
    }  # fmt: skip
    assert manifest["warnings"] == ["the log is loud"]


def test_an_options_value_is_checked_as_in_dive_toml(program, package: Path, runs: Path) -> None:
    for arguments in (
        ["--times", "99"],
        ["--times", "many"],
        ["--margin-m", "0"],
        ["--end", "somehow"],
    ):
        answer = program("navigate", package, "--runs", runs, *arguments)
        assert answer.code == 2, arguments
        assert answer.err.count("\n") == 1


def test_a_switch_can_be_turned_off(program, package: Path, runs: Path) -> None:
    (package / "dive.toml").write_text(
        (package / "dive.toml").read_text() + "[navigate]\nloud = true\n"
    )
    program("navigate", package, "--runs", runs, "--no-loud")
    manifest = json.loads((runs / "toy" / "navigate" / "manifest.json").read_text())
    assert manifest["recipe"]["settings"]["navigate"]["loud"] is False


@pytest.mark.parametrize("stage", stages(), ids=lambda stage: stage.name)
def test_fields_of_steps_are_options_beside_the_common_ones(stage) -> None:
    flags = [
        flag
        for parameter in command(stage.name).params
        for flag in (*parameter.opts, *parameter.secondary_opts)
    ]
    assert len(flags) == len(set(flags))
    assert {f"--{field.name.replace('_', '-')}" for field in fields(stage)} <= set(flags)


UNITS = {"m", "m2", "s", "px", "deg", "share", "ratio", "sigmas", "chi2", "probability"}
SUFFIXES = {"_m": "m", "_s": "s", "_px": "px", "_deg": "deg", "_sigmas": "sigmas", "_chi2": "chi2"}


@pytest.mark.parametrize("stage", stages(), ids=lambda stage: stage.name)
def test_every_option_has_a_description_and_a_number_its_unit(stage) -> None:
    for field in fields(stage):
        inner, text = unwrap_type(field.type)
        assert text, f"{stage.name}.{field.name} has no description"
        assert not set(text.replace("(", " ").split()) & {"O", "METHODS", "Alg."}, (
            f"{field.name} cites a paper: {text}"
        )
        unit = text.partition(",")[0]
        if isinstance(inner, types.FloatType):
            assert unit in UNITS, f"{stage.name}.{field.name} has no unit: {text}"
        for suffix, expected in SUFFIXES.items():
            if field.name.endswith(suffix):
                assert unit == expected, f"{stage.name}.{field.name}: {text}"
