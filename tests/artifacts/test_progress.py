# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.progress: bars on a terminal, lines in a log, the items as they are."""

from __future__ import annotations

import io
import logging
import sys
from collections.abc import Iterator

import pytest

from hullrecon.artifacts.progress import (
    Bars,
    LogLines,
    Outlook,
    Progress,
    RunOutlook,
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


class Clock:
    """A clock that is put forward by hand."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def run(clock: Clock) -> RunOutlook:
    """A run whose first step took twice what was predicted."""
    run = RunOutlook(clock)
    run.plan(["ingest", "features", "links"])
    run.predict({"ingest": 10.0, "features": 60.0, "links": 30.0})
    with run.step("ingest"):
        clock.now += 20
    return run


@pytest.fixture
def outlook(run: RunOutlook) -> Iterator[Outlook]:
    """Of the second step, at its begin."""
    with run.step("features") as outlook:
        yield outlook


def test_predicted_times_are_scaled_by_the_steps_so_far(outlook: Outlook, clock: Clock) -> None:
    assert outlook.mark == "[2/3] "
    assert outlook.left() == ", about 2 min left of the step, 3 min of the run"
    clock.now += 80
    assert outlook.left(30.0) == ", about 40 s left of the step, 2 min of the run"


def test_a_loop_that_is_slower_than_predicted_says_so(outlook: Outlook) -> None:
    assert outlook.left(600.0) == ", about 10 min left of the step, 11 min of the run"


def test_beyond_what_was_predicted_nothing_is_said(outlook: Outlook, clock: Clock) -> None:
    clock.now += 121
    assert outlook.left() == ""


def test_a_step_that_was_resumed_teaches_no_pace(run: RunOutlook, clock: Clock) -> None:
    with run.step("features") as outlook:
        outlook.resume()
        clock.now += 1
        assert outlook.left() == ""
    with run.step("links") as outlook:
        assert outlook.left() == ", about 60 s left of the step, 60 s of the run"


def test_steps_beside_each_other_share_the_time(run: RunOutlook, clock: Clock) -> None:
    with run.step("features") as long, run.step("links") as short:
        assert short.left() == ", about 2 min left of the step, 3 min of the run"
        clock.now += 120
        assert short.left() == ""
        assert long.left() == ", about 60 s left of the step, 60 s of the run"


def test_without_prediction_a_loop_speaks_for_itself_alone() -> None:
    outlook = Outlook()
    assert (outlook.mark, outlook.left(), outlook.left(200.0)) == ("", "", ", about 3 min left")


def test_lines_tell_the_rate_of_what_was_made(caplog: pytest.LogCaptureFixture) -> None:
    clock = Clock()
    items = LogLines(5.0, clock).track(range(10), "images", 10, Outlook(), kept=4)
    with caplog.at_level(logging.INFO):
        for done in range(7):
            next(items)
            clock.now += 10 if done >= 4 else 0  # the first four are there
        items.close()
    assert [record.getMessage() for record in caplog.records] == [
        "images: 5 of 10, about 50 s left",
        "images: 6 of 10, about 40 s left",
    ]
