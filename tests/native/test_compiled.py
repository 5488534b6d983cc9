# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hullrecon.native.compiled import KERNELS, best_kernels, blas_kernels

AVX2 = "flags : fpu sse2 avx2 fma"


@pytest.fixture
def cpuinfo(tmp_path: Path) -> Path:
    path = tmp_path / "cpuinfo"
    path.write_text(AVX2)
    return path


def test_kernels_are_chosen_while_libraries_are_loaded(
    cpuinfo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(KERNELS, raising=False)
    with blas_kernels(cpuinfo):
        assert os.environ[KERNELS] == "Haswell"
    assert KERNELS not in os.environ


def test_kernels_that_the_user_chose_are_kept(
    cpuinfo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(KERNELS, "Nehalem")
    with blas_kernels(cpuinfo):
        assert os.environ[KERNELS] == "Nehalem"
    assert os.environ[KERNELS] == "Nehalem"


@pytest.mark.parametrize(
    ("words", "kernels"),
    [
        (AVX2, "Haswell"),
        (f"vendor_id : AuthenticAMD {AVX2}", "Zen"),
        (f"vendor_id : GenuineIntel {AVX2} avx512f avx512dq avx512bw avx512vl", "SkylakeX"),
        (f"{AVX2} avx512f", "Haswell"),
        ("flags : fpu sse2 avx", None),
    ],
)
def test_the_best_kernels_that_the_processor_can_run_are_chosen(
    words: str, kernels: str | None, cpuinfo: Path
) -> None:
    cpuinfo.write_text(words)
    assert best_kernels(cpuinfo) == kernels


def test_where_nothing_is_known_of_the_processor_the_library_chooses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(KERNELS, raising=False)
    with blas_kernels(tmp_path / "missing"):
        assert KERNELS not in os.environ


@pytest.mark.skipif(best_kernels() is None, reason="OpenBLAS chooses for this processor")
def test_the_solver_computes_with_these_kernels() -> None:
    code = (
        "import ctypes, hullrecon.native.compiled as c; "
        "blas = ctypes.CDLL('libopenblas.so.0'); "
        "blas.openblas_get_corename.restype = ctypes.c_char_p; "
        "print(blas.openblas_get_corename().decode())"
    )
    environment = {key: value for key, value in os.environ.items() if key != KERNELS}
    out = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    assert out.stdout.strip() == best_kernels()
