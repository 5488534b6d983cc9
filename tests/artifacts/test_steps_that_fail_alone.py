# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A step that fails alone leaves the others and its reason; what an earlier run delivered never
looks like today's.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.runner import RunContext, StepOutcome, first_failure, run_chain
from hullrecon.artifacts.stage import Context, Stage
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import InputError, StageError, StorageError

REASON = "no result for a negative power: give a positive one"


def chain(toy: ModuleType, package: Path, **sections: object) -> Chain:
    """The toy chain with an optional step `right` that fails alone, and a step `more` that needs
    it.
    """

    def write_zero(context: Context) -> None:
        context.out.arrays("side.npz", {"x": np.zeros(1)})

    def join(context: Context) -> None:
        toy.join(context)
        context.out.json("deliver/failures.json", dict(context.failures))

    read, left, right, last = toy.STAGES
    more = Stage("more", "more", ("right",), toy.Options, 1, write_zero, fails_alone=True)
    last = replace(last, run=join, optional=("right", "more"))
    whole: Chain = toy.chain(package, **sections)
    return replace(whole, stages=(read, left, replace(right, fails_alone=True), more, last))


def run(chain: Chain, workspace: Workspace, *, keep_going: bool = True) -> list[StepOutcome]:
    return run_chain(
        chain, workspace, RunContext(workspace.hashes(), Executor()), keep_going=keep_going
    )


def delivered(workspace: Workspace, name: str) -> object:
    return json.loads((workspace.root / "deliver" / name).read_text())


@pytest.fixture
def failing(toy: ModuleType) -> dict[str, object]:
    return {"right": toy.Options(power=-1)}


@pytest.mark.parametrize("ran_before", [False, True])
def test_the_others_are_delivered_afresh_with_the_reason(
    ran_before: bool,
    toy: ModuleType,
    package: Path,
    workspace: Workspace,
    failing: dict[str, object],
) -> None:
    if ran_before:
        run(chain(toy, package), workspace)
        assert delivered(workspace, "failures.json") == {}
    outcomes = run(chain(toy, package, left=toy.Options(power=2), **failing), workspace)
    assert delivered(workspace, "total.json") == {"total": 14.0, "of": ["left"]}
    assert delivered(workspace, "failures.json") == {
        "right": REASON,
        "more": f"it needs right, which failed: {REASON}",
    }
    assert isinstance(first_failure(outcomes), StageError)
    assert [(o.before.stage.name, o.made) for o in outcomes][2:] == [
        ("right", False),
        ("more", False),
        ("join", True),
    ]


def test_the_same_failure_makes_nothing_again(
    toy: ModuleType, package: Path, workspace: Workspace, failing: dict[str, object]
) -> None:
    run(chain(toy, package, **failing), workspace)
    assert toy.made(run(chain(toy, package, **failing), workspace)) == []


def test_when_it_succeeds_again_all_that_could_use_it_reruns(
    toy: ModuleType, package: Path, workspace: Workspace, failing: dict[str, object]
) -> None:
    run(chain(toy, package, **failing), workspace)
    outcomes = run(chain(toy, package), workspace)
    assert toy.made(outcomes) == ["right", "more", "join"]
    assert outcomes[-1].before.reasons == (
        "input more is new", "input right is new", "it was made without more, which had failed",
        "it was made without right, which had failed",
    )  # fmt: skip
    assert delivered(workspace, "failures.json") == {}


def test_a_fault_of_ours_in_such_a_step_leaves_the_others_too(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    def divide(context: Context) -> None:
        raise ZeroDivisionError

    whole = chain(toy, package)
    stages = tuple(
        replace(stage, run=divide) if stage.name == "right" else stage for stage in whole.stages
    )
    failure = first_failure(run(replace(whole, stages=stages), workspace))
    assert isinstance(failure, ZeroDivisionError)
    failures = delivered(workspace, "failures.json")
    assert isinstance(failures, dict)
    assert failures["right"] == "internal error (ZeroDivisionError)"


@pytest.mark.parametrize(
    "error", [StorageError("full"), InputError("changed"), OSError(28, "full")]
)
def test_what_concerns_all_steps_ends_the_run(
    error: Exception, toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    def refuse(context: Context) -> None:
        raise error

    whole = chain(toy, package)
    stages = tuple(
        replace(stage, run=refuse) if stage.name == "right" else stage for stage in whole.stages
    )
    with pytest.raises(type(error) if not isinstance(error, OSError) else Exception):
        run(replace(whole, stages=stages), workspace)
    assert not (workspace.root / "join").exists()


def test_without_keeping_on_the_first_failure_ends_the_run(
    toy: ModuleType, package: Path, workspace: Workspace, failing: dict[str, object]
) -> None:
    with pytest.raises(StageError):
        run(chain(toy, package, **failing), workspace, keep_going=False)
    assert not (workspace.root / "join").exists()


def test_failed_run_withdraws_the_earlier_delivery(
    toy: ModuleType, package: Path, workspace: Workspace, caplog: pytest.LogCaptureFixture
) -> None:
    toy.run(package, workspace)
    with pytest.raises(StageError):
        toy.run(package, workspace, left=toy.Options(power=-1))
    assert not (workspace.root / "deliver").exists()
    aside = workspace.root / "deliver-out-of-date"
    assert json.loads((aside / "total.json").read_text())["total"] == 12.0
    assert f"what an earlier run delivered is in {aside} now" in caplog.text


def test_withdrawn_delivery_returns_when_right_again(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    toy.run(package, workspace)
    for power, total in ((1, 12.0), (2, 20.0)):
        with pytest.raises(StageError):
            toy.run(package, workspace, left=toy.Options(power=-1))
        toy.run(package, workspace, left=toy.Options(power=power))
        assert delivered(workspace, "total.json") == {"total": total, "of": ["left", "right"]}
        assert not (workspace.root / "deliver-out-of-date").exists()
        assert not (workspace.root / "quarantine").exists()


def test_recipe_without_failures_keeps_its_old_key(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    toy.run(package, workspace)
    manifest = workspace.manifest("join")
    assert manifest is not None
    assert "failures" not in manifest.recipe.content
    assert manifest.recipe.key == manifest.key
