# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""cli.run: run, status, explain, clean, with what they print and how they end."""

from __future__ import annotations

import json
import logging
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from hullrecon.artifacts.workspace import Workspace


def states(answer) -> dict[str, str]:
    return {step["name"]: step["state"] for step in json.loads(answer.out)["steps"]}


def test_a_run_says_what_it_made_and_where_the_deliverables_are(
    program, package: Path, runs: Path
) -> None:
    answer = program("run", package, "--runs", runs)
    assert answer.code == 0
    lines = answer.out.splitlines()
    assert [line.split()[:2] for line in lines[:3]] == [
        ["ingest", "ran"],
        ["navigate", "ran"],
        ["report", "ran"],
    ]
    assert lines[3] == f"deliverables: {runs / 'toy' / 'deliver'}"
    assert "toy: to do: ingest, navigate, report" in answer.err
    assert json.loads((runs / "toy/deliver/report.txt").read_text())["words"] == 3


def test_a_quiet_run_says_nothing_when_all_is_well(program, package: Path, runs: Path) -> None:
    answer = program(
        "run", package, "--runs", runs, "--quiet", "--set", "navigate.loud=true", "--from-scratch"
    )
    assert (answer.code, answer.out, answer.err) == (0, "", "")


@pytest.mark.parametrize("place", ["before", "after"])
def test_common_options_may_stand_before_and_after_the_command(
    place: str, program, package: Path, runs: Path
) -> None:
    command = ["run", package, "--runs", runs]
    answer = program("--json", *command) if place == "before" else program(*command, "--json")
    document = json.loads(answer.out)
    assert document["dive"] == "toy"
    assert document["deliver"] == str(runs / "toy" / "deliver")
    assert states(answer) == dict.fromkeys(("ingest", "navigate", "report"), "made")


def test_a_second_run_makes_nothing(program, package: Path, runs: Path) -> None:
    program("run", package, "--runs", runs)
    answer = program("run", package, "--runs", runs, "--json")
    assert set(states(answer).values()) == {"up to date"}


def test_second_package_of_same_name_warns_and_replaces(
    program, package: Path, runs: Path, tmp_path: Path
) -> None:
    program("run", package, "--runs", runs)
    other = Path(shutil.copytree(package, tmp_path / "other"))
    (other / "log.txt").write_text("one two\n")
    answer = program("run", other, "--runs", runs)
    assert answer.code == 0
    assert (
        f"{runs / 'toy'} holds the results of another dive package, {package}:"
        " what differs is replaced" in answer.err
    )
    assert json.loads((runs / "toy/deliver/report.txt").read_text())["words"] == 2
    assert "another dive package" not in program("run", other, "--runs", runs).err


