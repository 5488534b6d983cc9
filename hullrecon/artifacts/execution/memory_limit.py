# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Refuse a limit of the address space that no run can do with, and know an error that stands for a
lack of memory.
"""

from __future__ import annotations

import errno
import resource

from hullrecon.errors import StageError

# Measured: a dive of 36 stereo pairs with sonar. OpenBLAS takes 128 MiB for each thread that calls
# it and asks for ever when it gets none, so that a run with less would hang.
ONE_THREAD_BYTES = 7 << 28
MORE_THREADS_BYTES = 136 << 20
DEFAULT_THREADS = 2
_GB = 1e9
_UNMAPPED = (
    "failed to map segment",
    "cannot allocate memory",
    "cannot create shared object",
    "can't start new thread",
)
_REMEDY = "raise it (`ulimit -v`, LimitAS= of the unit), or limit the memory by a cgroup (MemoryMax=) instead"


def refuse_small_address_space(threads: int = DEFAULT_THREADS) -> None:
    """Raise StageError where `ulimit -v` leaves less than a run needs whose solver has that many
    threads.
    """
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    needed = ONE_THREAD_BYTES + MORE_THREADS_BYTES * (threads - 1)
    if limit != resource.RLIM_INFINITY and limit < needed:
        what = f"the address space is limited to {limit / _GB:.2f} GB, and a run needs {needed / _GB:.2f} GB"
        raise StageError(what, remedy=_REMEDY)


def is_lack_of_memory(error: BaseException) -> bool:
    """Return whether the error, or one that it came from, says that memory ran out."""
    seen: BaseException | None = error
    while seen is not None:
        if isinstance(seen, MemoryError) or (
            isinstance(seen, OSError) and seen.errno == errno.ENOMEM
        ):
            return True
        if isinstance(seen, ImportError | OSError | RuntimeError) and any(
            text in str(seen).lower() for text in _UNMAPPED
        ):
            return True
        seen = seen.__cause__ or seen.__context__
    return False
