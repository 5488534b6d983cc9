# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""rows: rows of an array in a file are those of the array in memory."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hullrecon.rows import Rows, read_rows, spread_rows
from hullrecon.typing import Array, Ints


@dataclass(frozen=True)
class FrameRows(Rows):
    at: Array  # (m, 3)
    frame: Ints  # (m,)


@pytest.mark.parametrize("rows", [slice(0, 0), slice(3, 7), slice(8, 10)])
def test_rows_of_a_file_are_those_in_memory(tmp_path: Path, rows: slice) -> None:
    table = np.random.default_rng(1).random((10, 3))
    np.save(tmp_path / "table.npy", table)
    mapped = np.load(tmp_path / "table.npy", mmap_mode="r")
    found = read_rows(mapped, rows)
    assert not isinstance(found, np.memmap)
    for read in (found, read_rows(table, rows), read_rows(mapped[:], rows)):
        np.testing.assert_array_equal(read, table[rows])


def test_rows_of_a_part_of_a_map_count_from_its_begin(tmp_path: Path) -> None:
    np.save(tmp_path / "table.npy", np.arange(10))
    mapped = np.load(tmp_path / "table.npy", mmap_mode="r")
    np.testing.assert_array_equal(read_rows(mapped[4:], slice(1, 3)), [5, 6])


def test_large_columns_are_selected_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hullrecon.rows.LARGE_BYTES", 100)
    monkeypatch.setattr("hullrecon.rows.BLOCK", 7)
    rng = np.random.default_rng(2)
    seen = FrameRows(at=rng.random((50, 3)), frame=np.arange(50))
    kept = rng.random(50) < 0.5
    np.testing.assert_array_equal(seen.take(kept).at, seen.at[kept])
    np.testing.assert_array_equal(seen.take(kept).frame, seen.frame[kept])


@pytest.mark.parametrize(
    ("count", "most", "rows"), [(0, 5, []), (3, 5, [0, 1, 2]), (100, 3, [0, 49, 99])]
)
def test_rows_are_spread_from_first_to_last(count: int, most: int, rows: list[int]) -> None:
    assert spread_rows(count, most).tolist() == rows
