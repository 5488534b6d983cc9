# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""api.fleet: what is new or out of date is run, a failure stays with its dive, nothing is mixed,
kills lose nothing.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hullrecon.api.fleet import FleetResult, preview_fleet, processes, records, run_fleet
from hullrecon.api.fleet.records import FOLDER
from hullrecon.artifacts.workspace import hold_lock
from hullrecon.errors import InputError, LockedError, UsageError

PROGRAM = (sys.executable, "-P", str(Path(__file__).with_name("fleet_program.py")))
Dive = Callable[..., Path]


@pytest.fixture
def trace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Gets a line for each dive that is run."""
    path = tmp_path / "trace.txt"
    path.touch()
    monkeypatch.setenv("FLEET_TRACE", str(path))
    monkeypatch.setattr(processes, "PROGRAM", PROGRAM)
    return path


@pytest.fixture
def dives(tmp_path: Path) -> Path:
    (tmp_path / "dives").mkdir()
    return tmp_path / "dives"


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    return tmp_path / "runs"


@pytest.fixture
def dive(dives: Path, trace: Path) -> Dive:
    """Makes a package that does what it is asked to."""

    def make(folder: str, do: str = "deliver", name: str | None = None) -> Path:
        package = dives / folder
        package.mkdir()
        (package / "dive.toml").write_text(f'[dive]\nname = "{name or folder}"\n')
        (package / "do.txt").write_text(do)
        return package

    return make


def ran(trace: Path) -> list[str]:
    return sorted(line.split()[0] for line in trace.read_text().splitlines())


def states(result: FleetResult) -> dict[str, str]:
    return {dive.package.name: dive.state for dive in result.dives}


def test_every_dive_is_run_once_and_then_left_alone(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    for name in ("kestrel", "merlin", "osprey"):
        dive(name)
    first = run_fleet(dives, runs, jobs=2)
    assert states(first) == dict.fromkeys(("kestrel", "merlin", "osprey"), "delivered")
    assert (first.exit_code, first.summary()) == (0, "3 dives: 3 delivered, 0 failed, 3 run now")
    assert (runs / "merlin/deliver/report.txt").read_text() == "merlin None"
    second = run_fleet(dives, runs)
    assert set(states(second).values()) == {"up to date"}
    assert second.summary() == "3 dives: 3 delivered, 0 failed, 0 run now"
    assert ran(trace) == ["kestrel", "merlin", "osprey"]


def test_fleet_runs_new_and_changed_packages_alone(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel")
    package = dive("merlin")
    run_fleet(dives, runs)
    dive("osprey")
    (package / "log.bin").write_bytes(b"more")
    result = preview_fleet(dives, runs)
    assert {d.package.name: d.reason for d in result.dives if d.state == "to do"} == {
        "merlin": "the package changed",
        "osprey": "new",
    }
    trace.write_text("")
    run_fleet(dives, runs)
    assert ran(trace) == ["merlin", "osprey"]


def test_a_result_that_was_changed_or_removed_is_made_again(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel")
    run_fleet(dives, runs)
    shutil.rmtree(runs / "kestrel" / "deliver")
    (only,) = preview_fleet(dives, runs).dives
    assert (only.state, only.reason) == ("to do", "the result changed")
    run_fleet(dives, runs)
    assert (runs / "kestrel/deliver/report.txt").exists()
    assert ran(trace) == ["kestrel", "kestrel"]


def test_a_dive_is_looked_at_again_when_hullrecon_changed(
    dive: Dive, dives: Path, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dive("kestrel")
    run_fleet(dives, runs)
    monkeypatch.setattr("hullrecon.api.fleet.fleet.program_signature", lambda: "another")
    assert preview_fleet(dives, runs).dives[0].reason == "hullrecon changed"


def test_failures_of_all_kinds_leave_the_others(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    for do in ("fail", "kill", "crash", "deliver"):
        dive(do, do)
    seen: list[str] = []
    result = run_fleet(dives, runs, on_failure=lambda failed: seen.append(failed.line()))
    assert result.exit_code == 4
    assert states(result) == {
        "fail": "failed",
        "kill": "failed",
        "crash": "failed",
        "deliver": "delivered",
    }
    assert sorted(seen) == [
        "failed: crash: exit code 1: without an active exception",
        "failed: fail: exit code 4: too few\\x1b[31m matches",
        "failed: kill: exit code 137: ended by SIGKILL: most likely the memory ran out",
    ]


def test_what_a_dive_delivered_of_which_one_step_failed_is_shown(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel", "fail in one step")
    for ran in (True, False):  # known by the second call
        result = run_fleet(dives, runs)
        (found,) = result.dives
        assert (found.state, found.ran, found.delivered, result.exit_code) == (
            "failed",
            ran,
            True,
            4,
        )
        assert [d["deliver_files"] for d in result.document()["dives"]] == [["report.txt"]]


def test_fleet_hides_earlier_delivery_of_a_run_cut_off(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    package = dive("kestrel")
    run_fleet(dives, runs)
    for do, limit_s in (("kill", None), ("wait", 1.0)):
        (package / "do.txt").write_text(do)
        (found,) = run_fleet(dives, runs, time_limit_s=limit_s).dives
        assert (found.state, found.ran, found.delivered) == ("failed", True, False)


def test_fleet_remembers_a_failure_until_something_changes(
    dive: Dive, dives: Path, runs: Path, trace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = dive("kestrel", "fail")
    assert not run_fleet(dives, runs).dives[0].known
    again = run_fleet(dives, runs)
    assert (again.exit_code, again.dives[0].known, again.dives[0].ran) == (4, True, False)
    assert len(ran(trace)) == 1
    assert run_fleet(dives, runs, retry=True).dives[0].ran
    later = time.time() + records.TRIED_AGAIN_S
    with monkeypatch.context() as patch:
        patch.setattr(records.time, "time", lambda: later)
        assert preview_fleet(dives, runs).dives[0].reason == "it failed before"
    (package / "do.txt").write_text("deliver now")
    assert states(run_fleet(dives, runs)) == {"kestrel": "delivered"}


def test_a_dive_that_was_killed_is_tried_again_at_once(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel", "kill")
    run_fleet(dives, runs)
    run_fleet(dives, runs)
    assert len(ran(trace)) == 2


def test_fleet_refuses_two_packages_of_one_name(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    for folder in ("a", "b"):
        dive(folder, name="kestrel")
    dive("merlin")
    result = run_fleet(dives, runs)
    assert [d.line().partition(" (")[0] for d in result.dives if d.state == "failed"] == [
        "failed: a: exit code 2: its dive.name kestrel is also that of b",
        "failed: b: exit code 2: its dive.name kestrel is also that of a",
    ]
    assert ran(trace) == ["merlin"]
    assert not (runs / "kestrel").exists()
    assert all(d.known for d in run_fleet(dives, runs).dives if d.state == "failed")


def test_package_taking_a_delivered_name_changes_nothing(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("a", name="kestrel")
    run_fleet(dives, runs)
    made = (runs / "kestrel/deliver/report.txt").stat().st_mtime_ns
    dive("b", name="kestrel")
    assert states(run_fleet(dives, runs)) == {"a": "failed", "b": "failed"}
    assert (runs / "kestrel/deliver/report.txt").stat().st_mtime_ns == made
    shutil.rmtree(dives / "b")
    assert run_fleet(dives, runs).exit_code == 0


@pytest.mark.parametrize("name", ["..", ".", "a/b", "kestrel\\n", "x" * 101, "$(touch here)", ""])
def test_invalid_dive_name_is_explained_and_writes_nothing(
    name: str, dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel", name=name or '" # ')
    (only,) = run_fleet(dives, runs).dives
    assert (only.state, only.exit_code, only.name) == ("failed", 2, None)
    assert only.reason == "dive.toml is not valid TOML"
    assert sorted(p.name for p in runs.iterdir()) == [FOLDER, "index.html"]
    assert ran(trace) == []


def test_dive_with_results_above_packages_is_refused(tmp_path: Path, trace: Path) -> None:
    package = tmp_path / "kestrel" / "a"
    package.mkdir(parents=True)
    (package / "dive.toml").write_text('[dive]\nname = "kestrel"\n')
    (only,) = run_fleet(tmp_path / "kestrel", tmp_path).dives
    assert (only.state, only.exit_code) == ("failed", 2)
    assert "would lie above the packages" in only.reason


def test_results_among_packages_are_refused_before_writing(dive: Dive, dives: Path) -> None:
    package = dive("kestrel")
    for runs in (dives, package, package / "runs"):
        with pytest.raises(UsageError, match="would lie among the packages"):
            run_fleet(dives, runs)
    assert sorted(p.name for p in package.iterdir()) == ["dive.toml", "do.txt"]


def test_runs_may_lie_beside_the_packages(dive: Dive, dives: Path) -> None:
    dive("kestrel")
    assert run_fleet(dives, dives / "runs").exit_code == 0
    assert run_fleet(dives, dives / "runs").skipped == ()


def test_a_wrong_folder_of_dives_is_said_and_leaves_no_runs(
    tmp_path: Path, runs: Path, dive: Dive
) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "empty").mkdir()
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(InputError, match="cannot be read: Too many levels"):
        run_fleet(tmp_path / "loop", runs)
    with pytest.raises(InputError, match="cannot be read: File name too long"):
        run_fleet("x" * 5000, runs)
    with pytest.raises(InputError, match="cannot be read: No such file"):
        run_fleet(tmp_path / "nowhere", runs)
    with pytest.raises(InputError, match="cannot be read: Not a directory"):
        run_fleet(tmp_path / "file", runs)
    with pytest.raises(InputError, match="no dive package"):
        run_fleet(tmp_path / "empty", runs)
    with pytest.raises(InputError, match="this is a package itself"):
        run_fleet(dive("kestrel"), runs)
    assert not runs.exists()


def test_a_second_fleet_gives_way_to_the_first(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel")
    with (
        hold_lock(runs / FOLDER / "lock"),
        pytest.raises(LockedError, match="another fleet is at work here"),
    ):
        run_fleet(dives, runs)
    assert ran(trace) == []
    assert preview_fleet(dives, runs).count("to do") == 1
    assert run_fleet(dives, runs).exit_code == 0  # once the first has ended


def test_a_preview_writes_nothing(dive: Dive, dives: Path, runs: Path, trace: Path) -> None:
    dive("kestrel")
    assert states(preview_fleet(dives, runs)) == {"kestrel": "to do"}
    assert not runs.exists()
    assert ran(trace) == []


def test_a_failed_dive_leaves_its_log_unless_that_is_empty(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel", "fail")
    dive("merlin", "fail silently")
    loud, silent = run_fleet(dives, runs).dives
    assert loud.log == runs / FOLDER / "logs" / "kestrel.log"
    assert silent.log is None
    assert [p.name for p in (runs / FOLDER / "logs").iterdir()] == ["kestrel.log"]


def test_fleet_forgets_packages_that_are_gone(
    dive: Dive, dives: Path, runs: Path, tmp_path: Path
) -> None:
    dive("kestrel")
    dive("merlin")
    other = tmp_path / "others"
    shutil.copytree(dives / "kestrel", other / "osprey")
    (other / "osprey" / "dive.toml").write_text('[dive]\nname = "osprey"\n')
    run_fleet(dives, runs)
    run_fleet(other, runs)
    shutil.rmtree(dives / "kestrel")
    (dives / "merlin" / "more").touch()
    run_fleet(dives, runs)
    kept = records.FleetRecords(runs)
    assert kept.get(dives / "kestrel") is None
    assert kept.get(dives / "merlin") is not None
    assert kept.get(other / "osprey") is not None


def test_damaged_records_cost_a_look_at_each_dive_and_no_more(
    dive: Dive, dives: Path, runs: Path
) -> None:
    dive("kestrel")
    run_fleet(dives, runs)
    path = runs / FOLDER / "dives.json"
    path.write_bytes(path.read_bytes().replace(b'"exit_code": 0', b'"exit_code": 3'))
    assert preview_fleet(dives, runs).dives[0].reason == "new"
    assert run_fleet(dives, runs).exit_code == 0


def test_fleet_ends_at_once_if_no_scheduler_answers(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel")
    with pytest.raises(UsageError, match="not an address of a Dask scheduler"):
        run_fleet(dives, runs, scheduler="nonsense")
    assert ran(trace) == []


FLEET = """
import sys
from hullrecon.api.fleet import processes, run_fleet
processes.PROGRAM = {program!r}
run_fleet({dives!r}, {runs!r}, jobs=2)
"""


def started(
    dives: Path, runs: Path, trace: Path, count: int
) -> tuple[subprocess.Popen[bytes], list[int]]:
    """A fleet in a group of its own of which `count` dives have started, and their processes."""
    code = FLEET.format(program=PROGRAM, dives=str(dives), runs=str(runs))
    fleet = subprocess.Popen(
        [sys.executable, "-c", code], start_new_session=True, stderr=subprocess.DEVNULL
    )
    while len(lines := trace.read_text().splitlines()) < count:
        assert fleet.poll() is None
        time.sleep(0.01)
    return fleet, [int(line.split()[1]) for line in lines]


def gone(process: int) -> bool:
    """Whether a process has ended; one that nobody has waited for counts as ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("group", [True, False], ids=["group", "parent alone"])
