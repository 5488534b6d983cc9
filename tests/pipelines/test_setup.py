# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pipelines/setup.sh: nothing is installed into the system that was not announced."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest


def script(path: Path, body: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)


@pytest.fixture
def tools(tmp_path: Path) -> Path:
    """Programs before the system's: no system package is installed, and every installer only notes
    that it was called.
    """
    folder = tmp_path / "tools"
    for name, body in (
        ("dpkg-query", "exit 1"), ("id", "echo 0"),
        ("apt-get", f"echo called: apt-get $* >> {tmp_path}/calls"),
    ):  # fmt: skip
        script(folder / name, body)
    return folder


@pytest.fixture
def setup(call, pipelines: Path, tools: Path, tmp_path: Path):
    """Runs `setup.sh packages`, or another of its commands, with those tools, on Debian."""
    script(tmp_path / "venv" / "bin" / "python", "")
    (tmp_path / "os-release").write_text(
        'PRETTY_NAME="Debian GNU/Linux 12 (bookworm)"\nID=debian\n'
    )
    ours = {
        "PYTHON": sys.executable,
        "SETUP_DELAY_S": "0",
        "OS_RELEASE": str(tmp_path / "os-release"),
    }

    def run(command: str = "packages", **variables: str):
        environment = {k: v for k, v in os.environ.items() if k != "SKIP_SYSTEM_PACKAGES"}
        environment |= {"PATH": f"{tools}:{os.environ['PATH']}", **ours, **variables}
        return call("bash", pipelines / "setup.sh", command, tmp_path / "venv", env=environment)

    return run


def test_setup_lists_packages_and_command_before_it_runs(setup, tmp_path: Path) -> None:
    answer = setup()
    assert answer.returncode == 0, answer.stderr
    lines = answer.stdout.splitlines()
    assert lines[0].startswith("setup: these system packages are missing: ")
    assert "libceres-dev" in lines[0]
    assert "apt-get install -y --no-install-recommends " in lines[1]
    assert "SKIP_SYSTEM_PACKAGES=1" in lines[2]
    assert "libceres-dev" in (tmp_path / "calls").read_text()


def test_system_packages_can_be_skipped(setup, tmp_path: Path) -> None:
    answer = setup(SKIP_SYSTEM_PACKAGES="1")
    assert (answer.returncode, answer.stdout) == (0, "")
    assert not (tmp_path / "calls").exists()


def test_user_without_root_is_told_packages_and_command(setup, tools: Path, tmp_path: Path) -> None:
    script(tools / "id", "echo 1000")
    script(tools / "sudo", "exit 1")
    answer = setup()
    assert answer.returncode == 1
    assert "missing: " in answer.stdout + answer.stderr
    (line,) = answer.stderr.splitlines()
    assert "apt-get install -y --no-install-recommends " in line
    assert "libceres-dev" in line
    assert "SKIP_SYSTEM_PACKAGES=1" in line
    assert not (tmp_path / "calls").exists()


def test_skipped_packages_name_a_missing_library(call, pipelines: Path, tmp_path: Path) -> None:
    """Without root and with SKIP_SYSTEM_PACKAGES=1 the build fails: its cause is in the last lines,
    with what to install.
    """
    script(tmp_path / "bin" / "python", "echo 'CMake Error: could not find Ceres' >&2\nexit 1")
    answer = call("bash", pipelines / "setup.sh", "install", tmp_path)
    assert answer.returncode == 1
    assert "could not find Ceres" in answer.stderr
    assert answer.stderr.splitlines()[-1].startswith("setup: hullrecon could not be built")
    assert "libceres-dev" in answer.stderr.splitlines()[-1]


def test_a_browser_is_no_package_of_the_set_up_itself(setup, tmp_path: Path) -> None:
    answer = setup("packages")
    assert "chromium" not in answer.stdout + answer.stderr
    assert "chromium" not in (tmp_path / "calls").read_text()


@pytest.mark.parametrize("name", ["chromium", "google-chrome-stable", "google-chrome"])
def test_a_system_that_has_a_browser_gets_none(
    setup, tools: Path, tmp_path: Path, name: str
) -> None:
    script(tools / "dpkg-query", f'for last; do :; done; [ "$last" = {name} ] && echo installed')
    answer = setup("browser")
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert not (tmp_path / "calls").exists()


def test_a_browser_that_was_removed_is_not_there(setup, tools: Path, tmp_path: Path) -> None:
    """dpkg goes on listing a package whose configuration is left."""
    script(tools / "dpkg-query", "echo config-files")
    assert setup("browser").returncode == 0
    assert "chromium" in (tmp_path / "calls").read_text()


