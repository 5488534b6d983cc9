# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Collect what a manifest's `run` block holds of the machine: versions, host, peak memory."""

from __future__ import annotations

import os
import platform
import resource
import socket
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

LIBRARIES = (
    "hullrecon",
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


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of the libraries that are installed."""
    found = {"python": platform.python_version()}
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
