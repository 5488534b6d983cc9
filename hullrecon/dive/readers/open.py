# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which reader a log needs, by what lies in it, not by its name."""

from __future__ import annotations

from pathlib import Path

from hullrecon.dive.readers.mcap import McapLog
from hullrecon.dive.readers.mcap_records import MAGIC
from hullrecon.dive.readers.protocol import Log
from hullrecon.errors import InputError


def open_log(path: Path) -> Log:
    """The log's reader. InputError when nothing lies there, or nothing that any reader knows."""
    try:
        start = _start(path)
    except FileNotFoundError:
        raise InputError(
            f"the log {path.name} is missing{_beside(path)}", where=str(path.parent), remedy="correct logs.files"
        ) from None
    except OSError as error:
        raise InputError(f"the log {path.name} cannot be read: {error.strerror}", where=str(path.parent)) from None
    if not start:
        raise InputError(f"the log {path.name} is empty", where=str(path.parent))
    if start.startswith(MAGIC):
        return McapLog(path)
    raise InputError(
        f"{path.name} is no log that is read here", where=str(path.parent),
        remedy="give an MCAP, a ROS 1 bag, a ROS 2 folder, a PD0 file or a folder of CSVs",
    )  # fmt: skip


def _start(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(64)


def _beside(path: Path) -> str:
    names = sorted(p.name for p in path.parent.iterdir())[:6] if path.parent.is_dir() else []
    return f" (there are {', '.join(names)})" if names else ""
