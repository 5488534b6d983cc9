# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the installed command as a user would, on sample_data and on the evaluation data where they lie."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "sample_data" / "demo"


class Shell:
    """The command `hullrecon`, in a folder of its own."""

    def __init__(self, folder):
        self.folder = folder
        self.program = Path(sys.executable).parent / "hullrecon"

    def start(self, *arguments):
        return subprocess.Popen(
            [self.program, *map(str, arguments)], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def __call__(self, *arguments, code=0):
        done = subprocess.run(
            [self.program, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == code, (
            f"exit {done.returncode}, expected {code}:\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
        )
        return done


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
    options = ["--legs", 1, "--leg-length", 1.2, "--image-width", 320, "--image-height", 256, "--seed", 5]
    Shell(folder.parent)("simulate", folder, *options)
    return folder


@pytest.fixture
def package(tiny, tmp_path):
    """A copy of the tiny dive that a test may spoil."""
    return Path(shutil.copytree(tiny, tmp_path / "spoiled"))


def edit(package, old, new):
    """Replaces text of dive.toml, once and for sure."""
    path = package / "dive.toml"
    text = path.read_text()
    assert old in text, f"{old!r} is not in dive.toml"
    path.write_text(text.replace(old, new, 1))


def without_run_blocks(folder):
    """Every file of a run by name, JSON without its volatile `run` block, the report without its time."""
    found = {}
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        name = path.relative_to(folder).as_posix()
        if name.startswith("logs/") or path.name.startswith(".") or path.name == "lock":
            continue
        found[name] = _steady(path)
    return found


def _steady(path):
    if path.name in ("manifest.json", "summary.json"):
        document = json.loads(path.read_text())
        for volatile in ("run", "sha256_self"):
            document.pop(volatile, None)
        return json.dumps(document, sort_keys=True)
    if path.suffix == ".html":
        return "".join(line for line in path.read_text().splitlines() if "data-volatile" not in line)
    return path.read_bytes()
