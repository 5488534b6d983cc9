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
