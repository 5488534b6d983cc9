# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""List a folder by name, size, time and inode, so that a later look can tell whether anything
changed. No file is opened.
"""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import hullrecon
from hullrecon.dive.files import special_kind
from hullrecon.version import version

MADE_BY_RUNS = (".hullrecon", "logs", "quarantine")  # in RUNS/<dive>, beside the artifacts


@dataclass(frozen=True, kw_only=True)
class Listing:
    """A folder's files, relative to it, its FIFOs, sockets and devices with what they are, and a
    hash of names, sizes, times and inodes.
    """

    files: tuple[str, ...]
    special: tuple[tuple[str, str], ...]
    signature: str


def list_folder(folder: Path, inside: Path, leave_out: tuple[str, ...] = ()) -> Listing:
    """Return the listing of a folder; what cannot be read counts as absent.

    inside: links to folders are followed inside this one alone. leave_out: names at the folder's
    top that do not count.
    """
    files, special, marks = list[str](), list[tuple[str, str]](), hashlib.sha256()
    for name, status in _walk(str(folder), "", inside, _identity(folder), leave_out):
        kind = special_kind(status.st_mode)
        if kind:
            special.append((name, kind))
        elif stat.S_ISREG(status.st_mode):
            files.append(name)
        marks.update(os.fsencode(name) + b"\0%d %d %d %d\n" % _mark(status))
    return Listing(files=tuple(files), special=tuple(special), signature=marks.hexdigest())


def _identity(folder: Path) -> set[tuple[int, int]]:
    with suppress(OSError):
        status = folder.stat()
        return {(status.st_dev, status.st_ino)}
    return set()


def program_signature() -> str:
    """Return the signature of this program's own code: results made by other code have to be looked
    at again.
    """
    package = Path(hullrecon.__file__).parent
    marks = hashlib.sha256(version().encode())
    for path in sorted([*package.rglob("*.py"), *package.glob("*.so")]):
        marks.update(
            os.fsencode(path.relative_to(package)) + b"\0%d %d %d %d\n" % _mark(path.stat())
        )
    return marks.hexdigest()


def _mark(status: os.stat_result) -> tuple[int, int, int, int]:
    return stat.S_IFMT(status.st_mode), status.st_size, status.st_mtime_ns, status.st_ino


def _walk(
    folder: str,
    prefix: str,
    inside: Path,
    seen: set[tuple[int, int]],
    leave_out: tuple[str, ...] = (),
) -> Iterator[tuple[str, os.stat_result]]:
    """Yield each file below a folder, and each link that has no target, with its status; sorted by
    name.
    """
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: os.fsencode(entry.name))
    except OSError:
        return
    for entry in entries:
        name, status = prefix + entry.name, _status(entry)
        if status is None or entry.name in leave_out:
            continue
        if not stat.S_ISDIR(status.st_mode):
            yield name, status
            continue
        identity = (status.st_dev, status.st_ino)
        if identity not in seen and (
            not entry.is_symlink() or Path(os.path.realpath(entry)).is_relative_to(inside)
        ):
            seen.add(identity)
            yield from _walk(entry.path, f"{name}/", inside, seen)


def _status(entry: os.DirEntry[str]) -> os.stat_result | None:
    """Return the status of a file, of a link the one of its target; that of the link where it has
    none.
    """
    for follow in (True, False):
        with suppress(OSError):
            return entry.stat(follow_symlinks=follow)
    return None
