# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pipelines/setup.sh: nothing is installed into the system that was not announced."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest


@pytest.fixture
def setup(call, pipelines: Path, tmp_path: Path):
    """Runs `setup.sh packages` where no system package is installed and every installer only notes that it was called."""
    tools = tmp_path / "tools"
    tools.mkdir()
    scripts = {"dpkg-query": "exit 1", "id": "echo 0", "apt-get": f"echo called: apt-get $* >> {tmp_path}/calls"}
    for name, body in scripts.items():
        (tools / name).write_text(f"#!/bin/sh\n{body}\n")
        (tools / name).chmod(0o755)
    pip = tmp_path / "venv" / "bin" / "python"
    pip.parent.mkdir(parents=True)
    pip.write_text("#!/bin/sh\n")
    pip.chmod(0o755)

    def run(**variables: str):
        environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "PYTHON": sys.executable, "SETUP_DELAY_S": "0"}
        return call("bash", pipelines / "setup.sh", "packages", tmp_path / "venv", env={**environment, **variables})

    return run


def test_what_will_be_installed_is_listed_with_the_command_before_it_runs(setup, tmp_path: Path) -> None:
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


def test_a_user_without_root_is_told_which_packages_are_missing_and_the_command_for_them(setup, tmp_path: Path) -> None:
    for name, body in (("id", "echo 1000"), ("sudo", "exit 1")):
        (tmp_path / "tools" / name).write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / "tools" / name).chmod(0o755)
    answer = setup()
    assert answer.returncode == 1
    assert "missing: " in answer.stdout + answer.stderr
    (line,) = answer.stderr.splitlines()
    assert "apt-get install -y --no-install-recommends " in line
    assert "libceres-dev" in line
    assert "SKIP_SYSTEM_PACKAGES=1" in line
    assert not (tmp_path / "calls").exists()


def test_a_library_that_is_missing_is_named_when_system_packages_are_skipped(call, pipelines: Path, tmp_path: Path) -> None:
    """Without root and with SKIP_SYSTEM_PACKAGES=1 the build fails: its cause is in the last lines, with what to install."""
    tools = tmp_path / "bin"
    tools.mkdir(parents=True)
    (tools / "python").write_text("#!/bin/sh\necho 'CMake Error: could not find Ceres' >&2\nexit 1\n")
    (tools / "python").chmod(0o755)
    answer = call("bash", pipelines / "setup.sh", "install", tmp_path)
    assert answer.returncode == 1
    assert "could not find Ceres" in answer.stderr
    assert answer.stderr.splitlines()[-1].startswith("setup: hullrecon could not be built")
    assert "libceres-dev" in answer.stderr.splitlines()[-1]


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
    (folder / "pipelines/setup.sh").write_text('mkdir -p "$2"; echo "$1" >> calls\n')
    (folder / "Makefile").write_text((pipelines.parent / "Makefile").read_text())
    return folder


def test_hullrecon_is_installed_again_when_its_modules_have_moved_and_only_then(call, checkout: Path) -> None:
    def installations() -> int:
        answer = call("make", "-C", checkout, "setup")
        assert answer.returncode == 0, answer.stderr
        return (checkout / "calls").read_text().split().count("install")

    assert [installations(), installations()] == [1, 1]
    (checkout / "hullrecon" / "old.py").write_text("changed = True\n")
    assert installations() == 1
    (checkout / "hullrecon" / "folder").mkdir()
    (checkout / "hullrecon" / "old.py").rename(checkout / "hullrecon" / "folder" / "new.py")
    assert [installations(), installations()] == [2, 2]
    (checkout / "cli" / "more.py").touch()
    assert installations() == 3


def test_make_alone_sets_up(call, checkout: Path) -> None:
    assert call("make", "-C", checkout).returncode == 0
    assert (checkout / "calls").read_text().split() == ["packages", "install"]
