# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pipelines/: the cron line, the systemd units and the Dask launch do what they say."""

from __future__ import annotations

import os
import re
import shutil
import socket
import sys
import time
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


def with_folders(text: str, home: Path, tmp_path: Path) -> str:
    """The text with this test's folders in place of those that one sets."""
    for fixed, here in (
        ("/opt/hullrecon", home),
        ("/srv/dives", tmp_path / "dives"),
        ("/srv/runs", tmp_path / "runs"),
    ):
        text = text.replace(fixed, str(here))
    return text


@pytest.fixture
def cron(call, pipelines: Path, home: Path, tmp_path: Path):
    """Runs the line as cron does: by sh, with hardly any variables."""
    (tmp_path / "runs").mkdir()
    (line,) = [
        line for line in (pipelines / "fleet.cron").read_text().splitlines() if line.startswith("*")
    ]
    command = with_folders(line.split(maxsplit=5)[5], home, tmp_path)

    def run():
        toy = {"TOY_TRACE": os.environ["TOY_TRACE"], **toy_steps()}
        return call(
            "/bin/sh", "-c", command, env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path), **toy}
        )

    return run


def test_cron_makes_what_is_new_and_prints_nothing(
    cron, make_package, trace: Path, tmp_path: Path
) -> None:
    make_package(tmp_path / "dives" / "a", "kestrel")
    for _ in range(2):
        answer = cron()
        assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert trace.read_text().split().count("report") == 1


def test_cron_gives_way_to_a_run_that_is_under_way(
    cron, make_package, trace: Path, tmp_path: Path
) -> None:
    import fcntl

    make_package(tmp_path / "dives" / "a", "kestrel")
    held = os.open(tmp_path / "runs", os.O_RDONLY)
    fcntl.flock(held, fcntl.LOCK_EX)
    answer = cron()
    os.close(held)
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert trace.read_text() == ""


def test_cron_mails_a_dive_that_cannot_be_run_once(cron, make_package, tmp_path: Path) -> None:
    package = make_package(tmp_path / "dives" / "a", "kestrel")
    (package / "log.mcap").unlink()
    answer = cron()
    assert (answer.returncode, answer.stdout) == (4, "")
    assert answer.stderr.startswith("failed: a: exit code 3: log.mcap is missing")
    assert answer.stderr.count("\n") == 1
    answer = cron()
    assert (answer.returncode, answer.stdout, answer.stderr) == (4, "", "")


def test_the_cron_file_is_lines_of_a_users_crontab(pipelines: Path) -> None:
    lines = (pipelines / "fleet.cron").read_text().splitlines()
    (line,) = [line for line in lines if not line.startswith("#")]
    assert re.match(r"(\S+ ){5}flock ", line)
    assert "%" not in line


def test_the_cron_line_is_appended_to_a_crontab_as_the_file_says(
    call, pipelines: Path, home: Path, tmp_path: Path
) -> None:
    text = (pipelines / "fleet.cron").read_text()
    (command,) = re.findall(r"sudo -u hullrecon sh -c '(.*)'", text)
    tool = tmp_path / "tools" / "crontab"
    tool.parent.mkdir()
    tool.write_text(
        f'#!/bin/sh\n[ "$1" = -l ] && exec cat {tmp_path}/table\n'
        f'new=$(cat)\necho "$new" > {tmp_path}/table\n'
    )
    tool.chmod(0o755)
    (tmp_path / "table").write_text("0 3 * * * backup\n")
    command = with_folders(command, home, tmp_path)
    answer = call("/bin/sh", "-c", command, env={"PATH": f"{tool.parent}:/usr/bin:/bin"})
    assert (answer.returncode, answer.stderr) == (0, "")
    assert (tmp_path / "table").read_text() == "0 3 * * * backup\n" + text


@pytest.fixture
def units(pipelines: Path, home: Path, tmp_path: Path) -> Path:
    """The units with this machine's folders."""
    folder = tmp_path / "units"
    folder.mkdir()
    for name in ("hullrecon-fleet.service", "hullrecon-fleet.timer"):
        (folder / name).write_text(with_folders((pipelines / name).read_text(), home, tmp_path))
    return folder


def test_systemd_finds_nothing_wrong_with_the_units(call, units: Path) -> None:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("systemd-analyze is not installed")
    answer = call("systemd-analyze", "verify", *sorted(units.iterdir()))
    complaints = [line for line in answer.stderr.splitlines() if "hullrecon-fleet" in line]
    assert (answer.returncode, complaints) == (0, []), answer.stderr


def test_service_makes_what_is_new_silently(
    call, units: Path, make_package, trace: Path, tmp_path: Path
) -> None:
    make_package(tmp_path / "dives" / "a", "kestrel")
    text = (units / "hullrecon-fleet.service").read_text()
    (command,) = re.findall(r"^ExecStart=(.*)$", text, re.MULTILINE)
    answer = call(
        *command.split(), env={"PATH": "/usr/bin:/bin", "TOY_TRACE": str(trace), **toy_steps()}
    )
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert trace.read_text().split().count("report") == 1


