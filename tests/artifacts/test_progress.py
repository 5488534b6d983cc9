# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.progress: bars on a terminal, lines in a log, the items as they are."""

from __future__ import annotations

import io
import logging
import sys

import pytest

from hullrecon.artifacts.progress import (
    Bars,
    LogLines,
    Progress,
    choose_progress,
)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("progress", [Progress(), LogLines(0.0), Bars()])
def test_the_items_pass_unchanged(progress: Progress, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Terminal())
    assert list(progress.track(iter("abc"), "letters", 3)) == ["a", "b", "c"]


def test_progress_is_bars_on_terminal_lines_in_file(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert type(choose_progress(quiet=True)) is Progress
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    assert isinstance(choose_progress(), LogLines)
    monkeypatch.setattr(sys, "stderr", Terminal())
    assert isinstance(choose_progress(), Bars)


def test_log_lines_say_how_far(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        list(LogLines(0.0).track("ab", "features: images", 2))
        list(LogLines(0.0).track("a", "features: images", None))
    assert [record.getMessage() for record in caplog.records] == [
        "features: images: 0 of 2", "features: images: 1 of 2", "features: images: 0",
    ]  # fmt: skip


def test_short_work_logs_nothing(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        list(LogLines(60.0).track(range(1000), "quick", 1000))
    assert caplog.records == []


def test_bars_may_stand_inside_each_other_and_end_with_the_work(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "stderr", Terminal())
    bars = Bars()
    pairs = [(a, b) for a in bars.track("ab", "outer", 2) for b in bars.track("cd", "inner", 2)]
    assert pairs == [("a", "c"), ("a", "d"), ("b", "c"), ("b", "d")]
    assert bars._open == 0


def test_a_bar_ends_when_the_loop_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Terminal())
    bars = Bars()
    loop = bars.track("ab", "outer", 2)
    next(loop)
    loop.close()
    assert bars._open == 0
