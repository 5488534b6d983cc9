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
_RESET_PEAK = "5"  # written to /proc/self/clear_refs: proc(5)
_KIB = 1024
# Address space that a run needs, measured on 36 stereo pairs with sonar: with one thread of the
# solver, and for each further one. With less, OpenBLAS repeats a refused request for ever and the
# run would hang.
ONE_THREAD_BYTES = 7 << 28
MORE_THREADS_BYTES = 136 << 20
_UNMAPPED = (  # parts of messages of libraries that could not get memory
    "failed to map segment",
    "cannot allocate memory",
    "cannot create shared object",
    "can't start new thread",
)


def usable_cores() -> int:
    """Choose the default number of worker processes: HULLRECON_JOBS, else one per core."""
    given = os.environ.get("HULLRECON_JOBS", "")
    return int(given) if given.isdecimal() and int(given) else len(os.sched_getaffinity(0))


@cache
def versions() -> dict[str, str]:
    """Look up the versions of Python, of hullrecon and of the installed libraries."""
    found = {"python": platform.python_version(), "hullrecon": describe()}
    for name in LIBRARIES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def host() -> dict[str, str | int | None]:
    return {"name": socket.gethostname(), "system": platform.platform(), "cores": os.cpu_count()}


def reset_peak_rss() -> None:
    """Restart the count of `peak_rss`. If the kernel cannot, it is the peak of the whole run."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text(_RESET_PEAK)


def peak_rss(process: int | None = None) -> int:
    """Read the peak resident memory (bytes) of this process, or of another (0 if it has ended)."""
    with suppress(OSError):
        for line in Path(f"/proc/{process or 'self'}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * _KIB
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _KIB if process is None else 0


def refuse_small_address_space(threads: int = 2) -> None:
    """Raise StageError if `ulimit -v` leaves less than a solver of that many threads needs."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    needed = ONE_THREAD_BYTES + MORE_THREADS_BYTES * (threads - 1)
    if limit != resource.RLIM_INFINITY and limit < needed:
        raise StageError(
            f"the address space is limited to {limit / 1e9:.2f} GB,"
            f" and a run needs {needed / 1e9:.2f} GB",
            remedy="raise it (`ulimit -v`, LimitAS= of the unit), or limit the memory by a cgroup"
            " (MemoryMax=) instead",
        )


def is_lack_of_memory(error: BaseException) -> bool:
    """Test whether the error, or an error that caused it, says that memory ran out."""
    seen: BaseException | None = error
    while seen is not None:
        if isinstance(seen, MemoryError) or getattr(seen, "errno", None) == errno.ENOMEM:
            return True
        if isinstance(seen, ImportError | OSError | RuntimeError) and any(
            text in str(seen).lower() for text in _UNMAPPED
        ):
            return True
        seen = seen.__cause__ or seen.__context__
    return False
