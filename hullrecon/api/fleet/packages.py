# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the dive packages of a folder, read their names, and notice when files change.

The folder may be written by people who are not trusted: links that leave it are not followed, and
only regular files are opened.
"""

from __future__ import annotations

import hashlib
import os
import stat
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import get_type_hints

import msgspec

from hullrecon.dive.config.schema import Dive
from hullrecon.dive.files import special_kind
from hullrecon.errors import HullreconError, InputError, UsageError
from hullrecon.version import version

FILE = "dive.toml"
# Limits of a dive.toml. The TOML parser takes minutes for a key with ten thousand dots (143 s for
# 64 KiB), and it runs in the fleet's own process.
MAX_BYTES = 65_536
MAX_DOTS = 200  # in a line
MADE_BY_RUNS = (".hullrecon", "logs", "quarantine")  # in RUNS/<dive>, next to the artifacts
ABOVE_REMEDY = "choose another folder with --runs"
NAME_TYPE = get_type_hints(Dive, include_extras=True)["name"]


def one_line(text: str) -> str:
    r"""Write characters that are not printable, such as a line's end, as \n or \x1b."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def as_utf8(path: str | os.PathLike[str]) -> str:
    r"""Convert a path to text that can be encoded, with bytes that are not UTF-8 as \xNN."""
    return os.fsencode(path).decode(errors="backslashreplace")


@dataclass(frozen=True, kw_only=True)
class Skipped:
    """An entry of the folder of dives that is not used, with the reason."""

    path: Path
    reason: str


def find_packages(dives: Path) -> tuple[list[Path], list[Skipped]]:
    """Find the folders in `dives` that hold a dive.toml, and the other entries, both by name.

    `dives` is an absolute path without links. Raises InputError when it cannot be listed.
    """
    try:
        entries = sorted(os.scandir(dives), key=lambda entry: os.fsencode(entry.name))
    except OSError as error:
        what = f"the folder of dives cannot be read: {error.strerror}"
        raise InputError(what, where=str(dives)) from None
    packages, skipped = dict[Path, None](), list[Skipped]()
    for entry in sorted(entries, key=os.DirEntry.is_symlink):  # links last: they lead to others
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
    """Say why an entry is skipped. Empty if it needs no mention, None for a package."""
    if entry.is_symlink():
        target = Path(os.path.realpath(path))
        if not target.is_relative_to(dives) or target == dives:
            return "a link that leaves the folder of dives"
        if target in packages:
            return "a link to another dive here"
    if not entry.is_dir():
        kind = special_kind(entry.stat(follow_symlinks=False).st_mode)
        return f"{kind}, not opened" if kind else ""
    if os.path.lexists(path / FILE) or not os.access(path, os.X_OK):
        return None
    return f"it holds no {FILE}"


def read_name(package: Path, dives: Path) -> str | None:
    """Read the dive's name. None if dive.toml is not valid: `hullrecon status` then says why.

    Raises InputError if dive.toml is no regular file inside `dives`, UsageError if it is too large
    or has too many dots in a line.
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
    """Read at most MAX_BYTES + 1 bytes of a file, without waiting for a FIFO's writer."""
    folder = str(path.parent)
    if not Path(os.path.realpath(path)).is_relative_to(dives):
        raise InputError(f"{FILE} is a link that leaves the folder of dives", where=folder)
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise InputError(f"{FILE} is no regular file", where=folder)
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"{FILE} cannot be read: {error.strerror}", where=folder) from None


@dataclass(frozen=True, kw_only=True)
class Listing:
    """A folder as it looks without opening a file."""

    files: tuple[str, ...]  # relative to it
    special: tuple[tuple[str, str], ...]  # its FIFOs, sockets and devices, with what they are
    signature: str  # hash of names, sizes, times and inodes


