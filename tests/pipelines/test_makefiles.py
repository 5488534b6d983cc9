# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pipelines/dive.mk and fleet: they run what is new or out of date, in order, and say nothing when all is well."""

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


@pytest.fixture
def run_fleet(call, pipelines: Path, program: Path, tmp_path: Path):
    def make(*more: object):
        environment = os.environ | {"HULLRECON": str(program)}
        return call(pipelines / "fleet", *(more or (tmp_path / "dives",)), tmp_path / "runs", 2, env=environment)

    return make


def downstream(name: str, present: set[str]) -> set[str]:
    """The step and all that takes it, by the steps' own declarations."""
    found = {name}
    for stage in stages():
        if stage.name in present and found & {*stage.inputs, *stage.optional}:
            found.add(stage.name)
    return found


def test_a_dive_is_made_step_by_step_and_then_left_alone(make_dive, make_package, trace: Path, tmp_path: Path) -> None:
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


def test_a_touched_dive_is_looked_at_but_not_made_again_and_make_is_content(
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


def test_a_changed_option_makes_its_step_and_what_takes_it(make_dive, make_package, trace: Path, tmp_path: Path) -> None:
    package = make_package(tmp_path / "package", "kestrel")
    make_dive(package)
    ran = trace.read_text().split()
    (package / "dive.toml").write_text((package / "dive.toml").read_text() + "[surface]\nfactor = 2\n")
    make_dive(package)
    again = trace.read_text().split()[len(ran) :]
    assert sorted(again) == sorted(downstream("surface", set(ran)))


def test_the_rules_are_those_that_the_steps_declare(make_dive, make_package, tmp_path: Path) -> None:
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


def test_a_dives_folder_and_files_may_have_any_names(make_dive, make_package, trace: Path, tmp_path: Path) -> None:
    package = make_package(tmp_path / "port side $(shell touch here) 'a' #1", "kestrel")
    (package / "notes: 50 % $(shell touch here).txt").write_text("x")
    first = make_dive(package)
    assert (first.returncode, first.stdout, first.stderr) == (0, "", "")
    assert (tmp_path / "runs/kestrel/deliver/report.txt").exists()
    assert not list(Path.cwd().glob("here"))
    assert make_dive(package, "-q").returncode == 0


def test_a_new_file_of_the_package_makes_ingest_look_again(make_dive, make_package, trace: Path, tmp_path: Path) -> None:
    package = make_package(tmp_path / "package", "kestrel")
    make_dive(package)
    ran = trace.read_text().split()
    (package / "log.mcap").write_bytes(b"another log")
    assert make_dive(package).returncode == 0
    assert trace.read_text().split()[len(ran) :][0] == "ingest"
    assert make_dive(package, "-q").returncode == 0


def test_a_folder_of_runs_with_spaces_is_refused_by_its_name(make_dive, make_package, tmp_path: Path) -> None:
    answer = make_dive(make_package(tmp_path / "package", "kestrel"), f"RUNS={tmp_path}/all runs")
    assert answer.returncode == 2
    assert "all runs has spaces" in answer.stderr


def test_a_fleet_is_made_and_then_left_alone_without_a_word(run_fleet, make_package, trace: Path, tmp_path: Path) -> None:
    for name in ("kestrel", "merlin"):
        make_package(tmp_path / "dives" / f"2026-{name}", name)
    for _ in range(2):
        answer = run_fleet()
        assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    ran = trace.read_text().split()
    assert ran.count("report") == 2
    assert {p.name for p in (tmp_path / "runs").iterdir()} == {"kestrel", "merlin", "logs"}
    assert "report: done" in (tmp_path / "runs" / "logs" / "2026-merlin.log").read_text()


def test_a_new_dive_is_made_and_the_others_left_alone(run_fleet, make_package, trace: Path, tmp_path: Path) -> None:
    make_package(tmp_path / "dives" / "a", "kestrel")
    run_fleet()
    make_package(tmp_path / "dives" / "b", "merlin")
    run_fleet()
    assert trace.read_text().split().count("report") == 2


def test_a_dive_that_fails_is_one_line_and_the_others_are_made(
    run_fleet, make_package, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("kestrel", "merlin"):
        make_package(tmp_path / "dives" / name, name)
    monkeypatch.setenv("TOY_FAIL", "kestrel")
    answer = run_fleet()
    assert answer.returncode == 2
    assert answer.stderr == "kestrel: error: the path could not be reckoned: look at the DVL\n"
    assert "look at the DVL" in (tmp_path / "runs/logs/kestrel.log").read_text()
    assert (tmp_path / "runs/merlin/deliver/report.txt").exists()
    monkeypatch.delenv("TOY_FAIL")
    assert run_fleet().returncode == 0
    assert (tmp_path / "runs/kestrel/deliver/report.txt").exists()


def test_two_dives_of_one_name_are_refused(run_fleet, make_package, tmp_path: Path) -> None:
    for folder in ("a", "b"):
        make_package(tmp_path / "dives" / folder, "kestrel")
    answer = run_fleet()
    assert answer.returncode == 2
    assert "the same name: kestrel" in answer.stderr


def test_a_fleet_of_no_dives_is_said_and_fails(run_fleet, tmp_path: Path) -> None:
    answer = run_fleet(tmp_path / "nowhere")
    assert (answer.returncode, answer.stderr) == (2, f"fleet: there is no folder {tmp_path / 'nowhere'}\n")
    (tmp_path / "empty").mkdir()
    answer = run_fleet(tmp_path / "empty")
    assert answer.returncode == 2
    assert answer.stderr.count("\n") == 1
    assert "no dive package" in answer.stderr


def test_folders_of_a_fleet_may_have_spaces_and_their_names_are_only_names(
    run_fleet, make_package, trace: Path, tmp_path: Path
) -> None:
    make_package(tmp_path / "all dives" / "port side", "kestrel")
    make_package(tmp_path / "all dives" / "$(shell touch here)`touch here`", "merlin")
    answer = run_fleet(tmp_path / "all dives")
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert trace.read_text().split().count("report") == 2
    assert not list(Path.cwd().glob("here"))


def test_the_log_of_a_dive_that_cannot_be_read_says_why(run_fleet, make_package, tmp_path: Path) -> None:
    package = make_package(tmp_path / "dives" / "a", "kestrel")
    (package / "dive.toml").write_text("not toml")
    answer = run_fleet()
    assert answer.returncode == 2
    assert answer.stderr.startswith("a: error: dive.toml is not valid TOML")
    assert "is not valid TOML" in (tmp_path / "runs/logs/a.log").read_text()
