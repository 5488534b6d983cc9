# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the installed command as a user would, on sample_data and on the evaluation data where they lie."""

import os
import shutil
from pathlib import Path

import pytest
from end_to_end.shell import Shell

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def shell(tmp_path):
    return Shell(tmp_path)


@pytest.fixture(scope="session")
def evaluation_data():
    """The folder of evaluation data, or a skip that says so."""
    folder = Path(os.environ.get("HULLRECON_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no evaluation data at {folder} (set HULLRECON_DATA)")
    return folder


@pytest.fixture(scope="session")
def tiny(tmp_path_factory):
    """A dive of some seconds, simulated once a session: stereo, sonar, one structure."""
    folder = tmp_path_factory.mktemp("tiny") / "tiny"
    options = [
        "--legs",
        1,
        "--leg-length-m",
        1.6,
        "--structures",
        1,
        "--marks",
        0,
        "--image-width",
        320,
        "--image-height",
        256,
        "--seed",
        5,
    ]
    Shell(folder.parent)("simulate", folder, *options)
    return folder


@pytest.fixture
def package(tiny, tmp_path):
    """A copy of the tiny dive that a test may spoil."""
    return Path(shutil.copytree(tiny, tmp_path / "spoiled"))
