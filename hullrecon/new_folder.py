# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A folder that appears when all of it is written, or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hullrecon.errors import StorageError


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder whose content is moved to `folder` at the end.

    After an exception it is removed, and `folder` is as it was. Raises StorageError if `folder`
    exists and is not an empty folder, or if something cannot be written.
    """
    try:
        # Resolved, as a temporary name beside "." or a link could not be made from it.
        place = Path(os.path.realpath(folder))
        is_there = _is_there(place, folder)
        temporary = (
            place / f".partial-{os.getpid()}"
            if is_there
            else place.parent / f".{place.name}.partial-{os.getpid()}"
        )
        try:
            temporary.mkdir(parents=True)
            yield temporary
            if is_there:
                _move_up(temporary, folder)
            else:
                temporary.rename(place)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
    except OSError as error:
        raise StorageError(
            "cannot write there", where=str(folder), remedy=str(error.strerror or error)
        ) from error


def _is_there(place: Path, folder: Path) -> bool:
    """Decide whether an empty folder is there. Raises StorageError when anything else is."""
    if not os.path.lexists(place):
        return False
    if not place.is_dir():
        raise StorageError("this is no folder", where=str(folder), remedy="name a new one")
    _refuse_content(os.listdir(place), folder)
    return True


def _move_up(temporary: Path, folder: Path) -> None:
    """Move everything in the folder `temporary` into its parent.

    The parent is kept, not replaced: it may be a mount point, or a shell's current folder. Raises
    StorageError if it holds anything else by now.
    """
    _refuse_content(
        [name for name in os.listdir(temporary.parent) if name != temporary.name], folder
    )
    for path in sorted(temporary.iterdir()):
        path.rename(temporary.parent / path.name)


def _refuse_content(names: list[str], folder: Path) -> None:
    if names:
        raise StorageError("the folder is not empty", where=str(folder), remedy="name a new one")
