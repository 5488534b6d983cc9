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
    """Yield an empty folder beside `folder`, which takes its name at the end; an exception removes it.

    Raises StorageError when `folder` is there and not empty, or when something cannot be written."""
    if folder.is_dir() and any(folder.iterdir()):
        raise StorageError("the folder is not empty", where=str(folder), remedy="name a new one")
    temporary = folder.parent / f".{folder.name}.partial-{os.getpid()}"
    try:
        temporary.mkdir(parents=True)
        yield temporary
        temporary.rename(folder)
    except OSError as error:
        raise StorageError("cannot write there", where=str(folder), remedy=str(error.strerror or error)) from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
