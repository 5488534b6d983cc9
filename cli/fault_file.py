# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write the traceback of an internal error to a private file of the run, or of the user."""

from __future__ import annotations

import fnmatch
import os
import re
import secrets
import sys
import time
import traceback
from pathlib import Path

import hullrecon

KEPT = 5  # files of tracebacks in one folder
_HOMES = re.compile(r"/(?:home|Users)/[^/\s\"']+|/root(?=[/\"'])")


def write_fault_file(error: BaseException, workspace: Path | None) -> Path | None:
    """Write the traceback of an error without user names. None if no folder can be written.

    workspace: RUNS/<dive>, where it goes once a run has begun there.
    """
    text = _without_places("".join(traceback.format_exception(error)))
    folders = [_state_folder()]
    if workspace is not None and (workspace / ".hullrecon").is_dir() and not workspace.is_symlink():
        folders.insert(0, workspace / "logs")
    for folder in folders:
        try:
            return write_private_file(folder, text)
        except OSError:
            continue
    return None


def _state_folder() -> Path:
    """Locate the user's folder for the program's state, by the XDG convention."""
    given = os.environ.get("XDG_STATE_HOME", "")
    return (
        Path(given) if os.path.isabs(given) else Path(os.path.expanduser("~/.local/state"))
    ) / "hullrecon"


def _without_places(text: str) -> str:
    """Replace paths that identify the machine or user: installation, current folder, homes."""
    installed = Path(hullrecon.__file__).resolve().parents[1]
    places = {
        str(installed): "<hullrecon>",
        sys.prefix: "<python>",
        sys.base_prefix: "<python>",
        os.getcwd(): ".",
    }
    for place in sorted(places, key=len, reverse=True):
        if len(place) > 1:
            text = text.replace(f"{place}/", f"{places[place]}/")
    return _HOMES.sub("~", text)


def write_private_file(folder: Path, text: str) -> Path:
    """Write `fault-<time>-<random>.txt` for its owner alone, and keep the last few.

    Raises OSError where the folder is a link or cannot be written.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    name = f"fault-{time.strftime('%Y%m%dT%H%M%S')}-{secrets.token_hex(8)}.txt"
    place = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
        with open(
            os.open(name, flags, 0o600, dir_fd=place),
            "w",
            encoding="utf-8",
            errors="backslashreplace",
        ) as file:
            file.write(text)
        for old in sorted(fnmatch.filter(os.listdir(place), "fault-*.txt"))[:-KEPT]:
            os.unlink(old, dir_fd=place)
    finally:
        os.close(place)
    return folder / name
