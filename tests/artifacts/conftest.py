# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The toy chain, a package for it, and an empty workspace."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from hullrecon.artifacts.workspace import Workspace

TOY = Path(__file__).with_name("toy_chain.py")


@pytest.fixture(scope="session")
def toy() -> ModuleType:
    spec = importlib.util.spec_from_file_location("toy_chain", TOY)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["toy_chain"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def package(toy: ModuleType, tmp_path: Path) -> Path:
    folder: Path = toy.make_package(tmp_path / "package")
    return folder


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    return Workspace(tmp_path / "runs" / "dive")


@pytest.fixture
def read_only_folder(tmp_path: Path) -> Path:
    """A folder where nobody, not even root, may write."""
    folder = tmp_path / "read-only"
    folder.mkdir(mode=0o555)
    try:
        (folder / "probe").touch()
    except PermissionError:
        return folder
    if not Path("/sys/kernel").is_dir():
        pytest.skip("root may write everywhere here")
    return Path("/sys/kernel")
