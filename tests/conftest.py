# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One thread for BLAS, as the commands have it: its threads wait by spinning, and a test took two minutes instead of six
seconds beside another process. Set here, before anything imports numpy, for a pytest that is called by itself."""

import os
import signal
from collections.abc import Iterator

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import pytest


@pytest.fixture(autouse=True)
def _signals_end_with_their_test() -> Iterator[None]:
    """Give SIGINT and SIGTERM back after a test that calls the program in this process, and forget those that came: the next
    test's steps would end as interrupted."""
    from hullrecon.artifacts.execution import interruption

    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
    interruption._requested.clear()
