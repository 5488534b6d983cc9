# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The version of hullrecon, stated in pyproject.toml alone, and the commit that runs."""

from __future__ import annotations

import os
import subprocess
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_CHECKOUT = _PACKAGE.parent  # of an editable installation; of a wheel, site-packages
_GIT_S = 10  # longer than any `git describe` takes
_DESCRIBE = ("git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude", "*")


@cache
def version() -> str:
    """Return the version: of the checkout's pyproject.toml, else of the installed wheel."""
    if (_CHECKOUT / "pyproject.toml").is_file():
        import tomllib

        project = tomllib.loads((_CHECKOUT / "pyproject.toml").read_text("utf-8"))["project"]
        return str(project["version"])
    from importlib.metadata import version as installed_version

    return installed_version("hullrecon")


@cache
def commit() -> str:
    """Return the commit that runs, with `-dirty` where files differ from it. Empty if not known.

    A checkout asks git. A wheel knows the commit that it was built from, if git was there then.
    """
    if (_CHECKOUT / ".git").exists():
        clean = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
        try:
            return subprocess.run(
                _DESCRIBE,
                cwd=_CHECKOUT,
                env=clean,
                capture_output=True,
                text=True,
                timeout=_GIT_S,
                check=True,
            ).stdout.strip()
        except (OSError, subprocess.SubprocessError):
            return ""
    built = _PACKAGE / "commit.txt"
    return built.read_text("utf-8").strip() if built.is_file() else ""


def describe() -> str:
    """Return version and commit in one line, as `hullrecon --version` prints them."""
    return f"{version()} (commit {commit() or 'not known: built without git'})"
