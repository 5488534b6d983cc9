# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Load the compiled module, with the same kernels of OpenBLAS on all processors that have AVX2.

As it is loaded, OpenBLAS chooses its kernels by the processor's model. For one that is newer than
the library it takes those for SSE3: an adjustment of stereo pairs took 1.4 times as long on such a
machine.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

KERNELS = "OPENBLAS_CORETYPE"  # the variable by which OpenBLAS is told the processor
FOR_AVX2 = "Haswell"
CPUINFO = Path("/proc/cpuinfo")


@contextmanager
def blas_kernels(cpuinfo: Path = CPUINFO) -> Iterator[None]:
    """Choose the kernels of libraries that are loaded meanwhile, unless the user has chosen them.

    The variable is taken back, as NumPy's own OpenBLAS in child processes would follow it too.
    """
    chosen = KERNELS not in os.environ and _has_avx2(cpuinfo)
    if chosen:
        os.environ[KERNELS] = FOR_AVX2
    try:
        yield
    finally:
        if chosen:
            del os.environ[KERNELS]


def _has_avx2(cpuinfo: Path) -> bool:
    """Tell whether the processor has AVX2 and fused multiply-add, which the kernels need."""
    flags = cpuinfo.read_text(encoding="utf-8").split() if cpuinfo.exists() else []
    return {"avx2", "fma"} <= set(flags)


with blas_kernels():
    import hullrecon._native as native

__all__ = ["native"]
