# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Versions, host and memory of this machine, and what a lack of memory looks like."""

from __future__ import annotations

import errno
import os
import platform
import resource
import socket
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from hullrecon.errors import StageError
from hullrecon.version import describe

LIBRARIES = (
    "numpy",
    "scipy",
    "open3d-cpu",
    "open3d",
    "opencv-python-headless",
    "pycolmap",
    "trimesh",
    "rosbags",
    "mcap",
    "msgspec",
)
_RESET_PEAK = "5"  # proc(5), clear_refs
_KIB = 1024


def usable_cores() -> int:
    """Return how many worker processes a run starts unless told: HULLRECON_JOBS, else one a core."""
    given = os.environ.get("HULLRECON_JOBS", "")
    return int(given) if given.isdecimal() and int(given) else len(os.sched_getaffinity(0))


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of the libraries that are installed."""
    found = {"python": platform.python_version(), "hullrecon": describe()}
    for name in LIBRARIES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def host() -> dict[str, str | int | None]:
    return {"name": socket.gethostname(), "system": platform.platform(), "cores": os.cpu_count()}


def reset_peak_rss() -> None:
    """Reset the peak memory of this process; where the kernel has no such thing, `peak_rss` is that
    of the whole run.
    """
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text(_RESET_PEAK)


def peak_rss(process: int | None = None) -> int:
    """Return the largest resident memory of a process in bytes (this one for None); 0 when it is
    gone.
    """
    with suppress(OSError):
        for line in Path(f"/proc/{process or 'self'}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * _KIB
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _KIB if process is None else 0


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