def directives(pipelines: Path) -> dict[str, list[str]]:
    """What the service sets, by name, in order."""
    found: dict[str, list[str]] = {}
    for line in (pipelines / "hullrecon-fleet.service").read_text().splitlines():
        name, equals, value = line.partition("=")
        if equals and not line.startswith("#"):
            found.setdefault(name, []).append(value)
    return found


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("User", ["hullrecon"]), ("NoNewPrivileges", ["true"]), ("CapabilityBoundingSet", [""]),
        ("ProtectSystem", ["strict"]),
        ("ReadWritePaths", ["/srv/runs"]), ("ProtectHome", ["true"]), ("PrivateTmp", ["true"]),
        ("PrivateDevices", ["true"]),
        ("PrivateNetwork", ["true"]), ("RestrictAddressFamilies", ["AF_UNIX"]),
        ("RestrictSUIDSGID", ["true"]),
        ("RestrictNamespaces", ["true"]), ("LockPersonality", ["true"]),
        ("SystemCallArchitectures", ["native"]),
        ("SystemCallFilter", ["@system-service", "~@privileged @mount @debug"]),
        ("OOMPolicy", ["continue"]),
        ("KillMode", ["control-group"]),
    ],
)  # fmt: skip
def test_the_service_is_hardened(name: str, values: list[str], pipelines: Path) -> None:
    assert directives(pipelines)[name] == values


def test_the_services_exposure_is_at_most_three_of_ten(call, pipelines: Path) -> None:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("systemd-analyze is not installed")
    unit = pipelines / "hullrecon-fleet.service"
    answer = call("systemd-analyze", "security", "--offline=true", "--threshold=30", unit)
    assert answer.returncode == 0, answer.stdout


def _free_port() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


def test_dask_launch_gives_same_bytes_leaves_no_process(
    call, pipelines: Path, program: Path, make_package, tmp_path: Path
) -> None:
    pytest.importorskip("distributed")
    package = make_package(tmp_path / "package", "kestrel")
    port = _free_port()
    (scratch := tmp_path / "scratch").mkdir()
    environment = os.environ | {
        "PYTHON": sys.executable,
        "HULLRECON": str(program),
        "PORT": port,
        "TMPDIR": str(scratch),
    }
    answer = call(
        pipelines / "dask-launch",
        2,
        "--quiet",
        "run",
        package,
        "--runs",
        tmp_path / "dask",
        env=environment,
    )
    assert (answer.returncode, answer.stdout) == (0, ""), answer.stderr
    call(program, "--quiet", "run", package, "--runs", tmp_path / "alone")
    texts = [
        path.relative_to(tmp_path / "alone") for path in (tmp_path / "alone").rglob("text.txt")
    ]
    assert texts
    for text in texts:
        assert (tmp_path / "dask" / text).read_bytes() == (tmp_path / "alone" / text).read_bytes()
    assert list(scratch.iterdir()) == []
    assert port not in call("ps", "-eo", "args").stdout.replace("ps -eo args", "")


def test_a_dask_launch_passes_the_programs_exit_code(
    call, pipelines: Path, program: Path, tmp_path: Path
) -> None:
    pytest.importorskip("distributed")
    environment = os.environ | {
        "PYTHON": sys.executable,
        "HULLRECON": str(program),
        "PORT": _free_port(),
    }
    answer = call(pipelines / "dask-launch", 1, "run", tmp_path, env=environment)
    assert answer.returncode == 3
    assert "no dive.toml" in answer.stderr


def test_dask_launch_kills_a_worker_that_does_not_end(
    call, pipelines: Path, program: Path, tmp_path: Path
) -> None:
    """A worker that is told to end while it starts has been seen to go on for ever."""
    deaf = tmp_path / "deaf"
    sleep = f"sleep 1{os.getpid()}"  # of this test alone: they would be in the way of no other
    deaf.write_text(f"#!/bin/bash\ntrap '' TERM INT\n{sleep} & {sleep}\n")
    deaf.chmod(0o755)
    environment = os.environ | {
        "PYTHON": str(deaf),
        "HULLRECON": str(program),
        "STOP_TIMEOUT_S": "1",
    }
    answer = call(pipelines / "dask-launch", 1, "run", tmp_path, env=environment, timeout=120)
    assert answer.returncode != 0
    # A process that is killed goes once the system runs it again, late on a machine that is busy
    for _ in range(100):
        processes = call("ps", "-eo", "args").stdout
        if sleep not in processes and str(deaf) not in processes:
            return
        time.sleep(0.2)
    pytest.fail(f"left over: {processes}")


def test_a_dask_launch_without_arguments_says_how(call, pipelines: Path) -> None:
    answer = call(pipelines / "dask-launch")
    assert answer.returncode == 2
    assert "dask-launch 4 run" in answer.stderr
