# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hullrecon.native.compiled import CPUINFO, FOR_AVX2, KERNELS, blas_kernels


@pytest.fixture
def cpuinfo(tmp_path: Path) -> Path:
    path = tmp_path / "cpuinfo"
    path.write_text("model name : new\nflags : fpu sse2 avx2 fma\n")
    return path


def test_kernels_for_avx2_are_chosen_while_libraries_are_loaded(
    cpuinfo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(KERNELS, raising=False)
    with blas_kernels(cpuinfo):
        assert os.environ[KERNELS] == FOR_AVX2
    assert KERNELS not in os.environ


def test_kernels_that_the_user_chose_are_kept(
    cpuinfo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(KERNELS, "Zen")
    with blas_kernels(cpuinfo):
        assert os.environ[KERNELS] == "Zen"
    assert os.environ[KERNELS] == "Zen"


@pytest.mark.parametrize("flags", ["fpu sse2 avx", None])
def test_without_avx2_the_library_chooses(
    flags: str | None, cpuinfo: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(KERNELS, raising=False)
    if flags is None:
        cpuinfo.unlink()
    else:
        cpuinfo.write_text(f"flags : {flags}\n")
    with blas_kernels(cpuinfo):
        assert KERNELS not in os.environ


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
    has_avx2 = " avx2 " in CPUINFO.read_text()
    assert (out.stdout.strip() == FOR_AVX2) == has_avx2