def test_package_is_known_by_path_link_and_run(
    program, package: Path, runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program("run", package, "--runs", runs)
    (tmp_path / "link").symlink_to(package)
    monkeypatch.chdir(tmp_path)
    for target in ("package", "link", "runs/toy", "package/../link"):
        assert set(states(program("run", target, "--runs", "runs", "--json")).values()) == {
            "up to date"
        }


@pytest.mark.parametrize("left", ["nothing", "an empty folder", "a link to where it is"])
def test_a_package_that_was_moved_goes_on_in_its_run(
    left: str, program, package: Path, runs: Path, tmp_path: Path
) -> None:
    program("run", package, "--runs", runs)
    moved = package.rename(tmp_path / "moved")
    if left == "an empty folder":
        package.mkdir()
    elif left == "a link to where it is":
        package.symlink_to(moved)
    answer = program("run", moved, "--runs", runs, "--json")
    assert set(states(answer).values()) == {"up to date"}
    assert Workspace(runs / "toy").package == moved


def test_a_run_up_to_a_step_stops_there(program, package: Path, runs: Path) -> None:
    assert states(program("run", package, "--runs", runs, "--to", "navigate", "--json")) == {
        "ingest": "made",
        "navigate": "made",
    }
    assert not (runs / "toy" / "report").exists()


def test_the_runs_folder_may_come_from_the_environment(
    program, package: Path, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HULLRECON_RUNS", str(runs))
    assert program("run", package).code == 0
    assert (runs / "toy" / "deliver").is_dir()


def test_warnings_are_in_the_log_and_in_the_document(program, package: Path, runs: Path) -> None:
    answer = program("run", package, "--runs", runs, "--set", "navigate.loud=true", "--json")
    assert "warning: navigate: the log is loud\n" in answer.err
    assert json.loads(answer.out)["steps"][1]["warnings"] == ["the log is loud"]


def test_a_log_file_has_everything_with_the_time(
    program, package: Path, runs: Path, tmp_path: Path
) -> None:
    program("run", package, "--runs", runs, "--quiet", "--log-file", tmp_path / "run.log")
    for handler in logging.getLogger("hullrecon").handlers:
        handler.close()
    text = (tmp_path / "run.log").read_text()
    assert text.startswith("20")
    assert "INFO hullrecon.artifacts.runner: [2/3] navigate: started: first run" in text


def test_status_says_where_each_step_stands_and_changes_nothing(
    program, package: Path, runs: Path
) -> None:
    assert states(program("status", package, "--runs", runs, "--json")) == dict.fromkeys(
        ("ingest", "navigate", "report"), "not run yet"
    )
    assert not runs.exists()
    program("run", package, "--runs", runs)
    answer = program("status", package, "--runs", runs, "--set", "navigate.times=2")
    assert answer.out.splitlines() == [
        "ingest          up to date",
        "navigate        out of date: option navigate.times changed from 1 to 2",
        "report          out of date: input navigate will rerun",
    ]


def test_status_needs_no_lock(program, package: Path, runs: Path) -> None:
    program("run", package, "--runs", runs)
    with Workspace(runs / "toy").lock():
        assert program("status", package, "--runs", runs).code == 0
        assert program("explain", package, "--runs", runs).code == 0
        assert program("check", runs / "toy", "--read-data").code == 0


def test_a_runs_folder_stands_for_the_package_that_it_read(
    program, package: Path, runs: Path
) -> None:
    program("run", package, "--runs", runs)
    assert set(states(program("status", runs / "toy", "--json")).values()) == {"up to date"}
    (runs / "toy" / ".hullrecon" / "workspace.json").unlink()
    answer = program("status", runs / "toy")
    assert answer.code == 3
    assert "does not say which dive package" in answer.err
    assert program("status", package, "--runs", runs).code == 0  # the package's folder


def test_explain_says_which_option_and_from_what_to_what(
    program, package: Path, runs: Path
) -> None:
    program("run", package, "--runs", runs)
    (package / "log.txt").write_text("four\n")
    answer = program(
        "explain",
        package,
        "--runs",
        runs,
        "--set",
        "navigate.margin_m=0.7",
        "--set",
        "tray.sigma_deg=1.5",
    )
    assert answer.out.splitlines() == [
        "ingest: external file log.txt changed",
        "navigate: option navigate.margin_m changed from 0.5 to 0.7",
        "navigate: option tray.sigma_deg changed from 0.8 to 1.5",
        "navigate: input ingest will rerun",
        "report: input navigate will rerun",
    ]
    assert (
        program("explain", package, "ingest", "--runs", runs).out
        == "ingest: external file log.txt changed\n"
    )


def test_explain_of_an_unknown_step_is_wrong_usage(program, package: Path, runs: Path) -> None:
    answer = program("explain", package, "navgate", "--runs", runs)
    assert (answer.code, answer.err) == (
        2,
        "error: unknown step 'navgate'; did you mean 'navigate'?\n",
    )


def test_clean_removes_the_artifacts_that_are_named_or_all(
    program, package: Path, runs: Path
) -> None:
    program("run", package, "--runs", runs)
    assert program("clean", package, "navigate", "--runs", runs).out == "removed navigate\n"
    assert states(program("run", package, "--runs", runs, "--json")) == {
        "ingest": "up to date",
        "navigate": "made",
        "report": "up to date",
    }
    assert json.loads(program("clean", runs / "toy", "--yes", "--json").out)["removed"] == [
        "ingest",
        "navigate",
        "report",
    ]
    assert not (runs / "toy" / "deliver").exists()
    assert (package / "log.txt").exists()


def test_too_little_space_is_said_before_anything_is_done(
    program, package: Path, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program("run", package, "--runs", runs)
    with monkeypatch.context() as full:
        full.setattr(shutil, "disk_usage", lambda folder: shutil._ntuple_diskusage(10, 9, 1))
        answer = program("run", package, "--runs", runs, "--set", "navigate.times=2")
    assert answer.code == 6
    assert "only 0 MB are free" in answer.err
    assert set(states(program("status", package, "--runs", runs, "--json")).values()) == {
        "up to date"
    }
    # space was freed
    assert program("run", package, "--runs", runs, "--set", "navigate.times=2").code == 0


@pytest.mark.parametrize(
    ("how", "code", "words"),
    [
        ("badly", 4, "error: too few words (log.txt): write more"),
        ("never", 130, "error: interrupted"),
        ("fault", 1, "error: internal error; traceback in "),
    ],
)
def test_a_step_that_fails_ends_the_run_with_its_code(
    how: str, code: int, words: str, program, package: Path, runs: Path
) -> None:
    answer = program("run", package, "--runs", runs, "--quiet", "--set", f"navigate.end={how}")
    assert answer.code == code
    assert answer.err.lstrip().startswith(words)
    assert answer.err.strip().count("\n") == 0
    assert states(program("run", package, "--runs", runs, "--json")) == {
        "ingest": "up to date",
        "navigate": "made",
        "report": "made",
    }


def test_the_traceback_of_a_fault_lies_with_the_run(program, package: Path, runs: Path) -> None:
    answer = program("run", package, "--runs", runs, "--set", "navigate.end=fault")
    (written,) = (runs / "toy" / "logs").iterdir()
    assert answer.err.rstrip().endswith(str(written))
    assert "ZeroDivisionError: a fault of ours" in written.read_text()


def test_a_run_beside_another_ends_with_code_5(program, package: Path, runs: Path) -> None:
    with Workspace(runs / "toy").lock():
        answer = program("run", package, "--runs", runs, "--quiet")
    assert answer.code == 5
    assert answer.err.startswith("error: dive is locked by process ")
    assert answer.err.count("\n") == 1


def test_a_read_only_place_ends_with_code_6(program, package: Path) -> None:
    place = Path("/sys/kernel")
    if not place.is_dir():
        pytest.skip("no place where root may not write")
    answer = program("run", package, "--runs", place, "--quiet")
    assert answer.code == 6
    assert answer.err.startswith("error: cannot write: ")
    assert str(place) in answer.err


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        (lambda p: (p / "dive.toml").unlink(), 3, "no dive.toml"),
        (lambda p: (p / "log.txt").unlink(), 3, "log.txt is missing"),
        (
            lambda p: (p / "dive.toml").write_text(
                "[dive]\nname='a'\nvesel='b'\n[logs]\nfiles=[]\n"
            ),
            2,
            "vessel",
        ),
        (lambda p: (p / "dive.toml").write_text("not toml"), 2, "not valid TOML"),
    ],
)
def test_a_package_that_cannot_be_used_is_one_line(
    change, code: int, words: str, program, package: Path, runs: Path
) -> None:
    change(package)
    answer = program("run", package, "--runs", runs, "--quiet")
    assert answer.code == code
    assert words in answer.err
    assert answer.err.count("\n") == 1


def test_a_run_ends_with_its_warnings_and_findings(program, package: Path, runs: Path) -> None:
    answer = program("run", package, "--runs", runs, "--set", "navigate.loud=true")
    assert answer.out.splitlines()[3:] == [
        "1 warning:", "  navigate: the log is loud", f"deliverables: {runs / 'toy' / 'deliver'}",
    ]  # fmt: skip


def test_the_end_of_a_step_is_printed_once(program, package: Path, runs: Path) -> None:
    answer = program("run", package, "--runs", runs)
    assert "done in" not in answer.err
    assert answer.out.count("ran in") == 3
    again = program("run", package, "--runs", runs)
    assert again.err == "toy: everything is up to date\n"
    assert again.out.count("up to date") == 3


def test_the_findings_are_those_at_the_head_of_the_report(tmp_path: Path) -> None:
    from hullrecon_cli.commands.run import delivery_lines

    assert delivery_lines(tmp_path / "absent") == []
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / "index.html").touch()
    (tmp_path / "summary.json").write_text(
        '{"summary": ["2 objects were found.", "8.4 m2 were seen."]}'
    )
    assert delivery_lines(tmp_path) == [
        "2 objects were found.", "8.4 m2 were seen.",
        f"report: {tmp_path / 'report' / 'index.html'}", f"deliverables: {tmp_path}",
    ]  # fmt: skip
    (tmp_path / "summary.json").write_text("[]")
    assert len(delivery_lines(tmp_path)) == 2


