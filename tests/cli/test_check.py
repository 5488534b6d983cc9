# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""cli.check: packages and runs are told apart; damage is named and ends with code 3."""

from __future__ import annotations

import json
from pathlib import Path


def test_a_whole_run_is_summed_up(program, package: Path, runs: Path) -> None:
    program("run", package, "--runs", runs)
    answer = program("check", runs / "toy", "--read-data")
    assert (answer.code, answer.out) == (0, "3 artifacts, 8 files read, 0.0 MB, 0 damaged\n")
    assert json.loads(program("check", runs / "toy", "--json").out) == {
        "artifacts": 3, "files": 7, "read_data": False, "damaged": [],
    }  # fmt: skip


def test_each_damaged_file_is_named(program, package: Path, runs: Path) -> None:
    program("run", package, "--runs", runs)
    (runs / "toy" / "ingest" / "words.txt").write_text("one two threE\n")
    (package / "log.txt").write_text("one two threE\n")
    answer = program("check", runs / "toy", "--read-data")
    assert answer.code == 3
    assert answer.out.splitlines()[:2] == [
        "damaged: ingest/words.txt is altered",
        f"damaged: {package.resolve() / 'log.txt'} is not what ingest read",
    ]
    assert answer.err.startswith("error: damaged: ingest/words.txt is altered")
    document = program("check", runs / "toy", "--read-data", "--json")
    assert document.code == 3
    assert len(json.loads(document.out)["damaged"]) == 2


def test_what_check_found_a_run_that_reads_data_makes_anew(
    program, package: Path, runs: Path
) -> None:
    program("run", package, "--runs", runs)
    (runs / "toy" / "ingest" / "words.txt").write_text("one two threE\n")
    answer = program("run", package, "--runs", runs, "--read-data", "--json")
    assert [step["state"] for step in json.loads(answer.out)["steps"]] == [
        "made",
        "up to date",
        "up to date",
    ]
    assert program("check", runs / "toy", "--read-data").code == 0


def test_read_data_is_for_runs(program, package: Path) -> None:
    answer = program("check", package, "--read-data")
    assert answer.code == 2
    assert "--read-data is for the folder of a run" in answer.err


def test_an_option_of_packages_is_refused_for_a_run(program, package: Path, runs: Path) -> None:
    program("run", package, "--runs", runs)
    answer = program("check", runs / "toy", "--set", "a.b=1")
    assert answer.code == 2
    assert "--set" in answer.err


def test_a_folder_that_is_neither_is_an_input_error(program, tmp_path: Path) -> None:
    answer = program("check", tmp_path)
    assert answer.code == 3
    assert answer.err.count("\n") == 1


def test_the_help_shows_the_options_for_packages_too(program) -> None:
    answer = program("check", "--help")
    assert answer.code == 0
    assert "--read-data" in answer.out
    assert "--set SECTION.KEY=VALUE" in answer.out
    assert answer.out.count("--json") == 1
