# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""cli.error_reporting: whatever goes wrong ends in one line and the exit code of its kind."""

from __future__ import annotations

import errno
import os
import resource
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from hullrecon_cli.error_reporting import exit_code_of
from hullrecon_cli.fault_file import KEPT, write_fault_file, write_private_file
from hullrecon_cli.state import CallState

from hullrecon.artifacts import progress
from hullrecon.artifacts.stage import Context, Stage

NEVER = (
    "import sys; from hullrecon_cli.start import start;"
    " sys.argv = ['hullrecon', *sys.argv[1:]]; start()"
)


@pytest.fixture(autouse=True)
def state_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "hullrecon"


@pytest.mark.parametrize(
    ("number", "code"),
    [
        (errno.ENOSPC, 6), (errno.EDQUOT, 6), (errno.EROFS, 6), (errno.EACCES, 6), (errno.EFBIG, 6),
        (errno.ENOMEM, 4),
        (errno.ENAMETOOLONG, 2), (errno.ELOOP, 3),
    ],
)  # fmt: skip
def test_system_error_has_its_exit_code_anywhere(
    number: int, code: int, capfd: pytest.CaptureFixture[str], state_home: Path
) -> None:
    assert exit_code_of(OSError(number, os.strerror(number), "/somewhere"), CallState()) == code
    err = capfd.readouterr().err
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert not state_home.exists()


@pytest.mark.parametrize(
    "error",
    [
        MemoryError(),
        ImportError("libx.so: failed to map segment from shared object"),
        RuntimeError("can't start new thread"),
    ],
)
def test_a_lack_of_memory_is_no_internal_error(
    error: Exception, capfd: pytest.CaptureFixture[str]
) -> None:
    assert exit_code_of(error, CallState()) == 4
    assert "the memory ran out" in capfd.readouterr().err


def test_an_error_after_ctrl_c_is_the_interruption(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "_requested", [signal.SIGINT])
    assert exit_code_of(ImportError("initialization failed"), CallState()) == 130
    assert (
        capfd.readouterr().err
        == "error: interrupted: what is finished is kept, run again to go on\n"
    )


