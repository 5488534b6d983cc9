# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.source_watch: a package that changes while it is read ends the run, and nothing mixed
is delivered.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.manifest import hash_file
from hullrecon.artifacts.runner import RunContext, run_chain
from hullrecon.artifacts.stage import Context, Stage
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import InputError

Change = Callable[[Path], None]


def append(package: Path) -> None:
    with (package / "numbers.txt").open("a") as file:
        file.write("4\n")


def rewrite_in_place(package: Path) -> None:
    """Another content of the same size, with its time set back."""
    path = package / "numbers.txt"
    status = path.stat()
    path.write_text("9\n2\n3\n")
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def replace_file(package: Path) -> None:
    (package / "new").write_text("9\n2\n3\n")
    os.replace(package / "new", package / "numbers.txt")


def remove(package: Path) -> None:
    (package / "numbers.txt").unlink()


def run(chain: Chain, workspace: Workspace) -> None:
    run_chain(chain, workspace, RunContext(workspace.hashes(), Executor()))


def changing(toy: ModuleType, package: Path, step: str, change: Change) -> Chain:
    """The toy chain, whose package is changed at the end of a step's function."""
    chain: Chain = toy.chain(package)

    def with_change(stage: Stage) -> Stage:
        def changed(context: Context) -> None:
            stage.run(context)
            change(package)

        return replace(stage, run=changed) if stage.name == step else stage

    return replace(chain, stages=tuple(map(with_change, chain.stages)))


@pytest.mark.parametrize("change", [append, rewrite_in_place, replace_file, remove])
@pytest.mark.parametrize("step", ["read", "left", "join"])
def test_package_changed_during_run_delivers_nothing(
    step: str, change: Change, toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    with pytest.raises(InputError, match=r"numbers\.txt") as caught:
        run(changing(toy, package, step, change), workspace)
    assert caught.value.exit_code == 3
    assert "\n" not in caught.value.line()
    assert not (workspace.root / "deliver").exists()
    assert not (workspace.root / step).exists()


def test_the_next_run_reads_the_changed_package_as_a_whole(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    with pytest.raises(InputError):
        run(changing(toy, package, "left", append), workspace)
    assert toy.made(toy.run(package, workspace)) == ["read", "left", "right", "join"]


def test_step_does_not_begin_on_a_changed_file(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    chain = toy.chain(package)
    again = Stage(
        "again", "again", ("read",), toy.Options, 1, lambda context: append(context.source),
        external=lambda settings, source: [source / "numbers.txt"],
    )  # fmt: skip
    with pytest.raises(
        InputError, match=r"numbers.txt changed during the run \(.*package\): nothing was delivered"
    ):
        run(replace(chain, stages=(*chain.stages[:3], again, chain.stages[3])), workspace)
    assert not (workspace.root / "again").exists()


def test_a_file_that_comes_into_a_folder_that_is_read_counts(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    (package / "logs").mkdir()
    (package / "logs" / "one.txt").touch()

    def read(context: Context) -> None:
        toy.read(context)
        (package / "logs" / "two.txt").touch()

    names = [package / "numbers.txt", package / "logs"]
    stage = replace(toy.STAGES[0], run=read, external=lambda settings, source: names)
    with pytest.raises(InputError, match=r"logs/two.txt changed during the run"):
        run(replace(toy.chain(package), stages=(stage,)), workspace)


def test_a_configuration_that_changes_during_a_run_ends_it_too(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    path = package / "dive.toml"
    path.write_text("before")
    chain = changing(toy, package, "left", lambda folder: path.write_text("after") and None)
    with pytest.raises(InputError, match=r"dive\.toml changed during the run"):
        run(replace(chain, read_before={"dive.toml": hash_file(path)}), workspace)


def test_a_file_that_was_only_touched_has_not_changed(
    toy: ModuleType, package: Path, workspace: Workspace
) -> None:
    run(changing(toy, package, "left", lambda folder: os.utime(folder / "numbers.txt")), workspace)
    assert (workspace.root / "deliver" / "total.json").exists()
