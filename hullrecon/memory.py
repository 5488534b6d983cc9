# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Reduce the memory of a process: return what was freed, and keep large arrays in files."""

from __future__ import annotations

import ctypes
import gc
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from mmap import MADV_DONTNEED, mmap
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", bound=np.generic)
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # parameters of mallopt(3)
# Largest block, and all free memory, that the allocator keeps
_KEPT_BLOCK_BYTES, _KEPT_BYTES = 32 << 20, 256 << 20
_RETURNED_BLOCK_BYTES = 1 << 20  # least block that goes back to the system by itself
LARGE_BYTES = 8 << 20  # size from which an array is kept in a file


def return_free_memory() -> None:
    """Return freed memory to the system.

    The allocator would keep it: 300 MB after the adjustment of 232 stereo pairs, on top of which
    later steps allocate theirs. C libraries other than glibc have no such call.
    """
    gc.collect()
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def keep_free_memory() -> None:
    """Let this process keep freed memory for its next allocations, as in a worker's loop.

    Otherwise the allocator returns large blocks at once, and the system clears their pages again at
    the next allocation: a seventh of the time of finding features. C libraries other than glibc
    have no such call.
    """
    with suppress(OSError, AttributeError):
        library = ctypes.CDLL(None)
        library.mallopt(_MMAP_THRESHOLD, _KEPT_BLOCK_BYTES)
        library.mallopt(_TRIM_THRESHOLD, _KEPT_BYTES)


@contextmanager
def returning_large_blocks() -> Iterator[None]:
    """Return large blocks to the system when they are freed, within a `with` statement.

    Otherwise the allocator learns to keep blocks of up to 32 MB, for each thread its own, between
    others that last: 340 MB beside 410 MB in use while 4,000 stereo pairs were adjusted in parts.
    Smaller arrays that NumPy makes in a loop come faster from kept blocks. C libraries other than
    glibc have no such call.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError):
        yield
        return
    mallopt(_MMAP_THRESHOLD, _RETURNED_BLOCK_BYTES)
    try:
        yield
    finally:
        mallopt(_MMAP_THRESHOLD, _KEPT_BLOCK_BYTES)


def empty_array(shape: tuple[int, ...], dtype: np.dtype[Number] | type[Number]) -> NDArray[Number]:
    """Make an array whose values are still to be written, in a mapped file if it is large.

    The file has no name, and is gone with the array. Pages that were used count as memory of the
    process until `release_pages`. Raises OSError where the disk is full.
    """
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    if size < LARGE_BYTES:
        return np.empty(shape, dtype)
    with tempfile.TemporaryFile(prefix="hullrecon-array-") as file:
        # Reserve the space on the disk: if it were full later, writing to a page would kill the
        # process.
        os.posix_fallocate(file.fileno(), 0, size)
        pages = mmap(file.fileno(), size)
    return np.frombuffer(pages, dtype).reshape(shape)


def release_pages(*arrays: NDArray[np.generic]) -> None:
    """Remove arrays of `empty_array` from memory. Their pages are read again when used."""
    for array in arrays:
        base: object = array
        while isinstance(base, np.ndarray):
            base = base.base
        pages = base.obj if isinstance(base, memoryview) else base
        if isinstance(pages, mmap):
            pages.madvise(MADV_DONTNEED)
