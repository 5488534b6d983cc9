# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.chain: a run makes what is stale and nothing else."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from types import ModuleType

import pytest

from hullrecon.artifacts.chain import StepStatus
from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.runner import RunContext, run_chain
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import LockedError, StageError, StorageError


def times(workspace: Workspace) -> dict[Path, int]:
    """When each file was last written; the lock names its holder, so that one is."""
    return {
        path: path.stat().st_mtime_ns
        for path in workspace.root.rglob("*")
        if path.is_file() and path.name != "lock"
    }


def total(workspace: Workspace) -> object:
    return json.loads((workspace.root / "deliver" / "total.json").read_text())


def test_a_run_makes_everything_and_shows_the_deliverables(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    assert toy.made(toy.run(package, workspace)) == ["read", "left", "right", "join"]
    assert total(workspace) == {"total": 12.0, "of": ["left", "right"]}


def test_a_second_run_makes_nothing_and_changes_no_file(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    toy.run(package, workspace)
    before = times(workspace)
    assert toy.made(toy.run(package, workspace)) == []
    assert times(workspace) == before


@pytest.mark.parametrize(
    ("section", "option", "made"),
    [
        ("scale", {"factor": 2.0}, ["read", "left", "right", "join"]),
        ("scale", {"offset": 1.0}, ["read", "left", "right", "join"]),
        ("read", {"power": 2}, ["read", "left", "right", "join"]),
        ("read", {"pause_s": 0.01}, ["read", "left", "right", "join"]),
        ("left", {"power": 2}, ["left", "join"]),
        ("left", {"pause_s": 0.01}, ["left", "join"]),
        ("right", {"power": 2}, ["right", "join"]),
        ("right", {"pause_s": 0.01}, ["right", "join"]),
        ("join", {"power": 2}, ["join"]),
        ("join", {"pause_s": 0.01}, ["join"]),
    ],
)
def test_an_option_reruns_exactly_what_depends_on_it(
    section: str,
    option: dict[str, float],
    made: list[str],
    toy: ModuleType,
    package: Path,
    workspace: Workspace,
) -> None:
    toy.run(package, workspace)
    kind = toy.Scale if section == "scale" else toy.Options
    assert toy.made(toy.run(package, workspace, **{section: kind(**option)})) == made


def test_damaged_artifact_alone_is_made_anew(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    toy.run(package, workspace)
    whole = (workspace.root / "left" / "raw.bin").read_bytes()
    (workspace.root / "left" / "raw.bin").write_bytes(b"damaged")
    assert toy.made(toy.run(package, workspace)) == ["left"]
    assert (workspace.root / "left" / "raw.bin").read_bytes() == whole
    assert (workspace.root / "quarantine" / "left-1" / "raw.bin").read_bytes() == b"damaged"


def test_a_removed_artifact_is_made_anew_and_nothing_after_it(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    toy.run(package, workspace)
    workspace.remove("read")
    assert toy.made(toy.run(package, workspace)) == ["read"]


def test_from_scratch_makes_everything_with_the_same_content(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    before = [o.manifest.content_hash for o in toy.run(package, workspace)]
    again = toy.run(package, workspace, from_scratch=True)
    assert toy.made(again) == ["read", "left", "right", "join"]
    assert [o.manifest.content_hash for o in again] == before


def test_a_skipped_step_is_absent_from_what_uses_it(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    toy.run(package, workspace)
    chain = toy.chain(package, scale=None)
    stages = (
        toy.Stage(
            "read",
            "read",
            (),
            toy.Options,
            1,
            lambda c: c.out.arrays("numbers.npz", {"x": toy.np.ones(1)}),
        ),
        *chain.stages[1:],
    )
    outcomes = run_chain(
        toy.Chain(stages, chain.sections, package),
        workspace,
        RunContext(workspace.hashes(), Executor()),
    )
    assert [o.before.state for o in outcomes if o.before.stage.name == "right"] == ["skipped"]
    assert total(workspace) == {"total": 1.0, "of": ["left"]}
    assert outcomes[-1].manifest is not None
    assert outcomes[-1].manifest.warnings == ["the right side is missing"]
    assert outcomes[-1].before.reasons == ("input left changed", "input right is gone")


def test_a_step_without_result_keeps_what_was_finished(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    with pytest.raises(StageError, match="no result for a negative power"):
        toy.run(package, workspace, right=toy.Options(power=-1))
    assert toy.made(toy.run(package, workspace)) == ["right", "join"]


def test_a_run_beside_another_is_refused_and_changes_nothing(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    toy.run(package, workspace)
    with workspace.lock(), pytest.raises(LockedError):
        toy.run(package, workspace, left=toy.Options(power=2))
    assert total(workspace) == {"total": 12.0, "of": ["left", "right"]}


@pytest.mark.parametrize("again", [True, False], ids=["run again", "removed"])
def test_a_run_whose_folder_was_removed_ends_in_one_line(
    toy: ModuleType, package: Path, workspace: Workspace, again: bool
) -> None:
    def remove(_: list[StepStatus]) -> None:
        shutil.rmtree(workspace.root)
        if again:
            toy.run(package, workspace)

    lost = RunContext(workspace.hashes(), Executor())
    with pytest.raises(StorageError, match="removed while it was worked on"):
        run_chain(toy.chain(package), workspace, lost, preflight=remove)
    assert workspace.root.exists() == again  # nothing left behind, nothing of the other's touched
    assert len(toy.made(toy.run(package, workspace))) == (0 if again else 4)


def test_preflight_sees_the_plan_and_may_end_the_run(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    seen: list[str] = []

    def refuse(plan: list[StepStatus]) -> None:
        seen.extend(status.state for status in plan)
        raise StorageError("too little space")

    with pytest.raises(StorageError):
        run_chain(
            toy.chain(package),
            workspace,
            RunContext(workspace.hashes(), Executor()),
            preflight=refuse,
        )
    assert seen == ["not run yet"] * 4
    assert not (workspace.root / "read").exists()


def test_a_read_only_place_ends_with_the_folder_named(
    toy: ModuleType, package: Path, read_only_folder: Path
) -> None:
    with pytest.raises(StorageError, match=str(read_only_folder)):
        toy.run(package, Workspace(read_only_folder / "dive"))


def test_read_data_finds_a_flip_behind_an_old_time(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    toy.run(package, workspace)
    path = workspace.root / "left" / "raw.bin"
    status = path.stat()
    path.write_bytes(bytes(256))
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert toy.made(toy.run(package, workspace)) == []
    run_context = RunContext(workspace.hashes(trusting=False), Executor())
    assert toy.made(run_chain(toy.chain(package), workspace, run_context)) == ["left"]
