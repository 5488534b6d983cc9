# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Change files in RUNS: durable files, folders renamed whole, errors of the disk explained."""

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
from hullrecon.threads import in_threads

_ELSEWHERE = "choose another folder (of results: with --runs)"
_REMEDIES = {  # by error number
    errno.ENOSPC: f"free some space there, or {_ELSEWHERE}, and run again: finished steps are kept",
    errno.EDQUOT: "the quota is used up: free some space there and run again",
    errno.EFBIG: f"this file system takes no file of that size: {_ELSEWHERE}",
    errno.EROFS: f"the file system is read-only: {_ELSEWHERE}",
    errno.EACCES: f"write permission is missing: {_ELSEWHERE}",
    errno.EPERM: f"write permission is missing: {_ELSEWHERE}",
    errno.ENOTDIR: f"a file lies where a folder is needed: {_ELSEWHERE}",
    errno.EEXIST: f"a file lies where a folder is needed: {_ELSEWHERE}",
    errno.ELOOP: "a symbolic link lies where the run keeps a file of its own: remove it",
    errno.ENAMETOOLONG: f"the name is too long: {_ELSEWHERE}",
}
_AT_FDCWD, _RENAME_EXCHANGE = -100, 2  # renameat2(2)
# Errors by which a file system says that it has no such call
_NO_EXCHANGE = {errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EXDEV}
_NO_COPY_RANGE = _NO_EXCHANGE | {errno.EBADF, errno.EPERM}
_COPY_BYTES = 1 << 30  # copied by one call


@contextmanager
def storage_errors(folder: Path, only_below: Path | None = None) -> Iterator[None]:
    """Turn an OSError of a full, read-only or forbidden disk into a StorageError with a remedy.

    folder: named in the error. only_below: errors of files outside this folder pass as they are.
    """
    try:
        yield
    except OSError as error:
        remedy = _REMEDIES.get(error.errno or 0)
        if remedy is None or (
            only_below is not None
            and error.filename is not None
            and not Path(error.filename).is_relative_to(only_below)
        ):
            raise
        raise StorageError(
            f"cannot write: {os.strerror(error.errno or 0)}", where=str(folder), remedy=remedy
        ) from error


@contextmanager
def complete_file(path: Path) -> Iterator[BinaryIO]:
    """Write a file as `complete_path` does."""
    with complete_path(path) as temporary, open(temporary, "xb") as file:  # "x" follows no link
        yield file


@contextmanager
def durable_file(path: Path) -> Iterator[BinaryIO]:
    """Write a file as `durable_path` does."""
    with durable_path(path) as temporary, open(temporary, "xb") as file:
        yield file


def write_file(path: Path, data: bytes) -> None:
    """Write all of `data` to `path`, durably, or leave `path` as it was."""
    with durable_file(path) as file:
        file.write(data)


def replace_file(path: Path, data: bytes) -> None:
    """Write all of `data` to `path` or nothing, without waiting for the disk.

    A power cut may tear it, so whoever reads it must notice.
    """
    temporary = temporary_name(path)
    with open(temporary, "wb") as file:
        file.write(data)
    os.replace(temporary, path)


@contextmanager
def complete_path(path: Path) -> Iterator[Path]:
    """Yield a temporary path for a file or a folder, renamed to `path` at the end.

    It has the suffix of `path`, by which libraries choose a format. A power cut may tear what is
    written, unless its folder is synced.
    """
    temporary = temporary_name(path)
    with storage_errors(path.parent):
        make_folder(path.parent)
        remove(temporary)
        try:
            yield temporary
            os.replace(temporary, path)
        except BaseException:
            with suppress(OSError):
                remove(temporary)
            raise


@contextmanager
def durable_path(path: Path) -> Iterator[Path]:
    """Yield a path as `complete_path` does. What is written is synced before it is renamed."""
    with complete_path(path) as temporary:
        yield temporary
        sync_tree(temporary)
    with storage_errors(path.parent):
        sync_tree(path.parent, only_itself=True)


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
            sync_tree(created.parent, only_itself=True)


def copy_file(source: Path, target: Path) -> None:
    """Copy a file to a new file, sharing blocks where the file system can (Btrfs, XFS)."""
    with open(source, "rb") as original, open(target, "xb") as copy:
        try:
            while os.copy_file_range(original.fileno(), copy.fileno(), _COPY_BYTES):
                pass
        except OSError as error:
            if error.errno not in _NO_COPY_RANGE:
                raise
            shutil.copyfileobj(original, copy)


def sync_tree(path: Path, *, only_itself: bool = False) -> None:
    """Sync a file, or every file and folder below a folder.

    Several are synced at a time, which the file system commits together: one by one, 121 files took
    ten times as long. Raises FileNotFoundError when nothing was written there.
    """
    below = [] if only_itself or not path.is_dir() else sorted(path.rglob("*"))
    for _ in in_threads(_sync, below):
        pass
    _sync(path)


def _sync(path: Path) -> None:
    """Sync a file or folder itself."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def remove(path: Path) -> None:
    """Remove a file or a folder with all it holds, if it is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def commit_folder(built: Path, final: Path) -> None:
    """Sync the folder `built`, put it at `final` in one step, and remove the old folder.

    Linux swaps two folders in one call. If the file system cannot (NFS), the old folder is first
    renamed to `set_aside(final)`, which `recover` and `existing_folder` know.
    """
    with storage_errors(final.parent):
        make_folder(final.parent)
        sync_tree(built)
        old = built
        if not os.path.lexists(final):
            os.rename(built, final)
        elif not exchange(built, final):
            old = set_aside(final)
            os.rename(final, old)
            os.rename(built, final)
        sync_tree(final.parent, only_itself=True)
        remove(old)


def set_aside(final: Path) -> Path:
    return final.with_name(f".old-{final.name}")


def existing_folder(final: Path) -> Path:
    """Find where a folder lies, also after a commit without swap that was cut short."""
    return set_aside(final) if not final.exists() and set_aside(final).exists() else final


def recover(final: Path) -> None:
    """Repair a commit that was cut short. The old folder returns if the new one never came."""
    old = set_aside(final)
    with storage_errors(final.parent):
        if old.exists() and not final.exists():
            os.rename(old, final)
        remove(old)


def exchange(first: Path, second: Path) -> bool:
    """Swap two folders in one call. False if the file system has no such call."""
    renameat2 = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if renameat2 is None:
        return False
    names = os.fsencode(first), os.fsencode(second)
    if renameat2(_AT_FDCWD, names[0], _AT_FDCWD, names[1], _RENAME_EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in _NO_EXCHANGE:
        return False
    raise OSError(number, os.strerror(number), str(second))
