# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The finished run that is read: RUNS/<dive> by --run, `make demo`'s if absent."""

import json
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent


def pytest_addoption(parser):
    parser.addoption(
        "--run",
        type=Path,
        default=HERE.parents[1] / "out" / "demo",
        help="RUNS/<dive> of a finished dive",
    )
    parser.addoption(
        "--node", type=Path, help="folder of the npm packages and of the scripts that use them"
    )
    parser.addoption("--colmap", type=Path, help="what `hullrecon export colmap` wrote of it")


@pytest.fixture(scope="session")
def deliver(request):
    folder = request.config.getoption("--run") / "deliver"
    assert folder.is_dir(), (
        f"{folder} is not there: `make demo` first, or name a finished run by --run"
    )
    return folder


@pytest.fixture(scope="session")
def node(request):
    """Run a script by Node and return the JSON that it prints; it must print nothing on standard
    error.
    """
    folder = request.config.getoption("--node")
    assert folder is not None, "name the folder of the npm packages by --node"

    def run(script, *arguments):
        done = subprocess.run(
            ["node", folder / script, *arguments], capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, "")
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="session")
def exported(request):
    folder = request.config.getoption("--colmap")
    assert folder is not None, "name what `hullrecon export colmap` wrote by --colmap"
    assert folder.is_dir()
    return folder