def test_debian_root_is_told_before_a_browser_is_installed(
    setup, tools: Path, tmp_path: Path
) -> None:
    script(tools / "apt-get", f"echo 'apt-get runs'; echo $* >> {tmp_path}/calls")
    answer = setup("browser")
    assert answer.returncode == 0, answer.stderr
    lines = answer.stdout.splitlines()
    assert lines[0] == "setup: running in 0 s: apt-get install -y --no-install-recommends chromium"
    assert "SKIP_SYSTEM_PACKAGES=1" in lines[1]
    assert lines[2:] == ["apt-get runs", "apt-get runs"]
    assert (tmp_path / "calls").read_text().splitlines() == [
        "update -q",
        "install -y --no-install-recommends chromium",
    ]


def without_a_browser(answer, why: str) -> None:
    """Says in one line that tests will be skipped and why, and goes on."""
    assert (answer.returncode, answer.stderr) == (0, "")
    (line,) = answer.stdout.splitlines()
    assert line.startswith("setup: no browser: tests of the report's page will be skipped")
    assert why in line


def test_ubuntu_gets_no_browser_as_chromium_is_a_snap(setup, tmp_path: Path) -> None:
    (tmp_path / "os-release").write_text('NAME="Ubuntu"\nID=ubuntu\nID_LIKE=debian\n')
    without_a_browser(setup("browser"), "install Google Chrome")
    assert not (tmp_path / "calls").exists()


def test_a_user_without_root_is_told_the_command_for_the_browser(
    setup, tools: Path, tmp_path: Path
) -> None:
    """Not by sudo: a password is never asked for what only tests of the page need."""
    script(tools / "id", "echo 1000")
    script(tools / "sudo", f"echo called: sudo $* >> {tmp_path}/calls")
    without_a_browser(
        setup("browser"), "as root: apt-get install -y --no-install-recommends chromium"
    )
    assert not (tmp_path / "calls").exists()


def test_no_browser_when_system_packages_are_skipped(setup, tmp_path: Path) -> None:
    without_a_browser(setup("browser", SKIP_SYSTEM_PACKAGES="1"), "SKIP_SYSTEM_PACKAGES=1")
    assert not (tmp_path / "calls").exists()


@pytest.mark.parametrize("failing", ["update", "install"])
def test_a_browser_that_cannot_be_had_stops_nothing(setup, tools: Path, failing: str) -> None:
    script(tools / "apt-get", f'[ "$1" != {failing} ]')
    answer = setup("browser")
    assert answer.returncode == 0
    assert (
        answer.stdout.splitlines()[-1]
        == "setup: no browser could be installed: tests of the report's page will be skipped"
    )


@pytest.fixture
def checkout(tmp_path: Path, pipelines: Path) -> Path:
    """A checkout whose set-up only notes what it is called with."""
    folder = tmp_path / "checkout"
    for name in (
        "pipelines/setup.sh",
        "requirements.lock",
        "pyproject.toml",
        "hullrecon/old.py",
        "cli/main.py",
        "native/a.cpp",
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()
    (folder / "pipelines/setup.sh").write_text('mkdir -p "${2:-.}"; echo "$1" >> calls\n')
    (folder / "Makefile").write_text((pipelines.parent / "Makefile").read_text())
    return folder


def test_setup_reinstalls_for_native_code_not_moved_modules(call, checkout: Path) -> None:
    def installations() -> int:
        answer = call("make", "-C", checkout, "setup")
        assert answer.returncode == 0, answer.stderr
        return (checkout / "calls").read_text().split().count("install")

    assert [installations(), installations()] == [1, 1]
    (checkout / "hullrecon" / "old.py").write_text("changed = True\n")
    assert installations() == 1
    (checkout / "hullrecon" / "folder").mkdir()
    (checkout / "hullrecon" / "old.py").rename(checkout / "hullrecon" / "folder" / "new.py")
    (checkout / "cli" / "more.py").touch()
    assert installations() == 1
    (checkout / "native" / "a.cpp").write_text("int changed;\n")
    assert [installations(), installations()] == [2, 2]


def test_make_alone_sets_up(call, checkout: Path) -> None:
    assert call("make", "-C", checkout).returncode == 0
    assert (checkout / "calls").read_text().split() == ["packages", "install"]


@pytest.mark.parametrize(
    ("target", "calls"),
    [
        ("test", ["packages", "install", "browser", "python"]),
        ("demo", ["packages", "install", "hullrecon"]),
    ],
)
def test_the_tests_ask_for_a_browser_and_the_demo_does_not(
    call, checkout: Path, target: str, calls: list[str]
) -> None:
    for program in ("python", "hullrecon"):
        script(checkout / ".venv" / "bin" / program, f"echo {program} >> calls")
    answer = call("make", "-C", checkout, target)
    assert answer.returncode == 0, answer.stderr
    assert (checkout / "calls").read_text().split() == calls
