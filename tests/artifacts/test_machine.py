# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.machine: what a `run` block says of the machine."""

from __future__ import annotations

import mmap
import os
import platform

from hullrecon.artifacts.machine import host, peak_rss, reset_peak_rss, versions


def test_versions_name_python_and_what_is_installed() -> None:
    assert versions()["python"] == platform.python_version()
    assert {"numpy", "scipy", "msgspec"} <= versions().keys()


def test_peak_memory_counts_freed_memory_and_resets() -> None:
    reset_peak_rss()
    before = peak_rss()
    # A mapping of its own: the heap of a process that has run other tests may hold 200 MB of free
    # pages that it still owns.
    with mmap.mmap(-1, 200_000_000) as block:
        block[:: mmap.PAGESIZE] = b"x" * len(range(0, len(block), mmap.PAGESIZE))
    assert peak_rss() - before > 150_000_000
    reset_peak_rss()
    assert peak_rss() - before < 150_000_000


def test_a_process_that_is_gone_has_no_peak() -> None:
    assert peak_rss(2**30) == 0


def test_the_host_has_a_name_and_cores() -> None:
    assert host()["name"]
    assert host()["cores"] == os.cpu_count()
