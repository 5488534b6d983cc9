# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pipelines/fleet over the whole program with short steps: silent when all is well, one line for a
dive that fails.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture
def fleet(call, pipelines: Path, program: Path, tmp_path: Path):
    """Calls pipelines/fleet on `dives`."""

    def run(dives: object = tmp_path / "dives", *more: object, **options: object):
        environment = os.environ | {"HULLRECON": str(program)}
        return call(
            pipelines / "fleet", dives, tmp_path / "runs", *more, env=environment, **options
        )

    return run


def test_a_fleet_is_made_and_then_left_alone_without_a_word(
    fleet, make_package, trace: Path, tmp_path: Path
) -> None:
    for name in ("kestrel", "merlin"):
        make_package(tmp_path / "dives" / f"2026-{name}", name)
    for _ in range(2):
        answer = fleet(tmp_path / "dives", 2)
        assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert trace.read_text().split().count("report") == 2
    assert {p.name for p in (tmp_path / "runs").iterdir()} == {
        "kestrel",
        "merlin",
        ".fleet",
        "index.html",
    }
    assert "report: done" in (tmp_path / "runs" / ".fleet" / "logs" / "merlin.log").read_text()


def test_a_new_dive_is_made_and_the_others_left_alone(
    fleet, make_package, trace: Path, tmp_path: Path
) -> None:
    make_package(tmp_path / "dives" / "a", "kestrel")
    fleet()
    make_package(tmp_path / "dives" / "b", "merlin")
    fleet()
    assert trace.read_text().split().count("report") == 2


def test_a_dive_that_fails_is_one_line_and_the_others_are_made(
    fleet, make_package, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("kestrel", "merlin"):
        make_package(tmp_path / "dives" / name, name)
    monkeypatch.setenv("TOY_FAIL", "dives/kestrel")
    answer = fleet()
    assert answer.returncode == 4
    assert (
        answer.stderr
        == "failed: kestrel: exit code 4: the path could not be reckoned: look at the DVL\n"
    )
    assert "look at the DVL" in (tmp_path / "runs/.fleet/logs/kestrel.log").read_text()
    assert (tmp_path / "runs/merlin/deliver/report.txt").exists()
    monkeypatch.delenv("TOY_FAIL")
    (tmp_path / "dives" / "kestrel" / "log.mcap").write_bytes(b"a better log")
    assert fleet().returncode == 0
    assert (tmp_path / "runs/kestrel/deliver/report.txt").exists()


def test_a_dive_that_was_run_by_hand_is_not_run_again(
    call, fleet, program, make_package, trace: Path, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "dives" / "a", "kestrel")
    assert call(program, "--quiet", "run", package, "--runs", tmp_path / "runs").returncode == 0
    before = trace.read_text()
    assert fleet().returncode == 0
    assert trace.read_text() == before


def test_an_artifact_that_was_damaged_is_made_again(
    fleet, make_package, trace: Path, tmp_path: Path
) -> None:
    make_package(tmp_path / "dives" / "a", "kestrel")
    fleet()
    before = trace.read_text().split()
    (tmp_path / "runs/kestrel/surface/text.txt").write_text("another")
    assert fleet().returncode == 0
    assert trace.read_text().split()[len(before) :] == ["surface"]


def test_a_wrong_folder_is_one_line_and_leaves_nothing(fleet, tmp_path: Path) -> None:
    answer = fleet(tmp_path / "nowhere")
    assert answer.returncode == 3
    assert (
        answer.stderr == "error: the folder of dives cannot be read: No such file or directory"
        f" ({tmp_path / 'nowhere'})\n"
    )
    (tmp_path / "empty").mkdir()
    answer = fleet(tmp_path / "empty")
    assert answer.returncode == 3
    assert answer.stderr.count("\n") == 1
    assert "no dive package" in answer.stderr
    assert not (tmp_path / "runs").exists()


def test_the_script_without_arguments_says_how(call, pipelines: Path) -> None:
    answer = call(pipelines / "fleet")
    assert answer.returncode == 2
    assert "fleet DIVES RUNS [JOBS]" in answer.stderr


def test_a_folder_of_dives_may_be_called_like_an_option(
    fleet, make_package, tmp_path: Path
) -> None:
    make_package(tmp_path / "--retry" / "-rf", "kestrel")
    answer = fleet("--retry", cwd=tmp_path)
    assert (answer.returncode, answer.stderr) == (0, "")
    assert (tmp_path / "runs/kestrel/deliver/report.txt").exists()