def list_folder(folder: Path, inside: Path, leave_out: tuple[str, ...] = ()) -> Listing:
    """List a folder. What cannot be read counts as absent.

    `inside`: links to folders are followed only if they lead into this folder. `leave_out`: names
    at the folder's top that do not count.
    """
    files, special, marks = list[str](), list[tuple[str, str]](), hashlib.sha256()
    seen = set[tuple[int, int]]()
    with suppress(OSError):
        seen.add(_identity(folder.stat()))
    for name, status in _walk(str(folder), "", inside, seen, leave_out):
        kind = special_kind(status.st_mode)
        if kind:
            special.append((name, kind))
        elif stat.S_ISREG(status.st_mode):
            files.append(name)
        marks.update(os.fsencode(name) + _mark(status))
    return Listing(files=tuple(files), special=tuple(special), signature=marks.hexdigest())


def program_signature() -> str:
    """Hash names, sizes and times of this program's files. Other code may give other results."""
    package = Path(__file__).parents[2]
    marks = hashlib.sha256(version().encode())
    for path in sorted([*package.rglob("*.py"), *package.glob("*.so")]):
        marks.update(os.fsencode(path.relative_to(package)) + _mark(path.stat()))
    return marks.hexdigest()


def _mark(status: os.stat_result) -> bytes:
    """Encode a file's kind, size, time of modification and inode for a signature."""
    kind = stat.S_IFMT(status.st_mode)
    return b"\0%d %d %d %d\n" % (kind, status.st_size, status.st_mtime_ns, status.st_ino)


def _identity(status: os.stat_result) -> tuple[int, int]:
    """Tell one file or folder from all others by device and inode."""
    return status.st_dev, status.st_ino


def _walk(
    folder: str,
    prefix: str,
    inside: Path,
    seen: set[tuple[int, int]],
    leave_out: tuple[str, ...] = (),
) -> Iterator[tuple[str, os.stat_result]]:
    """Yield each file below a folder, and each link without a target, with its status, by name.

    Links to folders are followed if they lead into `inside`. `seen`: device and inode of the
    folders visited, which are not visited again.
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
        elif _identity(status) not in seen and (
            not entry.is_symlink() or Path(os.path.realpath(entry)).is_relative_to(inside)
        ):
            seen.add(_identity(status))
            yield from _walk(entry.path, f"{name}/", inside, seen)


def _status(entry: os.DirEntry[str]) -> os.stat_result | None:
    """Look up the status of a file or of a link's target, or of a link without a target."""
    for follow in (True, False):
        with suppress(OSError):
            return entry.stat(follow_symlinks=follow)
    return None


def require_packages(dives: Path, runs: Path) -> tuple[list[Path], list[Skipped]]:
    """Find the packages in `dives` and what is skipped.

    Raises InputError when there is no package, UsageError when results would lie among packages.
    """
    packages, skipped = find_packages(dives)
    if not packages:
        is_package = (dives / FILE).exists()
        remedy = f"this is a package itself: `hullrecon run {dives}`" if is_package else ""
        what = f"no dive package (a folder with a {FILE}) lies here"
        raise InputError(what, where=str(dives), remedy=remedy)
    if runs == dives or any(runs.is_relative_to(package) for package in packages):
        what = "results would lie among the packages"
        raise UsageError(what, where=str(runs), remedy=ABOVE_REMEDY)
    return packages, [s for s in skipped if s.path != runs]


def dive_names(
    packages: list[Path], dives: Path, runs: Path
) -> tuple[dict[Path, str | None], dict[Path, HullreconError]]:
    """Read the dives' names, and find the packages that may not be run, with the error of each.

    They are those whose dive.toml may not be read, those that share a name, and those whose results
    would lie above the packages. A name is None where dive.toml is not valid.
    """
    names, refused = dict[Path, str | None](), dict[Path, HullreconError]()
    for package in packages:
        try:
            name = names[package] = read_name(package, dives)
        except HullreconError as error:
            refused[package] = error
            continue
        if name is not None and dives.is_relative_to(runs / name):
            what = f"the results of a dive called {name} would lie above the packages"
            refused[package] = UsageError(what, where=str(package), remedy=ABOVE_REMEDY)
    for package, name in names.items():
        others = [p.name for p, other in names.items() if other == name and p != package]
        if name is not None and others:
            what = f"its dive.name {name} is also that of {', '.join(others)}"
            remedy = "give each dive a name of its own"
            refused[package] = UsageError(what, where=str(package), remedy=remedy)
    return names, refused
