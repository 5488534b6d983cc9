# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.plan: where each step stands, and why."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from hullrecon.artifacts.chain import assess_chain
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import UsageError

Look = Callable[..., dict[str, tuple[str, list[str]]]]


@pytest.fixture
def look(toy: ModuleType, package: Path, workspace: Workspace) -> Look:
    """State and reasons by step, for the toy chain with the sections given."""

    def look(**sections: object) -> dict[str, tuple[str, list[str]]]:
        standings = assess_chain(toy.chain(package, **sections), workspace, workspace.hashes())
        return {s.stage.name: (s.state, list(s.reasons)) for s in standings}

    return look


@pytest.fixture
def ran(toy: ModuleType, package: Path, workspace: Workspace) -> Workspace:
    toy.run(package, workspace)
    return workspace


def test_steps_that_wait_for_each_other_are_not_beside(toy: ModuleType, package: Path) -> None:
    assert toy.chain(package).pairs_beside() == [("left", "right")]


def test_before_the_first_run_everything_is_missing(look: Look, workspace: Workspace) -> None:
    assert look() == dict.fromkeys(("read", "left", "right", "join"), ("not run yet", []))
    assert not workspace.root.exists()


def test_after_a_run_everything_is_fresh(look: Look, ran: Workspace) -> None:
    assert look() == dict.fromkeys(("read", "left", "right", "join"), ("up to date", []))


def test_changed_option_makes_step_stale_and_later_ones_wait(
    look: Look, toy: ModuleType, ran: Workspace
) -> None:
    assert look(left=toy.Options(power=2)) == {
        "read": ("up to date", []),
        "left": ("out of date", ["option left.power changed from 1 to 2"]),
        "right": ("up to date", []),
        "join": ("out of date", ["input left will rerun"]),
    }


def test_a_changed_section_makes_all_that_read_it_stale(
    look: Look, toy: ModuleType, ran: Workspace
) -> None:
    seen = look(scale=toy.Scale(factor=2.0))
    assert seen["read"] == ("out of date", ["option scale.factor changed from 1.0 to 2.0"])
    assert seen["right"] == (
        "out of date",
        ["option scale.factor changed from 1.0 to 2.0", "input read will rerun"],
    )
    assert seen["left"] == ("out of date", ["input read will rerun"])


def test_a_changed_file_of_the_package_is_named(look: Look, package: Path, ran: Workspace) -> None:
    (package / "numbers.txt").write_text("4\n")
    assert look()["read"] == ("out of date", ["external file numbers.txt changed"])


def test_a_file_that_was_only_touched_is_fresh(look: Look, package: Path, ran: Workspace) -> None:
    (package / "numbers.txt").write_text("1\n2\n3\n")
    assert look()["read"] == ("up to date", [])


def test_an_altered_artifact_is_damaged_and_named(look: Look, ran: Workspace) -> None:
    (ran.root / "left" / "raw.bin").write_bytes(bytes(256))
    assert look()["left"] == ("damaged", ["raw.bin is altered"])
    (ran.root / "right" / "manifest.json").write_text("{}")
    assert look()["right"][0] == "damaged"


def test_a_step_that_does_not_apply_is_skipped_with_its_reason(
    look: Look, toy: ModuleType, ran: Workspace
) -> None:
    seen = look(scale=None, read=toy.Options())
    assert seen["right"] == ("skipped", ["no scale was given"])


def test_step_after_skipped_step_is_skipped_with_reason(toy: ModuleType, package: Path) -> None:
    chain = toy.chain(package, scale=None)
    needy = toy.Stage("needy", "needy", ("right",), toy.Options, 1, toy.join)
    needier = toy.Stage("needier", "needier", ("needy",), toy.Options, 1, toy.join)
    longer = toy.Chain((*chain.stages, needy, needier), chain.sections, package)
    assert longer.skip_reasons() == {
        "right": "no scale was given",
        "needy": "it needs right, which is skipped: no scale was given",
        "needier": "it needs needy, which is skipped: it needs right, which is skipped:"
        " no scale was given",
    }


def test_the_part_up_to_a_step_holds_what_it_needs_and_may_use(
    toy: ModuleType, package: Path
) -> None:
    names = {
        last: [s.name for s in toy.chain(package).up_to(last).stages]
        for last in ("read", "left", "join")
    }
    assert names == {
        "read": ["read"],
        "left": ["read", "left"],
        "join": ["read", "left", "right", "join"],
    }


def test_an_unknown_step_is_refused_with_the_nearest_or_all(toy: ModuleType, package: Path) -> None:
    with pytest.raises(UsageError, match="unknown step 'rihgt'; did you mean 'right'"):
        toy.chain(package).up_to("rihgt")
    with pytest.raises(
        UsageError, match="unknown step 'xyzzy': the steps are read, left, right, join"
    ):
        toy.chain(package).up_to("xyzzy")