def test_wrong_choice_by_set_lists_the_choices(program, package: Path, runs: Path) -> None:
    answer = program("run", package, "--runs", runs, "--set", "navigate.end=wel")
    assert answer.code == 2
    assert (
        answer.err == 'error: navigate.end = \'wel\': expected "well" or "badly" or "never" or '
        '"fault" (from --set)\n'
    )
    (package / "dive.toml").write_text(
        (package / "dive.toml").read_text() + '[navigate]\nend = "wel"\n'
    )
    answer = program("run", package, "--runs", runs)
    assert (
        answer.err == 'error: navigate.end = \'wel\': expected "well" or "badly" or "never" or '
        '"fault" (dive.toml)\n'
    )


def test_value_out_of_bounds_names_set(program, package: Path, runs: Path) -> None:
    answer = program("run", package, "--runs", runs, "--set", "navigate.times=99")
    assert answer.code == 2
    assert answer.err.endswith("(from --set)\n")


def test_a_scheduler_that_is_not_there_is_one_line(
    program, package: Path, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hullrecon.artifacts.executor._CONNECT_S", 0.1)
    for address in (
        "nonsense",
        "tcp://nonsense.invalid:8786",
        "tcp://127.0.0.1:1",
        "tcp://127.0.0.1:many",
    ):
        answer = program("run", package, "--runs", runs, "--scheduler", address, "--quiet")
        assert answer.code == 2
        assert answer.err.count("\n") == 1, answer.err
        assert address in answer.err


def test_the_log_file_of_a_run_that_fails_holds_the_error(
    program, package: Path, runs: Path, tmp_path: Path
) -> None:
    (package / "log.txt").unlink()
    answer = program("run", package, "--runs", runs, "--quiet", "--log-file", tmp_path / "run.log")
    assert answer.code == 3
    assert answer.err.strip() in (tmp_path / "run.log").read_text()


@pytest.mark.parametrize(
    ("how", "code", "said"),
    [("badly", 4, "too few words (log.txt): write more"), ("fault", 1, "internal error")],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_step_failing_alone_delivers_and_ends_with_its_code(
    as_json: bool,
    how: str,
    code: int,
    said: str,
    program,
    package: Path,
    runs: Path,
    toy_stages,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ingest, navigate, report = toy_stages
    alone = replace(
        report,
        inputs=("ingest",),
        optional=("navigate",),
        run=lambda c: c.out.json("deliver/why.json", c.failures),
    )
    monkeypatch.setattr(
        "hullrecon.steps.chain.stages", lambda: (ingest, replace(navigate, fails_alone=True), alone)
    )
    command = ["run", package, "--runs", runs, "--quiet", "--set", f"navigate.end={how}"]
    answer = program(*command, *["--json"] * as_json)
    assert answer.code == code
    assert answer.err.startswith(f"error: {said}")
    assert answer.err.count("\n") == 1
    assert said in json.loads((runs / "toy" / "deliver" / "why.json").read_text())["navigate"]
    if as_json:
        assert states(answer) == {"ingest": "made", "navigate": "failed", "report": "made"}


def test_what_an_earlier_run_delivered_is_not_shown_as_this_runs(
    program, package: Path, runs: Path
) -> None:
    program("run", package, "--runs", runs)
    answer = program(
        "run", package, "--runs", runs, "--to", "navigate", "--set", "navigate.times=2", "--json"
    )
    assert json.loads(answer.out)["deliver"] is None
    failed = program("run", package, "--runs", runs, "--set", "navigate.end=badly")
    assert failed.code == 4
    assert not (runs / "toy" / "deliver").exists()
    assert (runs / "toy" / "deliver-out-of-date" / "report.txt").exists()


def test_run_without_jobs_uses_all_cores_and_says_so(
    program, package: Path, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("HULLRECON_JOBS", raising=False)
    monkeypatch.setattr("os.sched_getaffinity", lambda process: {0, 1, 2})
    assert "toy: 3 worker processes (--jobs)\n" in program("run", package, "--runs", runs).err
    given = program("run", package, "--runs", runs / "again", "--jobs", 1)
    assert "toy: 1 worker process (--jobs)\n" in given.err
