# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""memory: what was freed goes back to the system, and what stands in a file may leave it."""

from __future__ import annotations

import os
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from hullrecon.memory import (
    LARGE_BYTES,
    empty_array,
    release_pages,
    return_free_memory,
    returning_large_blocks,
)


def test_freed_memory_goes_back_to_the_system() -> None:
    blocks = [b"x" * 60_000 for _ in range(2000)]  # below what the allocator maps on its own
    last = blocks[-1]
    held = resident_bytes()
    del blocks  # the last one stands above the hole
    return_free_memory()
    assert resident_bytes() < held - 80e6
    assert len(last) == 60_000


def test_large_blocks_between_others_go_back_at_once_within_the_statement_alone() -> None:
    with get_context("spawn").Pool(1) as alone:  # other tests leave free blocks, which come first
        within, after = alone.apply(returned_within_and_after)
    assert within > 35e6
    assert after < 10e6


def returned_within_and_after() -> tuple[int, int]:
    np.ones(3 << 20)  # 24 MB that are freed at once: from here on the allocator keeps such blocks
    with returning_large_blocks():
        within = bytes_returned()
    return within, bytes_returned()


def bytes_returned() -> int:
    """Free 20 blocks of 2 MB, each below one that lasts."""
    blocks = [(np.ones(1 << 18), b"x" * 60_000) for _ in range(20)]
    lasting = [small for _, small in blocks]
    held = resident_bytes()
    del blocks
    assert len(lasting) == 20
    return held - resident_bytes()


def test_a_large_array_leaves_memory_and_keeps_its_values() -> None:
    rows = 2 * LARGE_BYTES // 16
    large = empty_array((rows, 2), np.float64)
    large[:] = np.arange(2)
    held = resident_bytes()
    release_pages(large[5:])
    assert resident_bytes() < held - LARGE_BYTES
    assert (large.sum(axis=0) == [0, rows]).all()


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
