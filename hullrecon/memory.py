# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Memory that was freed, given back to the system."""

from __future__ import annotations

import ctypes
import gc
from contextlib import suppress


def return_free_memory() -> None:
    """Give back to the system what was freed so far.

    Without it the allocator keeps it, and what comes next stands on top of it: 300 MB after the
    adjustment of 232 stereo pairs. Other systems' C libraries than glibc have no such call.
    """
    gc.collect()
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)
