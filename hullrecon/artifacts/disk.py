# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The one place that changes files in RUNS: durable files, folders renamed whole, errors of the
disk explained.
"""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from hullrecon.errors import StorageError

_ELSEWHERE = "choose another folder (of results: with --runs)"
_REMEDIES = {
    errno.ENOSPC: f"free some space there, or {_ELSEWHERE}, and run again: what is finished is kept",
    errno.EDQUOT: "the quota is used up: free some space there and run again, what is finished is kept",
    errno.EFBIG: f"this file system takes no file of that size: {_ELSEWHERE}",
    errno.EROFS: f"the file system is read-only: {_ELSEWHERE}",
    errno.EACCES: f"write permission is missing: {_ELSEWHERE}",
    errno.EPERM: f"write permission is missing: {_ELSEWHERE}",
    errno.ENOTDIR: f"a file lies where a folder is needed: {_ELSEWHERE}",
    errno.EEXIST: f"a file lies where a folder is needed: {_ELSEWHERE}",
    errno.ELOOP: "a symbolic link lies where the run keeps a file of its own: remove it",
    errno.ENAMETOOLONG: f"the name is too long: {_ELSEWHERE}",
}
_AT_FDCWD = -100
_RENAME_EXCHANGE = 2
_NO_EXCHANGE = {errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EXDEV}
_NO_COPY_RANGE = _NO_EXCHANGE | {errno.EBADF, errno.EPERM}
_COPY_BYTES = 1 << 30


@contextmanager
def storage_errors(folder: Path, only_below: Path | None = None) -> Iterator[None]:
    """Turn a full, read-only or forbidden disk into a StorageError that names the folder.

    only_below: an error that names a file outside that folder is not ours and passes.
    """
    try:
        yield
    except OSError as error:
        remedy = _REMEDIES.get(error.errno or 0)
        foreign = (
            only_below is not None
            and error.filename is not None
            and not Path(error.filename).is_relative_to(only_below)
        )
        if remedy is None or foreign:
            raise
        raise StorageError(
            f"cannot write: {os.strerror(error.errno or 0)}", where=str(folder), remedy=remedy
        ) from error


@contextmanager
def durable_file(path: Path) -> Iterator[BinaryIO]:
    """Open a new binary file under a temporary name; on leaving it is synced and renamed to `path`,
    and the folder synced.
    """
    temporary = temporary_name(path)
    with storage_errors(path.parent):
        make_folder(path.parent)
        temporary.unlink(missing_ok=True)
        try:
            # made anew: a link that lies under that name is not followed
            with open(temporary, "xb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
        except BaseException:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
            raise
        os.replace(temporary, path)
        sync_folder(path.parent)


def write_file(path: Path, data: bytes) -> None:
    """Write all of `data` to `path`, durably, or leave `path` as it was."""
    with durable_file(path) as file:
        file.write(data)


@contextmanager
def durable_path(path: Path) -> Iterator[Path]:
    """Give a temporary path, of the same suffix, for a library to write a file or a folder to;
    synced and renamed on leaving.
    """
    temporary = temporary_name(path)
    with storage_errors(path.parent):
        make_folder(path.parent)
        remove(temporary)
        try:
            yield temporary
            sync_tree(temporary)
        except BaseException:
            with suppress(OSError):
                remove(temporary)
            raise
        os.replace(temporary, path)
        sync_folder(path.parent)


def temporary_name(path: Path) -> Path:
    return path.with_name(f".tmp-{path.name}")


def make_folder(path: Path) -> None:
    """Create the folder and its parents, and sync each parent that got a new entry."""
    with storage_errors(path):
        missing = [p for p in (path, *path.parents) if not p.exists()]
        try:
            path.mkdir(parents=True, exist_ok=True)
        except FileNotFoundError as error:  # a place that takes no folders, such as /proc
            raise StorageError(
                f"cannot write: {error.strerror}", where=str(path), remedy=_REMEDIES[errno.EACCES]
            ) from error
        for created in missing:
            sync_folder(created.parent)


def copy_file(source: Path, target: Path) -> None:
    """Copy a file's bytes to a new file: editing one leaves the other.

    Where the file system can (Btrfs, XFS), the two share their blocks until one of them is written.
    """
    with open(source, "rb") as original, open(target, "xb") as copy:
        try:
            while os.copy_file_range(original.fileno(), copy.fileno(), _COPY_BYTES):
                pass
        except OSError as error:
            if error.errno not in _NO_COPY_RANGE:
                raise
            shutil.copyfileobj(original, copy)


def sync_folder(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_tree(path: Path) -> None:
    """Sync a file, or every file and folder below a folder; FileNotFoundError when nothing was
    written.
    """
    if not path.is_dir():
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        return
    for entry in sorted(path.iterdir()):
        sync_tree(entry)
    sync_folder(path)


def remove(path: Path) -> None:
    """Remove a file or a folder with all it holds; nothing there is fine."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def commit_folder(built: Path, final: Path) -> None:
    """Put the folder `built` at `final` in one step; what was there is removed afterwards.

    Linux swaps two folders in one call. Where the file system cannot (NFS), the old folder is first
    set aside under the name that `set_aside` gives and that `recover` and `present` know.
    """
    with storage_errors(final.parent):
        make_folder(final.parent)
        old = built
        if not os.path.lexists(final):
            os.rename(built, final)
        elif not exchange(built, final):
            old = set_aside(final)
            os.rename(final, old)
            os.rename(built, final)
        sync_folder(final.parent)
        remove(old)


def set_aside(final: Path) -> Path:
    return final.with_name(f".old-{final.name}")


def existing_folder(final: Path) -> Path:
    """Return where the folder lies: under its name or, when a commit without swap was cut short,
    beside it.
    """
    return set_aside(final) if not final.exists() and set_aside(final).exists() else final


def recover(final: Path) -> None:
    """End a commit that was cut short: the old folder returns when the new one never came, else it
    goes.
    """
    old = set_aside(final)
    with storage_errors(final.parent):
        if old.exists() and not final.exists():
            os.rename(old, final)
        remove(old)


def exchange(first: Path, second: Path) -> bool:
    """Swap two folders in one call; False when this system or file system has no such call."""
    renameat2 = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if renameat2 is None:
        return False
    if (
        renameat2(_AT_FDCWD, os.fsencode(first), _AT_FDCWD, os.fsencode(second), _RENAME_EXCHANGE)
        == 0
    ):
        return True
    number = ctypes.get_errno()
    if number in _NO_EXCHANGE:
        return False
    raise OSError(number, os.strerror(number), str(second))