def test_killed_fleet_leaves_no_process_and_resumes(
    number: int, group: bool, dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("a")
    packages = [dive("b", "wait"), dive("c", "wait")]
    dive("d")
    fleet, processes_of_dives = started(dives, runs, trace, 3)
    (os.killpg if group else os.kill)(fleet.pid, number)
    assert fleet.wait(60) != 0
    until = time.monotonic() + 60
    while not all(map(gone, processes_of_dives)):
        assert time.monotonic() < until
        time.sleep(0.01)
    trace.write_text("")
    for package in packages:
        (package / "do.txt").write_text("deliver")
    result = run_fleet(dives, runs)
    assert (result.exit_code, result.count("delivered", "up to date")) == (0, 4)
    assert set(ran(trace)) >= {"b", "c", "d"}
    assert states(run_fleet(dives, runs)) == dict.fromkeys("abcd", "up to date")


def test_dive_beyond_time_limit_is_ended_alone(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel"), dive("merlin", "wait"), dive("osprey")
    result = run_fleet(dives, runs, jobs=1, time_limit_s=5.0)
    assert states(result) == {"kestrel": "delivered", "merlin": "failed", "osprey": "delivered"}
    (late,) = [d for d in result.dives if d.state == "failed"]
    assert (late.exit_code, result.exit_code) == (4, 4)
    assert "longer than 5 s (--time-limit)" in late.line()
    pid = next(
        line.split()[1] for line in trace.read_text().splitlines() if line.startswith("merlin")
    )
    assert not Path(f"/proc/{pid}").exists()
    # not again with no more time
    assert states(preview_fleet(dives, runs, time_limit_s=5.0))["merlin"] == "failed"
    assert states(preview_fleet(dives, runs, time_limit_s=6.0))["merlin"] == "to do"
    assert states(preview_fleet(dives, runs))["merlin"] == "to do"


def test_fleet_may_allow_files_outside_packages(
    dive: Dive, dives: Path, runs: Path, trace: Path
) -> None:
    dive("kestrel", "read outside"), dive("merlin")
    assert states(run_fleet(dives, runs)) == {"kestrel": "failed", "merlin": "delivered"}
    assert states(run_fleet(dives, runs)) == {"kestrel": "failed", "merlin": "up to date"}
    assert states(run_fleet(dives, runs, allow_outside=True)) == {
        "kestrel": "delivered",
        "merlin": "up to date",
    }
    assert ran(trace) == ["kestrel", "kestrel", "merlin"]


def test_index_names_every_dive_during_and_after_the_run(
    dives: Path, runs: Path, dive: Dive
) -> None:
    dive("a")
    dive("b", "fail")
    seen: list[str] = []
    run_fleet(dives, runs, on_failure=lambda _: seen.append((runs / "index.html").read_text()))
    assert "1 running" in seen[0]
    after = (runs / "index.html").read_text()
    assert "2 dives: 1 failed, 1 done" in after
    assert "too few" in after
