# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Packages, and a program whose steps take no time but depend on each other as the real ones do."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from hullrecon.steps.chain import stages

HERE = Path(__file__).parent
PIPELINES = HERE.parents[1] / "pipelines"
DIVE_TOML = """
[dive]
name = "{name}"
[logs]
files = ["log.mcap"]
[topics]
dvl = "/dvl"
"""
NEED_CAMERA = {"features", "links", "matches", "mosaic-optical"}
CAMERA = """
[camera.top]
calibration = "camera.yaml"
"""


@pytest.fixture(scope="session")
def pipelines() -> Path:
    return PIPELINES


@pytest.fixture(scope="session")
def make_package() -> Callable[[Path, str], Path]:
    def make(folder: Path, name: str, *, camera: bool = False) -> Path:
        folder.mkdir(parents=True)
        (folder / "dive.toml").write_text(DIVE_TOML.format(name=name) + (CAMERA if camera else ""))
        (folder / "log.mcap").write_bytes(b"log")
        if camera:
            (folder / "camera.yaml").write_text("image_width: 4\n")
        return folder

    return make


@pytest.fixture(scope="session")
def toy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of an executable that stands for hullrecon, and of its steps."""
    folder = tmp_path_factory.mktemp("toy")
    steps = [[s.name, s.inputs, s.optional, s.name in NEED_CAMERA] for s in stages()]
    (folder / "steps.json").write_text(json.dumps(steps))
    path = folder / "hullrecon"
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{HERE / "program.py"}" "$@"\n')
    path.chmod(0o755)
    return folder


@pytest.fixture
def trace(tmp_path: Path, toy: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Gets the name of each step that runs."""
    path = tmp_path / "trace.txt"
    path.touch()
    monkeypatch.setenv("TOY_TRACE", str(path))
    monkeypatch.setenv("TOY_STEPS", str(toy / "steps.json"))
    return path


@pytest.fixture
def program(toy: Path, trace: Path) -> Path:
    """An executable that stands for hullrecon."""
    return toy / "hullrecon"


@pytest.fixture(scope="session")
def call() -> Callable[..., subprocess.CompletedProcess[str]]:
    def call(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
        # under `make test` an outer make's flags would print the folders it enters
        options.setdefault(
            "env",
            {k: v for k, v in os.environ.items() if not k.startswith("MAKE") and k != "MFLAGS"},
        )
        return subprocess.run(
            [str(a) for a in arguments], capture_output=True, text=True, check=False, **options
        )  # type: ignore[call-overload,no-any-return]

    return call
