# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""cli.fleet: what it prints where, how it ends, and what a call with nothing to do costs."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from end_to_end.json_schema import violations

from hullrecon.api.fleet import processes
from hullrecon.api.fleet.records import FOLDER
from hullrecon.artifacts.workspace import hold_lock

ROOT = Path(__file__).parents[2]
SCHEMA = json.loads((ROOT / "hullrecon/report/schemas/fleet.schema.json").read_text())
STEPS_AND_HEAVY = (
    "hullrecon.steps.chain",
    "scipy",
    "cv2",
    "open3d",
    "pycolmap",
    "trimesh",
    "matplotlib",
    "rosbags",
    "rich",
)


@pytest.fixture
def make(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """Makes packages that do at once what they are asked to; returns the folder of dives."""
    monkeypatch.setattr(
        processes, "PROGRAM", (sys.executable, "-P", str(ROOT / "tests/api/fleet_program.py"))
    )
    monkeypatch.setenv("FLEET_TRACE", str(tmp_path / "trace.txt"))

    def make(**dives: str) -> Path:
        for name, do in dives.items():
            package = tmp_path / "dives" / name
            package.mkdir(parents=True)
            (package / "dive.toml").write_text(f'[dive]\nname = "{name}"\n')
            (package / "do.txt").write_text(do)
        return tmp_path / "dives"

    return make


def test_fleet_prints_counts_and_a_line_for_each_failure(program, make, runs: Path) -> None:
    dives = make(kestrel="deliver", merlin="fail", osprey="deliver")
    answer = program("fleet", dives, "--runs", runs, "--jobs", 2)
    assert (answer.code, answer.out) == (4, "3 dives: 2 delivered, 1 failed, 3 run now\n")
    lines = answer.err.splitlines()
    assert lines[0] == "3 of 3 dives to run"
    assert [line for line in lines if "failed" in line] == [
        "failed: merlin: exit code 4: too few\\x1b[31m matches"
    ]
    again = program("fleet", dives, "--runs", runs)
    assert (again.code, again.out) == (4, "3 dives: 2 delivered, 1 failed, 0 run now\n")
    assert again.err.splitlines()[0] == "failed: merlin: exit code 4: too few\\x1b[31m matches"


def test_a_fleet_that_is_delivered_ends_with_0(program, make, runs: Path) -> None:
    answer = program("fleet", make(kestrel="deliver"), "--runs", runs)
    assert (answer.code, answer.out) == (0, "1 dive: 1 delivered, 0 failed, 1 run now\n")


def test_a_quiet_fleet_says_nothing_but_a_failure_once(program, make, runs: Path) -> None:
    dives = make(kestrel="deliver", merlin="fail")
    (dives / "empty").mkdir()
    first = program("-q", "fleet", dives, "--runs", runs)
    assert (first.code, first.out, first.err) == (
        4,
        "",
        "failed: merlin: exit code 4: too few\\x1b[31m matches\n",
    )
    again = program("fleet", dives, "--runs", runs, "--quiet")
    assert (again.code, again.out, again.err) == (4, "", "")


def test_retry_runs_again_what_failed(program, make, runs: Path, tmp_path: Path) -> None:
    dives = make(kestrel="deliver", merlin="fail")
    program("fleet", dives, "--runs", runs)
    (tmp_path / "trace.txt").write_text("")
    program("fleet", dives, "--runs", runs, "--retry")
    assert [line.split()[0] for line in (tmp_path / "trace.txt").read_text().splitlines()] == [
        "merlin"
    ]


def test_json_is_one_document_as_the_schema_has_it(program, make, runs: Path) -> None:
    dives = make(kestrel="deliver", merlin="fail")
    (dives / "empty").mkdir()
    answer = program("fleet", dives, "--runs", runs, "--json")
    document = json.loads(answer.out)
    assert violations(document, SCHEMA) == []
    assert (answer.code, document["exit_code"], document["delivered"], document["failed"]) == (
        4,
        4,
        1,
        1,
    )
    kestrel, merlin = document["dives"]
    assert (kestrel["name"], kestrel["state"], kestrel["deliver_files"]) == (
        "kestrel",
        "delivered",
        ["report.txt"],
    )
    assert kestrel["package_files"] == ["dive.toml", "do.txt"]
    assert (merlin["state"], merlin["exit_code"], merlin["deliver"]) == ("failed", 4, None)
    assert document["skipped"] == [
        {"path": str(dives / "empty"), "reason": "it holds no dive.toml"}
    ]


def test_dry_run_says_what_and_why_and_writes_nothing(
    program, make, runs: Path, tmp_path: Path
) -> None:
    answer = program("fleet", make(kestrel="deliver", merlin="fail"), "--runs", runs, "--dry-run")
    assert answer.code == 0
    assert answer.out.splitlines() == [
        "would run kestrel: new",
        "would run merlin: new",
        "2 dives: 0 delivered, 0 failed, 2 to do",
    ]
    assert not runs.exists()
    document = json.loads(
        program("fleet", tmp_path / "dives", "--runs", runs, "--dry-run", "--json").out
    )
    assert violations(document, SCHEMA) == []


def test_fleet_ends_with_3_for_wrong_folder_2_for_usage(
    program, make, runs: Path, tmp_path: Path
) -> None:
    dives = make(kestrel="deliver")
    (tmp_path / "none").mkdir()
    for folder, words in (
        (tmp_path / "nowhere", "No such file"),
        (tmp_path / "none", "no dive package"),
    ):
        answer = program("fleet", folder, "--runs", runs)
        assert (answer.code, answer.out, answer.err.count("\n")) == (3, "", 1)
        assert words in answer.err
    for arguments in (
        (dives, "--runs", dives),
        (dives, "--jobs", 0),
        ("--runs", runs),
        (dives, "--scheduler", "nonsense"),
    ):
        answer = program("fleet", *arguments, *(() if "--runs" in arguments else ("--runs", runs)))
        assert (answer.code, answer.out) == (2, "")
        assert [line for line in answer.err.splitlines() if not line.startswith("error: ")] == []


def test_a_second_fleet_ends_with_5(program, make, runs: Path) -> None:
    dives = make(kestrel="deliver")
    with hold_lock(runs / FOLDER / "lock"):
        answer = program("fleet", dives, "--runs", runs)
    assert answer.code == 5
    assert answer.err.startswith("error: another fleet is at work here: locked by process ")
    assert answer.err.count("\n") == 1


def test_names_of_others_cannot_write_on_the_terminal(program, make, runs: Path) -> None:
    dives = make(kestrel="deliver")
    (dives / "\x1b[2J\nfailed: kestrel").mkdir()
    (dives / "a\rb").mkdir()
    (dives / "a\rb" / "dive.toml").write_text("x = [")
    answer = program("fleet", dives, "--runs", runs)
    assert "\x1b" not in answer.err + answer.out
    assert "\r" not in answer.err + answer.out
    assert "skipped: \\x1b[2J\\nfailed: kestrel: it holds no dive.toml" in answer.err.splitlines()
    assert [line for line in answer.err.splitlines() if line.startswith("failed")] == [
        "failed: a\\rb: exit code 2: dive.toml is not valid TOML"
    ]


def test_idle_fleet_opens_dive_toml_alone(program, make, runs: Path) -> None:
    dives = make(**{f"dive{k}": "deliver" for k in range(3)})
    assert program("fleet", dives, "--runs", runs, "--jobs", 3).code == 0
    code = f"""
import os, sys
opened = []
sys.addaudithook(lambda event, values: opened.append(os.fsdecode(values[0])) if event == "open" and
    isinstance(values[0], (str, bytes, os.PathLike)) and
    os.fsdecode(values[0]).startswith({str(dives.parent)!r}) else None)
from hullrecon_cli.main import main
code = main(["--json", "fleet", {str(dives)!r}, "--runs", {str(runs)!r}])
print(code, sorted(set(os.path.relpath(path, {str(dives.parent)!r}) for path in opened)),
    sorted(set({STEPS_AND_HEAVY!r}) & set(sys.modules)), file=sys.stderr)
"""
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    opened = [
        *(f"dives/dive{k}/dive.toml" for k in range(3)),
        "runs/.fleet/dives.json",
        "runs/.fleet/lock",
    ]
    assert answer.stderr.splitlines()[-1] == f"0 {opened} []"


def test_fleet_takes_time_limit_and_allow_outside(program, make, runs: Path) -> None:
    dives = make(kestrel="read outside", merlin="wait")
    answer = program(
        "fleet", dives, "--runs", runs, "--jobs", 2, "--allow-outside", "--time-limit", 5
    )
    assert (answer.code, answer.out) == (4, "2 dives: 1 delivered, 1 failed, 2 run now\n")
    assert "failed: merlin: exit code 4: it took longer than 5 s (--time-limit)" in answer.err
    assert program("fleet", dives, "--runs", runs, "--time-limit", 0).code == 2
