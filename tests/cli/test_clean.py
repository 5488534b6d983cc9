# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""cli.clean: nothing goes that was not named or agreed to."""

from __future__ import annotations

from pathlib import Path

from hullrecon.artifacts.workspace import Workspace


def artifacts(runs: Path) -> set[str]:
    return {path.parent.name for path in (runs / "toy").glob("*/manifest.json")}


def test_a_dry_run_lists_and_removes_nothing(program, package: Path, runs: Path) -> None:
    program("run", package, "--runs", runs)
    answer = program("clean", package, "--runs", runs, "--dry-run")
    assert answer.out.splitlines() == [
        f"would remove {runs / 'toy' / n}" for n in ("ingest", "navigate", "report")
    ]
    assert artifacts(runs) == {"ingest", "navigate", "report"}


def test_clean_without_terminal_or_steps_removes_nothing(
    program, package: Path, runs: Path
) -> None:
    program("run", package, "--runs", runs)
    answer = program("clean", package, "--runs", runs)
    assert answer.code == 2
    assert "would remove all artifacts: ingest, navigate, report" in answer.err
    assert "--yes" in answer.err
    assert answer.err.count("\n") == 1
    assert artifacts(runs) == {"ingest", "navigate", "report"}


def test_yes_removes_all(program, package: Path, runs: Path) -> None:
    program("run", package, "--runs", runs)
    assert program("clean", package, "--runs", runs, "--yes").code == 0
    assert artifacts(runs) == set()


def test_the_option_that_a_locked_dive_advises_exists(program, package: Path, runs: Path) -> None:
    program("run", package, "--runs", runs)
    with Workspace(runs / "toy").lock():
        answer = program("clean", package, "navigate", "--runs", runs)
        assert answer.code == 5
        assert "--wait SECONDS" in answer.err
        assert program("clean", package, "navigate", "--runs", runs, "--wait", "0.1").code == 5
