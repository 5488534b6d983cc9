# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tables as dataclasses of columns, from which rows are selected, and rows read from a file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from mmap import mmap
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.memory import LARGE_BYTES, empty_array, release_pages
from hullrecon.typing import Ints, Mask

BLOCK = 1 << 18  # rows of a large column that are selected at a time
Number = TypeVar("Number", bound=np.generic)


class Rows:
    """A dataclass whose fields are columns: one row for each measurement."""

    SHARED: ClassVar[frozenset[str]] = frozenset()  # fields that hold for all rows, no columns

    def __len__(self) -> int:
        """Count the rows."""
        return len(getattr(self, self._columns()[0]))

    def take(self, rows: Ints | Mask | slice) -> Self:
        """Select rows of every column. Empty columns stay empty."""
        kept = {name: _take(getattr(self, name), rows) for name in self._columns()}
        return replace(self, **kept)  # type: ignore[type-var]  # any dataclass

    def followed_by(self, *more: Self) -> Self:
        """Append the rows of other tables of the same kind."""
        parts = (self, *more)
        joined = {n: np.concatenate([getattr(p, n) for p in parts]) for n in self._columns()}
        return replace(self, **joined)  # type: ignore[type-var]  # any dataclass

    def _columns(self) -> list[str]:
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]  # any dataclass
        return [name for name in names if name not in self.SHARED]


def blocks_of_rows(count: int, at_once: int) -> Iterator[slice]:
    """Yield the rows of a table of `count` rows, `at_once` at a time, to limit memory."""
    return (slice(first, first + at_once) for first in range(0, count, at_once))


def spread_rows(count: int, most: int) -> Ints:
    """Choose at most `most` of `count` rows, spread evenly from the first to the last one."""
    return np.unique(np.linspace(0, count - 1, most).astype(np.int64))[:count]


def _take(column: Any, rows: Ints | Mask | slice) -> Any:
    """Select rows of one column: of a nested record, of poses, or of an array."""
    if isinstance(column, Rows):
        return column.take(rows)
    if not len(column):
        return column
    is_mask = isinstance(rows, np.ndarray) and rows.dtype.kind == "b"
    # a column may also be of poses, which are small
    if is_mask and isinstance(column, np.ndarray) and column.nbytes >= LARGE_BYTES:
        return _take_large(column, np.asarray(rows, bool))
    return column[rows]


def _take_large(column: NDArray[Number], rows: Mask) -> NDArray[Number]:
    """Select rows of a large column block by block, into an array of `empty_array`.

    Both may be kept in files, so that neither has to fit into memory.
    """
    out = empty_array((int(rows.sum()), *column.shape[1:]), column.dtype)
    filled = 0
    for some in blocks_of_rows(len(rows), BLOCK):
        kept = column[some][rows[some]]
        out[filled : filled + len(kept)] = kept
        filled += len(kept)
    release_pages(column, out)
    return out


def read_rows(array: NDArray[Number], rows: slice) -> NDArray[Number]:
    """Read rows of an array that may be mapped from a file.

    The pages of a mapped file count as the process's memory for as long as the map is open. So
    rows are read from the file itself, and the map only says where they are.
    """
    first, last, _ = rows.indices(len(array))
    if not isinstance(array, np.memmap) or not isinstance(array.base, mmap):
        return array[first:last]  # in memory, or a part of a map: its offset is that of the whole
    assert array.filename is not None  # of a map of a file
    items = int(np.prod(array.shape[1:]))
    flat = np.fromfile(
        array.filename,
        array.dtype,
        count=(last - first) * items,
        offset=array.offset + first * items * array.dtype.itemsize,
    )
    return flat.reshape(-1, *array.shape[1:])
