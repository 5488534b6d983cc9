# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A temporary folder for what a log unpacks to, and what is said where the disk is full."""

from __future__ import annotations

import errno
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from hullrecon.errors import StorageError

FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
REMEDY = "free some space there, or name another folder in the variable TMPDIR"


def scratch_folder() -> Path:
    """Make a temporary folder, or raise StorageError where no folder can be written."""
    try:
        return Path(tempfile.mkdtemp(prefix="hullrecon-"))
    except OSError as error:  # tempfile says ENOENT where every folder that it tries is full
        raise _no_space(error.filename or str(error.strerror)) from error


@contextmanager
def space_errors(folder: Path, remove: Callable[[], object]) -> Iterator[None]:
    """Turn a full disk into a StorageError, and remove the folder then."""
    try:
        yield
    except OSError as error:
        if error.errno not in FULL:
            raise
        remove()
        raise _no_space(str(folder.parent)) from error


def _no_space(where: str) -> StorageError:
    return StorageError("no space to unpack a log", where=where, remedy=REMEDY)
