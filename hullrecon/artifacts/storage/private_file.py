# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A file that nobody else can guess, read or put a link in the place of; the last few of a kind are
kept.
"""

from __future__ import annotations

import os
import secrets
import time
from pathlib import Path

KEPT = 5


def write_private_file(folder: Path, kind: str, text: str) -> Path:
    """Write `<kind>-<time>-<random>.txt` for its owner alone, remove all but the last of that kind,
    and return its path.

    Raises OSError where the folder is a link or cannot be written.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    name = f"{kind}-{time.strftime('%Y%m%dT%H%M%S')}-{secrets.token_hex(8)}.txt"
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
        for old in sorted(entry for entry in os.listdir(place) if _is_of_kind(entry, kind))[:-KEPT]:
            os.unlink(old, dir_fd=place)
    finally:
        os.close(place)
    return folder / name


def _is_of_kind(name: str, kind: str) -> bool:
    return name.startswith(f"{kind}-") and name.endswith(".txt")
