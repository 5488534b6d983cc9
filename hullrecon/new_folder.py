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
    """Yield an empty folder whose content is in `folder` at the end; an exception removes it.

    Raises StorageError when `folder` is there and not an empty folder, or when something cannot be
    written.
    """
    try:
        # "." and links have no name that could be taken beside them
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
    """Whether an empty folder is there. Raises StorageError when anything else is."""
    if not os.path.lexists(place):
        return False
    if not place.is_dir():
        raise StorageError("this is no folder", where=str(folder), remedy="name a new one")
    _refuse_content(os.listdir(place), folder)
    return True


def _move_up(temporary: Path, folder: Path) -> None:
    """Move all that lies in a folder into the one above.

    That one is not replaced: it may be a mount point, or the folder that somebody's shell is in.
    Raises StorageError when more lies there.
    """
    _refuse_content(
        [name for name in os.listdir(temporary.parent) if name != temporary.name], folder
    )
    for path in sorted(temporary.iterdir()):
        path.rename(temporary.parent / path.name)


def _refuse_content(names: list[str], folder: Path) -> None:
    if names:
        raise StorageError("the folder is not empty", where=str(folder), remedy="name a new one")
