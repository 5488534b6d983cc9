# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.runner: one stage, run and committed."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from msgspec import Struct

from hullrecon.artifacts.manifest import read_manifest
from hullrecon.artifacts.runner import run_stage
from hullrecon.artifacts.stage import Context, Stage, load_arrays
from hullrecon.errors import InputError, StageError, StorageError

STOPPED = """
import os, signal, sys
from pathlib import Path
from msgspec import Struct
from hullrecon.artifacts.runner import run_stage
from hullrecon.artifacts.stage import Stage

class Options(Struct):
    pass

def run(context):
    import pycolmap

def stop(number, frame):
    print("stopped by SIGTERM", flush=True)

signal.signal(signal.SIGTERM, stop)
run_stage(Stage("make", "make", (), Options, 1, run), {}, {}, Path(sys.argv[1]))
os.kill(os.getpid(), signal.SIGTERM)
"""


class Options(Struct, frozen=True, kw_only=True):
    count: int = 2


def stage(run: Any, **more: Any) -> Stage:
    return Stage("make", "make", (), Options, 1, run, **more)


def test_artifact_has_a_manifest_of_all_files(tmp_path: Path) -> None:
    def run(context: Context) -> None:
        context.out.arrays("a.npz", {"x": np.full(context.parameters.count, 1.5)})
        context.warn("one beam was lost")

    out = run_stage(stage(run), {"make": Options(count=3)}, {}, tmp_path / "make")
    manifest = read_manifest(out)
    assert manifest is not None
    assert load_arrays(out / "a.npz")["x"].tolist() == [1.5, 1.5, 1.5]
    assert list(manifest.outputs) == ["a.npz"]
    assert manifest.outputs["a.npz"].size == (out / "a.npz").stat().st_size
    assert manifest.recipe.settings == {"make": {"count": 3}}
    assert manifest.warnings == ["one beam was lost"]
    assert manifest.key == manifest.recipe.key
    assert manifest.run.keys() == {
        "versions",
        "host",
        "started",
        "seconds",
        "cpu_seconds",
        "peak_rss_bytes",
        "workers_peak_rss_bytes",
    }
    assert sorted(os.listdir(tmp_path)) == ["make"]


def test_times_that_a_stage_tells_stand_in_the_run_block(tmp_path: Path) -> None:
    manifest = read_manifest(
        run_stage(
            stage(lambda c: c.record_times("iterations_s", [0.12345, 2])), {}, {}, tmp_path / "a"
        )
    )
    assert manifest is not None
    assert manifest.run["times"] == {"iterations_s": [0.123, 2.0]}
    assert "times" not in (manifest.recipe.settings | manifest.outputs)


def test_two_runs_differ_in_the_run_block_alone(
    toy: ModuleType, package: Path, tmp_path: Path
) -> None:
    first, second = (
        run_stage(toy.STAGES[0], {"scale": toy.Scale()}, {}, tmp_path / n, package)
        for n in ("one", "two")
    )
    documents = [json.loads((folder / "manifest.json").read_text()) for folder in (first, second)]
    for document in documents:
        del document["run"], document["seal"]
    assert documents[0] == documents[1]
    for name in documents[0]["outputs"]:
        assert (first / name).read_bytes() == (second / name).read_bytes()


def test_the_files_of_the_package_stand_in_the_manifest(
    toy: ModuleType, package: Path, tmp_path: Path
) -> None:
    manifest = read_manifest(
        run_stage(toy.STAGES[0], {"scale": toy.Scale()}, {}, tmp_path / "read", package)
    )
    assert manifest is not None
    assert {name: record.size for name, record in manifest.recipe.external.items()} == {
        "numbers.txt": 6
    }


