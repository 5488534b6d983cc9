# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the installed command as a user would, on sample_data and on the evaluation data where they
lie.
"""

import shutil
from pathlib import Path

import pytest
from datasets import dataset
from end_to_end.shell import COARSE, SMALL, TINY, Shell

REGIONS = """
[[hull.region]]
name = "after part"
along = [30.0, 32.6]
girth = [4.5, 8.0]

[[hull.region]]
name = "frames 55 to 60"
along = [33.0, 36.0]
girth = [4.0, 6.4]
"""


@pytest.fixture
def shell(tmp_path):
    return Shell(tmp_path)


@pytest.fixture(scope="session")
def evaluation_data():
    return dataset()


@pytest.fixture(scope="session")
def tiny(once):
    """A dive of some seconds, simulated once a session: stereo, sonar, one structure."""
    options = (*TINY, "--leg-length-m", 1.6, "--structures", 1, "--seed", 5)
    return once("tiny", lambda shell: shell("simulate", "tiny", *options)) / "tiny"


@pytest.fixture(scope="session")
def mono_dive(once):
    """A small dive with one camera and regions of its hull, simulated into `package` and run whole
    into `out`, once a session.
    """

    def fill(shell):
        shell("simulate", "package", *SMALL, "--cameras", "mono")
        with (shell.folder / "package" / "dive.toml").open("a") as file:
            file.write(REGIONS)
        shell("run", "package", "--runs", "out", *COARSE)

    return once("mono", fill)


@pytest.fixture
def package(tiny, tmp_path):
    """A copy of the tiny dive that a test may spoil."""
    return Path(shutil.copytree(tiny, tmp_path / "spoiled"))