@pytest.mark.parametrize("raised", ["ImportError('initialization failed')", "KeyboardInterrupt()"])
def test_ctrl_c_during_an_import_ends_the_process_as_interrupted(raised: str) -> None:
    code = (
        "import os, signal, sys, atexit\n"
        "from hullrecon_cli import main as m\n"
        "from hullrecon_cli.start import start\n"
        "def swallow():\n"
        "    atexit.register(os._exit, 1)\n"
        "    try:\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "    except KeyboardInterrupt:\n"
        f"        raise {raised} from None\n"
        "m.cli.callback = swallow\n"
        "sys.argv = ['hullrecon', 'completion', 'bash']\n"
        "start()\n"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert answer.returncode == 130
    assert (
        answer.stderr.strip() == "error: interrupted: what is finished is kept, run again to go on"
    )


def test_a_ctrl_c_that_a_library_swallows_ends_the_step(
    program,
    package: Path,
    runs: Path,
    toy_stages: tuple[Stage, ...],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(progress, "_requested", [])

    def swallow(context: Context) -> None:
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            context.out.text("words.txt", "none")

    stages = (replace(toy_stages[0], run=swallow), *toy_stages[1:])
    monkeypatch.setattr("hullrecon.steps.chain.stages", lambda: stages)
    answer = program("run", package, "--runs", runs, "--quiet")
    assert answer.code == 130
    assert answer.err.strip() == "error: interrupted: what is finished is kept, run again to go on"
    assert not (runs / "toy" / "ingest").exists()


def test_a_full_standard_output_is_one_line() -> None:
    with Path("/dev/full").open("w") as full:
        answer = subprocess.run(
            [sys.executable, "-c", NEVER, "--version"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert (answer.returncode, answer.stderr) == (6, "error: No space left on device\n")


@pytest.mark.parametrize("limit_gb", [0.5, 1.0, 1.5])
def test_a_small_address_space_is_one_line(limit_gb: float, package: Path, runs: Path) -> None:
    limit = int(limit_gb * 1e9)
    answer = subprocess.run(
        [sys.executable, "-c", NEVER, "run", str(package), "--runs", str(runs), "--quiet"],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )
    assert answer.returncode == 4
    assert answer.stderr.startswith(
        f"error: the address space is limited to {limit_gb:.2f} GB, and a run needs 2.02 GB: "
    )
    assert answer.stderr.count("\n") == 1
    assert not runs.exists()


@pytest.mark.parametrize(
    ("place", "code"),
    [
        ("absent/run.log", 2),
        ("file/run.log", 2),
        ("x" * 300, 2),
        ("/proc/hullrecon.log", 2),
        ("/sys/x.log", 6),
    ],
)
def test_a_log_file_that_cannot_be_is_one_line(
    place: str, code: int, program, package: Path, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    answer = program("status", package, "--log-file", tmp_path / place)
    assert answer.code == code, answer.err
    assert answer.err.startswith("error: the log file cannot be written: ")
    assert answer.err.count("\n") == 1


def test_a_log_file_that_becomes_full_ends_and_the_run_does_not(
    program, package: Path, runs: Path
) -> None:
    answer = program("run", package, "--runs", runs, "--log-file", "/dev/full")
    assert answer.code == 0
    assert answer.err.count("the log file ends here") == 1
    assert "Traceback" not in answer.err


@pytest.mark.parametrize("place", ["/proc/hullrecon", "/dev/null/runs", "file/runs", "x" * 300])
def test_a_runs_folder_that_cannot_be_is_one_line(
    place: str, program, package: Path, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    answer = program("run", package, "--runs", tmp_path / place, "--quiet")
    assert answer.code in (2, 6), answer.err
    assert answer.err.startswith("error: ")
    assert answer.err.count("\n") == 1
    assert "internal" not in answer.err


@pytest.mark.parametrize(
    "command",
    [["run"], ["status"], ["check"], ["evaluate", "x"], ["init"], ["simulate"], ["clean"]],
)
def test_a_name_of_300_characters_is_one_line(command: list[str], program, tmp_path: Path) -> None:
    answer = program(*command, tmp_path / ("x" * 300))
    assert answer.code in (2, 3, 6), answer.err
    assert answer.err.count("\n") == 1
    assert "internal" not in answer.err


def test_traceback_before_a_run_is_in_the_users_state(state_home: Path, tmp_path: Path) -> None:
    path = write_fault_file(ZeroDivisionError("ours"), tmp_path / "runs" / "toy")
    assert path is not None
    assert path.parent == state_home
    assert path.stat().st_mode & 0o777 == 0o600
    assert not (tmp_path / "runs").exists()


def test_a_traceback_names_no_user_and_no_place() -> None:
    home = str(Path.home())
    try:
        subprocess.run([f"{home}/absent"], check=False)
    except FileNotFoundError as error:
        path = write_fault_file(error, None)
    assert path is not None
    text = path.read_text()
    assert "FileNotFoundError" in text
    assert home not in text
    assert sys.base_prefix not in text


def test_no_place_for_a_traceback_is_said(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", "/proc/nowhere")
    assert exit_code_of(ZeroDivisionError("ours"), CallState()) == 1
    assert (
        capfd.readouterr().err
        == "error: internal error; ZeroDivisionError: ours (no place for its traceback)\n"
    )


def test_private_files_are_the_owners_and_few(tmp_path: Path) -> None:
    (tmp_path / "other.txt").touch()
    written = [write_private_file(tmp_path, str(k)) for k in range(KEPT + 3)]
    assert len(set(written)) == KEPT + 3
    assert len(list(tmp_path.glob("fault-*.txt"))) == KEPT
    assert (tmp_path / "other.txt").exists()


def test_private_files_are_not_written_through_a_link(tmp_path: Path) -> None:
    (tmp_path / "victim").mkdir()
    (tmp_path / "logs").symlink_to(tmp_path / "victim")
    with pytest.raises(OSError, match=r"Not a directory|symbolic"):
        write_private_file(tmp_path / "logs", "text")
    assert os.listdir(tmp_path / "victim") == []
