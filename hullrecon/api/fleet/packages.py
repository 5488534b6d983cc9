# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the dive packages of a folder and read their names.

The folder is written by others. Names are data; links that leave it are not followed; nothing but a
regular file is opened.
"""

from __future__ import annotations

import os
import stat
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import get_type_hints

import msgspec

from hullrecon.dive.config.schema import Dive
from hullrecon.dive.files import special_kind
from hullrecon.errors import InputError, UsageError

FILE = "dive.toml"
# The TOML parser takes minutes for a key of ten thousand parts (143 s for 64 KiB), and it runs in
# the fleet's own process.
MAX_BYTES = 65_536
MAX_DOTS = 200
NAME_TYPE = get_type_hints(Dive, include_extras=True)["name"]


@dataclass(frozen=True, kw_only=True)
class Skipped:
    """What lies where dives lie and is not looked at, with the reason."""

    path: Path
    reason: str


def find_packages(dives: Path) -> tuple[list[Path], list[Skipped]]:
    """Return the folders in `dives`, an absolute path without links, that hold a dive.toml, and
    what is skipped; by name.

    Regular files are neither. Raises InputError when the folder cannot be listed.
    """
    try:
        entries = sorted(os.scandir(dives), key=lambda entry: os.fsencode(entry.name))
    except OSError as error:
        raise InputError(
            f"the folder of dives cannot be read: {error.strerror}", where=str(dives)
        ) from None
    own = [entry for entry in entries if not entry.is_symlink()]
    packages, skipped = dict[Path, None](), list[Skipped]()
    for entry in [*own, *(entry for entry in entries if entry.is_symlink())]:
        path = dives / entry.name
        reason = _why_not(entry, path, dives, packages)
        if reason:
            skipped.append(Skipped(path=path, reason=reason))
        elif reason is None:
            packages[Path(os.path.realpath(path))] = None
    return sorted(packages, key=os.fsencode), sorted(skipped, key=lambda s: os.fsencode(s.path))


def _why_not(
    entry: os.DirEntry[str], path: Path, dives: Path, packages: dict[Path, None]
) -> str | None:
    """Return why an entry is skipped, empty where that needs no word; None for a package."""
    if entry.is_symlink():
        target = Path(os.path.realpath(path))
        if not target.is_relative_to(dives) or target == dives:
            return "a link that leaves the folder of dives"
        if target in packages:
            return "a link to another dive here"
    if not entry.is_dir():
        kind = special_kind(entry.stat(follow_symlinks=False).st_mode)
        return f"{kind}, not opened" if kind else ""
    return (
        None
        if os.path.lexists(path / FILE) or not os.access(path, os.X_OK)
        else f"it holds no {FILE}"
    )


def read_name(package: Path, dives: Path) -> str | None:
    """Return the dive's name; None where dive.toml is not valid, which `hullrecon status` explains
    better.

    Raises InputError where dive.toml is no regular file inside `dives`, UsageError where it is too
    large to be one.
    """
    data = _read(package / FILE, dives)
    if len(data) > MAX_BYTES:
        raise UsageError(f"{FILE} has more than {MAX_BYTES} bytes", where=str(package))
    if max((line.count(b".") for line in data.splitlines()), default=0) > MAX_DOTS:
        raise UsageError(f"{FILE} has a line with more than {MAX_DOTS} dots", where=str(package))
    try:
        return str(msgspec.convert(tomllib.loads(data.decode())["dive"]["name"], NAME_TYPE))
    except (ValueError, LookupError, TypeError, RecursionError):
        return None


def _read(path: Path, dives: Path) -> bytes:
    """Return at most MAX_BYTES + 1 bytes of a file. Opening does not wait for a FIFO's writer."""
    if not Path(os.path.realpath(path)).is_relative_to(dives):
        raise InputError(
            f"{FILE} is a link that leaves the folder of dives", where=str(path.parent)
        )
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise InputError(f"{FILE} is no regular file", where=str(path.parent))
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(
            f"{FILE} cannot be read: {error.strerror}", where=str(path.parent)
        ) from None


def same_names(names: dict[Path, str | None]) -> Iterator[tuple[Path, list[Path]]]:
    """Yield each package whose dive has the name of another's, with those others."""
    for package, name in names.items():
        others = [other for other, theirs in names.items() if theirs == name and other != package]
        if name is not None and others:
            yield package, others
