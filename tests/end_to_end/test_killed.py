# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""kill -9 in the middle of steps, then run again: the same deliverables, byte for byte apart from
run blocks and the report's time.
"""

import signal
import time

import pytest
from end_to_end.shell import COARSE, TINY, without_run_blocks


def write_blind_dive(shell):
    """Simulate a dive without camera and CAD model, of which the whole chain takes some seconds."""
    shell("simulate", "blind", *TINY, "--cameras", "none", "--structures", 0, "--seed", 5)
    path = shell.folder / "blind" / "dive.toml"
    text = path.read_text()
    path.write_text(text[: text.index("[hull]")])


def kill_in(shell, step, *arguments):
    """Run until that step has begun, and a little longer; then kill."""
    with shell.start(*arguments) as run:
        assert any(f"{step}: started" in line for line in run.stderr), step
        time.sleep(0.2)
        run.kill()
    assert run.returncode == -signal.SIGKILL


@pytest.mark.slow
@pytest.mark.parametrize(
    ("dive", "steps"), [("blind", ("navigate", "report")), ("tiny", ("features", "links"))]
)
def test_run_killed_in_two_steps_ends_with_the_same_bytes(shell, tiny, dive, steps):
    """Without images to the deliverables, with images as far as workers work on them. What is
    killed has a process for each step, the whole run has one.
    """
    package, last = (tiny, ("--to", "links")) if dive == "tiny" else ("blind", COARSE)
    if dive == "blind":
        write_blind_dive(shell)
    shell("run", package, "--runs", "whole", "--jobs", 1, *last)
    whole = without_run_blocks(shell.folder / "whole")
    for step in steps:
        kill_in(shell, step, "run", package, "--runs", "killed", "--jobs", 2, *last)
    shell("run", package, "--runs", "killed", "--jobs", 2, *last)
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
