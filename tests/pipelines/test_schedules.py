# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pipelines/: the cron line, the systemd units and the Dask launch do what they say."""

from __future__ import annotations

import os
import re
import shutil
import socket
import sys
from pathlib import Path

import pytest


@pytest.fixture
def home(tmp_path: Path, pipelines: Path, program: Path) -> Path:
    """A folder as the schedules expect it: pipelines/ and .venv/bin/hullrecon."""
    folder = tmp_path / "home"
    (folder / ".venv" / "bin").mkdir(parents=True)
    shutil.copytree(pipelines, folder / "pipelines")
    (folder / ".venv" / "bin" / "hullrecon").symlink_to(program)
    return folder


def toy_steps() -> dict[str, str]:
    """What the toy program needs to know of its steps."""
    return {"TOY_STEPS": os.environ["TOY_STEPS"]}


def cron_command(pipelines: Path) -> str:
    (line,) = [line for line in (pipelines / "fleet.cron").read_text().splitlines() if line.startswith("*")]
    return line.split(maxsplit=6)[6]


@pytest.fixture
def cron(call, pipelines: Path, home: Path, tmp_path: Path):
    """Runs the line as cron does: by sh, with the file's variables and hardly any others."""
    folders = {"DIVES": str(tmp_path / "dives"), "RUNS": str(tmp_path / "runs"), "HULLRECON_HOME": str(home)}
    (tmp_path / "runs").mkdir()

    def run():
        environment = {
            "PATH": "/usr/bin:/bin",
            "HOME": str(tmp_path),
            "TOY_TRACE": os.environ["TOY_TRACE"],
            **toy_steps(),
            **folders,
        }
        return call("/bin/sh", "-c", cron_command(pipelines), env=environment)

    return run


def test_cron_makes_what_is_new_and_prints_nothing(cron, make_package, trace: Path, tmp_path: Path) -> None:
    make_package(tmp_path / "dives" / "a", "kestrel")
    for _ in range(2):
        answer = cron()
        assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert trace.read_text().split().count("report") == 1


def test_cron_gives_way_to_a_run_that_is_under_way(cron, make_package, trace: Path, tmp_path: Path) -> None:
    import fcntl

    make_package(tmp_path / "dives" / "a", "kestrel")
    held = os.open(tmp_path / "runs", os.O_RDONLY)
    fcntl.flock(held, fcntl.LOCK_EX)
    answer = cron()
    os.close(held)
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert trace.read_text() == ""


def test_cron_reports_a_dive_that_cannot_be_run(cron, make_package, tmp_path: Path) -> None:
    package = make_package(tmp_path / "dives" / "a", "kestrel")
    (package / "log.mcap").unlink()
    answer = cron()
    assert answer.returncode == 2
    assert answer.stderr.startswith("a: error: log.mcap is missing")
    assert answer.stderr.count("\n") == 1


def test_the_cron_line_has_five_times_and_no_percent_sign(pipelines: Path) -> None:
    (line,) = [line for line in (pipelines / "fleet.cron").read_text().splitlines() if line.startswith("*")]
    assert re.match(r"(\S+ ){5}hullrecon flock ", line)
    assert "%" not in line


@pytest.fixture
def units(pipelines: Path, home: Path, tmp_path: Path) -> Path:
    """The units with this machine's folders."""
    folder = tmp_path / "units"
    folder.mkdir()
    for name in ("hullrecon-fleet.service", "hullrecon-fleet.timer"):
        text = (pipelines / name).read_text()
        for fixed, here in (("/opt/hullrecon", home), ("/srv/dives", tmp_path / "dives"), ("/srv/runs", tmp_path / "runs")):
            text = text.replace(fixed, str(here))
        (folder / name).write_text(text)
    return folder


def test_systemd_finds_nothing_wrong_with_the_units(call, units: Path) -> None:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("systemd-analyze is not installed")
    answer = call("systemd-analyze", "verify", *sorted(units.iterdir()))
    complaints = [line for line in answer.stderr.splitlines() if "hullrecon-fleet" in line]
    assert (answer.returncode, complaints) == (0, []), answer.stderr


def test_the_services_command_makes_what_is_new_and_prints_nothing(
    call, units: Path, make_package, trace: Path, tmp_path: Path
) -> None:
    make_package(tmp_path / "dives" / "a", "kestrel")
    text = (units / "hullrecon-fleet.service").read_text()
    (command,) = re.findall(r"^ExecStart=(.*)$", text, re.MULTILINE)
    variables = " ".join(re.findall(r"^Environment=(.*)$", text, re.MULTILINE))
    environment = dict(pair.split("=", 1) for pair in variables.split())
    words = [re.sub(r"\$\{(\w+)\}", lambda m: environment[m[1]], word) for word in command.split()]
    answer = call(*words, env={"PATH": "/usr/bin:/bin", "TOY_TRACE": str(trace), **toy_steps(), **environment})
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert trace.read_text().split().count("report") == 1


def test_neither_schedule_runs_as_root_or_replaces_a_crontab(pipelines: Path) -> None:
    assert "\nUser=hullrecon\n" in (pipelines / "hullrecon-fleet.service").read_text()
    text = (pipelines / "fleet.cron").read_text()
    assert "/etc/cron.d/" in text
    assert "crontab pipelines" not in text


def _free_port() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


def test_a_dask_launch_gives_the_same_bytes_and_leaves_no_process(
    call, pipelines: Path, program: Path, make_package, tmp_path: Path
) -> None:
    pytest.importorskip("distributed")
    package = make_package(tmp_path / "package", "kestrel")
    port = _free_port()
    (scratch := tmp_path / "scratch").mkdir()
    environment = os.environ | {"PYTHON": sys.executable, "HULLRECON": str(program), "PORT": port, "TMPDIR": str(scratch)}
    answer = call(pipelines / "dask-launch", 2, "--quiet", "run", package, "--runs", tmp_path / "dask", env=environment)
    assert (answer.returncode, answer.stdout) == (0, ""), answer.stderr
    call(program, "--quiet", "run", package, "--runs", tmp_path / "alone")
    texts = [path.relative_to(tmp_path / "alone") for path in (tmp_path / "alone").rglob("text.txt")]
    assert texts
    for text in texts:
        assert (tmp_path / "dask" / text).read_bytes() == (tmp_path / "alone" / text).read_bytes()
    assert list(scratch.iterdir()) == []
    assert port not in call("ps", "-eo", "args").stdout.replace("ps -eo args", "")


def test_a_dask_launch_passes_the_programs_exit_code(call, pipelines: Path, program: Path, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    environment = os.environ | {"PYTHON": sys.executable, "HULLRECON": str(program), "PORT": _free_port()}
    answer = call(pipelines / "dask-launch", 1, "run", tmp_path, env=environment)
    assert answer.returncode == 3
    assert "no dive.toml" in answer.stderr


def test_a_dask_launch_without_arguments_says_how(call, pipelines: Path) -> None:
    answer = call(pipelines / "dask-launch")
    assert answer.returncode == 2
    assert "dask-launch 4 run" in answer.stderr
