# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.parts: what a step had finished when its run was killed is not made again, damaged
parts are, and the bytes are those of an undisturbed run.
"""

from __future__ import annotations

import errno
import hashlib
import os
import pickle
import re
import shutil
from collections.abc import Callable, Iterator, Sequence
from enum import IntEnum
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from msgspec import Struct
from numpy.typing import NDArray

from benchmarks.lasting_bytes import lasting_hashes
from hullrecon.artifacts import parts
from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.manifest import Recipe
from hullrecon.artifacts.parts import PartStore
from hullrecon.artifacts.runner import RunContext, run_chain
from hullrecon.artifacts.stage import Context, Stage
from hullrecon.artifacts.workspace import Workspace

WORDS = ("bow", "keel", "stern", "bilge", "rudder")
Array = NDArray[np.float64]


class Options(Struct, frozen=True, kw_only=True):
    factor: float = 2.0


class Killed(BaseException):
    """The process has died here."""


class Bench:
    """A dive of one step, whose items are the lines of a file; it counts what was computed."""

    def __init__(self, folder: Path) -> None:
        self.package, self.workspace = folder / "package", Workspace(folder / "runs" / "dive")
        self.package.mkdir(exist_ok=True)
        self.write(*WORDS)
        self.made: list[str] = []
        self.deaths: list[str] = []  # words at which the run is killed
        self.by_word = False  # an item depends on its word alone

    def write(self, *words: str) -> None:
        (self.package / "words.txt").write_text("\n".join(words))

    def measure(self, word: str, factor: float) -> Array:
        if word in self.deaths:
            raise Killed
        self.made.append(word)
        return np.asfortranarray(np.full((2, len(word)), factor))

    def _run(self, context: Context[Options]) -> None:
        words = (context.source / "words.txt").read_text().split()
        factor = context.parameters.factor
        depends: Callable[[str], object] | None = (lambda word: word) if self.by_word else None
        sizes = context.stream(
            lambda word: self.measure(word, factor), words, "words", depends=depends
        )
        context.out.arrays("sizes.npz", {f"{k}": size for k, size in enumerate(sizes)})

    def run(self, **options: bool | float) -> list[str]:
        """Run the step, and tell which words were computed."""
        self.made = []
        stage = Stage(
            "sizes",
            "measure words",
            (),
            Options,
            1,
            self._run,
            external=lambda settings, package: [package / "words.txt"],
        )
        factor = options.pop("factor", 2.0)
        chain = Chain((stage,), {"sizes": Options(factor=float(factor))}, self.package)
        run_context = RunContext(self.workspace.hashes(), Executor())
        run_chain(
            chain, self.workspace, run_context, from_scratch=bool(options.get("from_scratch"))
        )
        return self.made

    def run_killed_at(self, word: str) -> list[str]:
        """Run until the process dies at a word."""
        self.deaths = [word]
        with pytest.raises(Killed):
            self.run()
        self.deaths = []
        return self.made

    def store(self) -> PartStore:
        recipe = Recipe(stage="sizes", version=1, settings={})
        return PartStore(self.folder, recipe)

    @property
    def folder(self) -> Path:
        return self.workspace.parts_folder("sizes")

    def parts(self) -> list[Path]:
        return sorted(path for path in self.folder.rglob("*") if path.is_file())


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


def hashes(bench: Bench) -> dict[str, str]:
    return lasting_hashes(bench.workspace.root)


@pytest.fixture
def undisturbed(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "other").mkdir()
    other = Bench(tmp_path / "other")
    other.run()
    return hashes(other)


def test_what_was_finished_before_a_kill_is_not_made_again(
    bench: Bench, undisturbed: dict[str, str]
) -> None:
    assert bench.run_killed_at("stern") == ["bow", "keel"]
    assert bench.run_killed_at("rudder") == ["stern", "bilge"]
    assert bench.run() == ["rudder"]
    assert hashes(bench) == undisturbed
    assert not bench.folder.exists()


@pytest.mark.parametrize("damage", ["a bit", "its end", "all of it"])
def test_a_damaged_part_is_made_again(
    bench: Bench, undisturbed: dict[str, str], damage: str
) -> None:
    bench.run_killed_at("bilge")
    part = bench.parts()[1]
    data = bytearray(part.read_bytes())
    data[-3] ^= 4
    part.write_bytes({"a bit": bytes(data), "its end": data[:-5], "all of it": b""}[damage])
    assert len(bench.run()) == 3
    assert hashes(bench) == undisturbed


def test_parts_of_other_settings_are_removed(bench: Bench) -> None:
    bench.run_killed_at("stern")
    old = bench.parts()
    assert bench.run(factor=3.0) == list(WORDS)
    assert not any(path.exists() for path in old)


def test_a_changed_input_makes_all_parts_again(bench: Bench) -> None:
    bench.run_killed_at("rudder")
    bench.write("bow", "keel", "funnel", "bilge", "rudder")
    assert len(bench.run()) == 5


def test_a_part_serves_as_long_as_what_it_depends_on_is_the_same(bench: Bench) -> None:
    bench.by_word = True
    bench.run_killed_at("rudder")
    bench.write("bow", "keel", "funnel", "bilge", "rudder")
    assert bench.run() == ["funnel", "rudder"]


def test_from_scratch_takes_no_part(bench: Bench) -> None:
    bench.run_killed_at("rudder")
    assert bench.run(from_scratch=True) == list(WORDS)


def test_parts_that_outlived_their_step_go_with_the_next_run(bench: Bench) -> None:
    bench.run_killed_at("stern")
    kept = shutil.copytree(bench.folder, bench.package.parent / "kept")
    bench.run()
    shutil.copytree(kept, bench.folder)  # killed between the artifact and the end of its parts
    assert bench.run() == []
    assert not bench.folder.exists()


@pytest.mark.parametrize("how", ["little is free", "the disk is full"])
def test_a_disk_without_room_for_parts_has_room_for_the_step(
    bench: Bench,
    undisturbed: dict[str, str],
    how: str,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    bench.run_killed_at("stern")

    def refuse(path: Path, data: bytes) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    if how == "little is free":
        taken = sum(path.stat().st_size for path in bench.parts())
        monkeypatch.setattr(shutil, "disk_usage", lambda path: SimpleNamespace(free=taken))
    else:
        monkeypatch.setattr(parts, "replace_file", refuse)
    bench.run()
    assert hashes(bench) == undisturbed
    assert caplog.text.count("has no room to keep finished parts") == 1


def _twice(items: Sequence[object]) -> Iterator[object]:
    return iter(items)


def test_a_part_is_found_by_value_not_by_what_is_shared(bench: Bench) -> None:
    bench.run_killed_at("bow")
    store = bench.store()
    shared = np.arange(3.0)
    list(store.resume("pairs", [(shared, shared)], _twice)[1])
    assert store.resume("pairs", [(shared.copy(), shared.copy())], _twice)[0] == 1
    assert store.resume("pairs", [(shared.copy(), shared[::-1].copy())], _twice)[0] == 0


class Command:
    def __reduce__(self) -> tuple[Callable[..., object], tuple[str]]:
        return os.getenv, ("HOME",)


def test_what_is_no_data_is_not_kept(bench: Bench, caplog: pytest.LogCaptureFixture) -> None:
    store = bench.store()
    command = Command()
    assert list(store.resume("commands", ["x"], lambda items: iter([command]))[1]) == [command]
    assert re.search(r"a finished part cannot be kept: \w+.getenv is no data", caplog.text)
    assert not bench.folder.exists()


class Verdict(IntEnum):
    KEPT = 3

    def __reduce_ex__(self, protocol: object) -> tuple[Callable[..., object], tuple[object, str]]:
        return getattr, (Verdict, self.name)  # as every enumeration of Python 3.11.2 (Debian 12)


def test_a_member_of_an_enumeration_is_kept_by_any_python(bench: Bench) -> None:
    store = bench.store()
    list(store.resume("verdicts", ["x"], lambda items: iter([Verdict.KEPT]))[1])
    kept, results = store.resume("verdicts", ["x"], lambda items: iter([Verdict.KEPT]))
    assert (kept, list(results)) == (1, [Verdict.KEPT])


def test_a_forged_part_runs_nothing(bench: Bench) -> None:
    store = bench.store()
    list(store.resume("words", ["x"], lambda items: iter(["y"]))[1])
    (part,) = bench.parts()
    data = pickle.dumps(Command())
    part.write_bytes(hashlib.sha256(data).digest() + data)
    with pytest.raises(pickle.UnpicklingError, match="getenv is no data"):
        list(store.resume("words", ["x"], lambda items: iter(["y"]))[1])


def test_what_every_run_has_is_not_written_into_a_part(bench: Bench) -> None:
    store = bench.store()
    given = {"images": np.zeros(100_000)}

    def make(items: object) -> Iterator[object]:
        return iter([(given["images"], 5)])

    ((first, _),) = store.resume("stage", ["x"], make, given=given)[1]
    assert first is given["images"]
    assert sum(part.stat().st_size for part in bench.parts()) < 200
    given = {"images": np.ones(100_000)}
    nobody: list[Iterator[object]] = []  # nothing is left to be made
    ((again, number),) = store.resume("stage", ["x"], lambda _: nobody.pop(), given=given)[1]
    assert again is given["images"]
    assert number == 5
