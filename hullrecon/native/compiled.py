# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Load the compiled module, with kernels of OpenBLAS that use what the processor has.

As it is loaded, OpenBLAS chooses its kernels by the processor's model. For one that is newer than
the library it takes those for SSE3: an adjustment of stereo pairs took 1.4 times as long on such a
machine. Chosen here is what the library takes for the processors that it knows.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

KERNELS = "OPENBLAS_CORETYPE"  # the variable by which OpenBLAS is told the processor
# Its names of kernels, and the words of /proc/cpuinfo that a processor for them has, best first
NEEDED = {
    "SkylakeX": {"avx512f", "avx512dq", "avx512bw", "avx512vl"},
    "Zen": {"AuthenticAMD", "avx2", "fma"},
    "Haswell": {"avx2", "fma"},
}
CPUINFO = Path("/proc/cpuinfo")


@contextmanager
def blas_kernels(cpuinfo: Path = CPUINFO) -> Iterator[None]:
    """Choose the kernels of libraries that are loaded meanwhile, unless the user has chosen them.

    The variable is taken back, as NumPy's own OpenBLAS in child processes would follow it too.
    """
    chosen = None if KERNELS in os.environ else best_kernels(cpuinfo)
    if chosen is not None:
        os.environ[KERNELS] = chosen
    try:
        yield
    finally:
        if chosen is not None:
            del os.environ[KERNELS]


def best_kernels(cpuinfo: Path = CPUINFO) -> str | None:
    """Name the best kernels that the processor can run. None leaves the choice to OpenBLAS."""
    has = set(cpuinfo.read_text(encoding="utf-8").split()) if cpuinfo.exists() else set()
    return next((name for name, needed in NEEDED.items() if needed <= has), None)


with blas_kernels():
    import hullrecon._native as native

__all__ = ["native"]
