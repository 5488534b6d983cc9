# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""memory: what was freed goes back to the system."""

from __future__ import annotations

import os
from pathlib import Path

from hullrecon.memory import return_free_memory


def test_freed_memory_goes_back_to_the_system() -> None:
    blocks = [b"x" * 60_000 for _ in range(2000)]  # below what the allocator maps on its own
    last = blocks[-1]
    held = resident_bytes()
    del blocks  # the last one stands above the hole
    return_free_memory()
    assert resident_bytes() < held - 80e6
    assert len(last) == 60_000


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
