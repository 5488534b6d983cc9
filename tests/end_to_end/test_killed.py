# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""kill -9 at random times, then run again: the same deliverables, byte for byte apart from run
blocks and the report's time.
"""

import random
import time

import pytest
from end_to_end.shell import COARSE, Shell, without_run_blocks


@pytest.mark.slow
def test_run_killed_four_times_ends_with_the_same_bytes(tmp_path, tiny):
    shell = Shell(tmp_path, pdf=False)
    shell("run", tiny, "--runs", "whole", *COARSE)
    whole = without_run_blocks(shell.folder / "whole")
    rng = random.Random(20)
    for _ in range(4):
        run = shell.start("run", tiny, "--runs", "killed", *COARSE)
        time.sleep(rng.uniform(0.3, 6.0))
        run.kill()
        run.communicate()
    shell("run", tiny, "--runs", "killed", *COARSE)
    again = without_run_blocks(shell.folder / "killed")
    assert sorted(again) == sorted(whole)
    different = [name for name in whole if whole[name] != again[name]]
    assert different == []


def test_a_second_run_does_nothing(shell, tiny):
    shell("run", tiny, "--runs", "out", "--to", "navigate")
    before = {p: p.stat().st_mtime_ns for p in (shell.folder / "out").rglob("manifest.json")}
    shell("run", tiny, "--runs", "out", "--to", "navigate")
    after = {p: p.stat().st_mtime_ns for p in (shell.folder / "out").rglob("manifest.json")}
    assert before == after
    assert len(before) == 2
