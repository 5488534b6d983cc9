# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pipelines/dive.mk: it runs what is new or out of date, in order, and says nothing when all is
well.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from hullrecon.steps.chain import stages

WITHOUT_CAMERA = {"features", "matches", "mosaic-optical"}


@pytest.fixture
def make_dive(call, pipelines: Path, program: Path, tmp_path: Path):
    def make(package: Path, *more: object):
        return call(
            "make",
            "-f",
            pipelines / "dive.mk",
            f"PACKAGE={package}",
            f"RUNS={tmp_path / 'runs'}",
            f"HULLRECON={program}",
            *more,
        )

    return make


def downstream(name: str, present: set[str]) -> set[str]:
    """The step and all that takes it, by the steps' own declarations."""
    found = {name}
    for stage in stages():
        if stage.name in present and found & {*stage.inputs, *stage.optional}:
            found.add(stage.name)
    return found


def test_a_dive_is_made_step_by_step_and_then_left_alone(
    make_dive, make_package, trace: Path, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "package", "kestrel")
    first = make_dive(package, "-j", "4")
    assert (first.returncode, first.stdout, first.stderr) == (0, "", "")
    ran = trace.read_text().split()
    assert len(ran) == len(set(ran))
    assert not WITHOUT_CAMERA & set(ran)
    assert (tmp_path / "runs/kestrel/deliver/report.txt").exists()
    assert make_dive(package, "-q").returncode == 0
    assert make_dive(package, "-s").stdout == ""
    assert trace.read_text().split() == ran


def test_touched_dive_is_not_made_again(
    make_dive, make_package, trace: Path, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "package", "kestrel")
    make_dive(package)
    ran = trace.read_text()
    (package / "dive.toml").touch()
    assert make_dive(package, "-q").returncode == 1
    assert make_dive(package).returncode == 0
    assert make_dive(package, "-q").returncode == 0
    assert trace.read_text() == ran


def test_a_changed_option_makes_its_step_and_what_takes_it(
    make_dive, make_package, trace: Path, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "package", "kestrel")
    make_dive(package)
    ran = trace.read_text().split()
    (package / "dive.toml").write_text(
        (package / "dive.toml").read_text() + "[surface]\nfactor = 2\n"
    )
    make_dive(package)
    again = trace.read_text().split()[len(ran) :]
    assert sorted(again) == sorted(downstream("surface", set(ran)))


def test_the_rules_are_those_that_the_steps_declare(
    make_dive, make_package, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "package", "kestrel", camera=True)
    assert make_dive(package).returncode == 0
    run = tmp_path / "runs" / "kestrel"
    made = {path.parent.name for path in run.glob("*/manifest.json")}
    assert {"features", "matches"} <= made
    for name in sorted(made):
        now = time.time_ns()
        for step in made:
            os.utime(run / step / "manifest.json", ns=(now, now + (10**9 if step == name else 0)))
        said = make_dive(package, "-n").stdout
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
    make_dive, make_package, trace: Path, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "package", "kestrel")
    make_dive(package)
    ran = trace.read_text().split()
    (package / "log.mcap").write_bytes(b"another log")
    assert make_dive(package).returncode == 0
    assert trace.read_text().split()[len(ran) :][0] == "ingest"
    assert make_dive(package, "-q").returncode == 0


def test_an_earlier_dive_that_was_rerun_makes_change_look_again(
    make_dive, make_package, trace: Path, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "package", "kestrel")
    make_dive(package)
    ran = trace.read_text().split()
    (tmp_path / "earlier.txt").write_text("another run")
    assert make_dive(package, "-q").returncode == 1
    assert make_dive(package).returncode == 0
    assert trace.read_text().split()[len(ran) :] == ["change", "report"]
    assert make_dive(package, "-q").returncode == 0


def test_a_folder_of_runs_with_spaces_is_refused_by_its_name(
    make_dive, make_package, tmp_path: Path
) -> None:
    answer = make_dive(make_package(tmp_path / "package", "kestrel"), f"RUNS={tmp_path}/all runs")
    assert answer.returncode == 2
    assert "all runs has spaces" in answer.stderr
