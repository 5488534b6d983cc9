# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pipelines/dive.mk: it runs what is new or out of date, in order, and says nothing when all is
well.
"""

from __future__ import annotations

import json
import os
import shutil
import time
from pathlib import Path

import pytest

from hullrecon.steps.chain import stages

WITHOUT_CAMERA = {"features", "matches", "mosaic-optical"}


@pytest.fixture(scope="module")
def make_dive(call, pipelines: Path, toy: Path):
    """Makes a dive in runs/ beside its package."""

    def make(package: Path, *more: object, runs: Path | None = None, **options: object):
        return call(
            "make",
            "-f",
            pipelines / "dive.mk",
            f"PACKAGE={package}",
            f"RUNS={runs or package.parent / 'runs'}",
            f"HULLRECON={toy / 'hullrecon'}",
            *more,
            **options,
        )

    return make


@pytest.fixture(scope="module")
def made_once(make_dive, make_package, toy: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a package, its run by four jobs, and a line for each step in `trace.txt`."""
    folder = tmp_path_factory.mktemp("made")
    package = make_package(folder / "package", "kestrel")
    # under `make test` an outer make's flags would print the folders it enters
    environment = {k: v for k, v in os.environ.items() if not k.startswith("MAKE")} | {
        "TOY_TRACE": str(folder / "trace.txt"),
        "TOY_STEPS": str(toy / "steps.json"),
    }
    first = make_dive(package, "-j", "4", env=environment)
    assert (first.returncode, first.stdout, first.stderr) == (0, "", "")
    return folder


@pytest.fixture
def made(made_once: Path, trace: Path, tmp_path: Path) -> Path:
    """A package that was made, in a folder of this test's own. All files keep their times."""
    shutil.copytree(made_once, tmp_path, dirs_exist_ok=True)
    return tmp_path / "package"


def downstream(name: str, present: set[str]) -> set[str]:
    """The step and all that takes it, by the steps' own declarations."""
    found = {name}
    for stage in stages():
        if stage.name in present and found & {*stage.inputs, *stage.optional}:
            found.add(stage.name)
    return found


def test_a_dive_is_made_step_by_step_and_then_left_alone(make_dive, made: Path, trace) -> None:
    ran = trace.read_text().split()
    assert len(ran) == len(set(ran))
    assert not WITHOUT_CAMERA & set(ran)
    assert (made.parent / "runs/kestrel/deliver/report.txt").exists()
    assert make_dive(made, "-q").returncode == 0
    assert make_dive(made, "-s").stdout == ""
    assert trace.read_text().split() == ran


def test_touched_dive_is_not_made_again(make_dive, made: Path, trace: Path) -> None:
    ran = trace.read_text()
    (made / "dive.toml").touch()
    assert make_dive(made, "-q").returncode == 1
    assert make_dive(made).returncode == 0
    assert make_dive(made, "-q").returncode == 0
    assert trace.read_text() == ran


def test_a_changed_option_makes_its_step_and_what_takes_it(
    make_dive, made: Path, trace: Path
) -> None:
    ran = trace.read_text().split()
    (made / "dive.toml").write_text((made / "dive.toml").read_text() + "[surface]\nfactor = 2\n")
    make_dive(made)
    again = trace.read_text().split()[len(ran) :]
    assert sorted(again) == sorted(downstream("surface", set(ran)))


def test_the_rules_are_those_that_the_steps_declare(
    make_dive, make_package, call, program: Path, tmp_path: Path
) -> None:
    """The program is asked once for its status; manifests are all that make looks at besides."""
    package = make_package(tmp_path / "package", "kestrel", camera=True)
    run = tmp_path / "runs" / "kestrel"
    status = call(program, "--json", "status", package, "--runs", run.parent).stdout
    asked = tmp_path / "asked"
    asked.write_text(f"#!/bin/sh\ncat <<end\n{status}end\n")
    asked.chmod(0o755)
    made = {step["name"] for step in json.loads(status)["steps"] if step["state"] != "skipped"}
    assert {"features", "matches"} <= made
    for name in made:
        (run / name).mkdir(parents=True)
        (run / name / "manifest.json").touch()
    for name in sorted(made):
        now = time.time_ns()
        for step in made:
            os.utime(run / step / "manifest.json", ns=(now, now + (10**9 if step == name else 0)))
        said = make_dive(package, "-n", f"HULLRECON={asked}").stdout
        planned = {line.split()[2] for line in said.splitlines() if " --quiet " in line}
        assert planned == downstream(name, made) - {name}, name


def test_a_folder_without_dive_toml_is_refused(make_dive, tmp_path: Path) -> None:
    answer = make_dive(tmp_path)
    assert answer.returncode == 2
    assert "is no dive package" in answer.stderr


def test_a_dives_folder_and_files_may_have_any_names(
    make_dive, make_package, trace: Path, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "port side $(shell touch here) 'a' #1", "kestrel")
    (package / "notes: 50 % $(shell touch here).txt").write_text("x")
    first = make_dive(package)
    assert (first.returncode, first.stdout, first.stderr) == (0, "", "")
    assert (tmp_path / "runs/kestrel/deliver/report.txt").exists()
    assert not list(Path.cwd().glob("here"))
    assert make_dive(package, "-q").returncode == 0


def test_a_new_file_of_the_package_makes_ingest_look_again(
    make_dive, made: Path, trace: Path
) -> None:
    ran = trace.read_text().split()
    (made / "log.mcap").write_bytes(b"another log")
    assert make_dive(made).returncode == 0
    assert trace.read_text().split()[len(ran) :][0] == "ingest"
    assert make_dive(made, "-q").returncode == 0


def test_an_earlier_dive_that_was_rerun_makes_change_look_again(
    make_dive, made: Path, trace: Path, tmp_path: Path
) -> None:
    ran = trace.read_text().split()
    (tmp_path / "earlier.txt").write_text("another run")
    assert make_dive(made, "-q").returncode == 1
    assert make_dive(made).returncode == 0
    assert trace.read_text().split()[len(ran) :] == ["change", "report"]
    assert make_dive(made, "-q").returncode == 0


def test_a_folder_of_runs_with_spaces_is_refused_by_its_name(
    make_dive, make_package, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "package", "kestrel")
    answer = make_dive(package, runs=tmp_path / "all runs")
    assert answer.returncode == 2
    assert "all runs has spaces" in answer.stderr