def test_external_folder_is_in_the_manifest_file_by_file(tmp_path: Path) -> None:
    (tmp_path / "package" / "images").mkdir(parents=True)
    for name in ("b.jpg", "a.jpg"):
        (tmp_path / "package" / "images" / name).write_text(name)
    declared = stage(lambda context: None, external=lambda settings, source: [source / "images"])
    manifest = read_manifest(run_stage(declared, {}, {}, tmp_path / "out", tmp_path / "package"))
    assert manifest is not None
    assert list(manifest.recipe.external) == ["images/a.jpg", "images/b.jpg"]


def test_a_missing_file_of_the_package_is_named(
    toy: ModuleType, package: Path, tmp_path: Path
) -> None:
    (package / "numbers.txt").unlink()
    with pytest.raises(InputError, match=r"numbers\.txt is missing") as caught:
        run_stage(toy.STAGES[0], {"scale": toy.Scale()}, {}, tmp_path / "read", package)
    assert caught.value.exit_code == 3
    assert not (tmp_path / "read").exists()


def test_an_input_may_be_a_folder_made_by_hand(toy: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "read").mkdir()
    np.savez(tmp_path / "read" / "numbers.npz", x=np.array([2.0]))
    out = run_stage(
        toy.STAGES[1],
        {"left": toy.Options(power=3)},
        {"read": tmp_path / "read"},
        tmp_path / "left",
    )
    assert load_arrays(out / "side.npz")["x"].tolist() == [8.0]


def test_reading_the_package_without_declaring_it_is_a_fault(package: Path, tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="without declaring"):
        run_stage(stage(lambda context: context.source), {}, {}, tmp_path / "out", package)


def test_map_over_processes_keeps_order_and_records_memory(tmp_path: Path) -> None:
    def run(context: Context) -> None:
        context.out.json("a.json", context.map(abs, [-3, 2, -1], "absolute values"))

    out = run_stage(stage(run), {}, {}, tmp_path / "out", jobs=2)
    manifest = read_manifest(out)
    assert json.loads((out / "a.json").read_text()) == [3, 2, 1]
    assert manifest is not None
    assert manifest.run["workers_peak_rss_bytes"] > 5_000_000


def test_items_shown_as_progress_pass_unchanged(tmp_path: Path) -> None:
    def run(context: Context) -> None:
        context.out.json("a.json", list(context.progress(iter("ab"), "letters")))

    assert json.loads((run_stage(stage(run), {}, {}, tmp_path / "out") / "a.json").read_text()) == [
        "a",
        "b",
    ]


@pytest.mark.parametrize(
    ("raised", "expected", "words"),
    [
        (StageError("too few matches"), StageError, "too few matches"),
        (MemoryError(), StageError, "make ran out of memory"),
        (OSError(errno.ENOSPC, "No space left on device"), StorageError, "No space left"),
        (
            PermissionError(errno.EACCES, "denied", "/package/log.bag"),
            InputError,
            "may not read a file",
        ),
        (ZeroDivisionError("ours"), ZeroDivisionError, "ours"),
        (KeyboardInterrupt("by the user"), KeyboardInterrupt, "by the user"),
    ],
)
def test_whatever_fails_the_old_artifact_stays(
    raised: BaseException, expected: type[BaseException], words: str, tmp_path: Path
) -> None:
    def fail(context: Context) -> None:
        context.out.text("a.txt", "new")
        raise raised

    run_stage(stage(lambda context: context.out.text("a.txt", "old")), {}, {}, tmp_path / "out")
    with pytest.raises(expected, match=words):
        run_stage(stage(fail), {}, {}, tmp_path / "out")
    assert (tmp_path / "out" / "a.txt").read_text() == "old"
    assert os.listdir(tmp_path) == ["out"]


def test_sigterm_is_ours_after_pycolmap_was_imported(tmp_path: Path) -> None:
    pytest.importorskip("pycolmap")
    script = tmp_path / "script.py"
    script.write_text(STOPPED)
    answer = subprocess.run(
        [sys.executable, script, tmp_path / "out"], capture_output=True, text=True, check=False
    )
    assert (answer.returncode, answer.stdout) == (0, "stopped by SIGTERM\n"), answer.stderr
