# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Show progress on standard error, and remember Ctrl-C and SIGTERM."""

from __future__ import annotations

import logging
import signal
import sys
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import rich.progress

Item = TypeVar("Item")
log = logging.getLogger(__name__)
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_requested: list[int] = []  # numbers of the signals that have come


def listen(*, once: bool = False) -> None:
    """Let SIGINT and SIGTERM raise KeyboardInterrupt, and forget earlier signals.

    Signals are also remembered: a library that is being imported may turn the KeyboardInterrupt
    into another error. once: ignore signals after the first.
    """
    _requested.clear()
    for number in _SIGNALS:
        signal.signal(number, _interrupt_once if once else _interrupt)


def is_requested() -> bool:
    """Test whether a signal has come, whatever became of its KeyboardInterrupt."""
    return bool(_requested)


def raise_if_requested() -> None:
    """Raise KeyboardInterrupt if a signal has come whose KeyboardInterrupt a library swallowed."""
    if _requested:
        raise KeyboardInterrupt


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Remember that a signal came, and interrupt the run."""
    _requested.append(number)
    raise KeyboardInterrupt


def _interrupt_once(number: int, frame: FrameType | None) -> None:
    """Interrupt the run at the first signal, and ignore all others."""
    if not _requested:
        _interrupt(number, frame)


LEAST_S = 10.0  # of work before its rate is used to predict
Clock = Callable[[], float]


class RunOutlook:
    """Which of its steps a run has done, and how long the rest will take, as far as predictable.

    Predicted times were measured on another machine. They are scaled by the time that the finished
    steps of this run took, and nothing is predicted before these took LEAST_S. Steps that run at
    the same time share the time evenly.
    """

    def __init__(self, clock: Clock = time.monotonic) -> None:
        self._clock = clock
        self.steps: tuple[str, ...] = ()  # to do, in order
        self._predicted_s: dict[str, float] = {}
        self._spent_s: dict[str, float] = {}  # begun steps
        self._finished: set[str] = set()  # steps made in this run without parts of an earlier one
        self._under_way: dict[str, Outlook] = {}
        self._counted_until = clock()

    def plan(self, steps: Iterable[str]) -> None:
        """Note the steps that are to be done, in order."""
        self.steps = tuple(steps)

    def predict(self, seconds: Mapping[str, float]) -> None:
        """Note what steps are predicted to take, all on one machine."""
        self._predicted_s = {name: s for name, s in seconds.items() if s > 0}

    @contextmanager
    def step(self, name: str) -> Iterator[Outlook]:
        """Count a step as running inside the `with`, and as finished if that ends without error."""
        self._count()
        self._spent_s[name] = 0.0
        self._under_way[name] = outlook = Outlook(self, name)
        try:
            yield outlook
            self._count()
            if outlook.whole:
                self._finished.add(name)
        finally:
            self._count()
            del self._under_way[name]

    def mark(self, step: str) -> str:
        """Write the number of a step among those to do, as `[2/10] `. Empty where not known."""
        if step not in self.steps:
            return ""
        return f"[{self.steps.index(step) + 1}/{len(self.steps)}] "

    def left_of_step(self, step: str, loop_s: float | None) -> float | None:
        """Predict the remaining wall-clock time of a running step, s, beside other running steps.

        None where the step has no prediction, even if `loop_s` is known: other loops may follow.

        loop_s: remaining time of the step's present loop by its own rate, a lower bound.
        """
        expected_s = self._expected_s()
        if step not in expected_s:
            return None
        own_s = expected_s[step]
        if loop_s is None and own_s <= 0:  # the step has taken longer than predicted already
            return None
        # Running steps share the machine evenly. So each other step delays this one by what that
        # one still needs, but by no more than this one's own need. (own_s counts itself once.)
        shared_s = sum(min(own_s, other_s) for other_s in expected_s.values())
        return max(loop_s or 0.0, shared_s)

    def left_of_run(self, step_s: float) -> float | None:
        """Predict the remaining time of the run, s: of the running steps and of later ones.

        step_s: remaining time of one of the running steps. None where a time is not known.
        """
        pace, expected_s = self._pace(), self._expected_s()
        planned = [name for name in self.steps if name in self._under_way]
        if not planned:
            return None
        after_first = self.steps[self.steps.index(planned[0]) + 1 :]
        later = [name for name in after_first if name not in self._spent_s]
        if (
            pace is None
            or len(expected_s) < len(self._under_way)
            or any(name not in self._predicted_s for name in later)
        ):
            return None
        # Running steps share the machine, so that together they take the sum of their own times
        under_way_s = max(step_s, sum(expected_s.values()))
        return under_way_s + pace * sum(self._predicted_s[name] for name in later)

    def _expected_s(self) -> dict[str, float]:
        """Predict the remaining time of each running step if it had the machine alone, s.

        Steps without a prediction, or with parts of an earlier run, are left out.
        """
        self._count()
        pace = self._pace()
        if pace is None:
            return {}
        return {
            name: max(0.0, pace * self._predicted_s[name] - self._spent_s[name])
            for name, outlook in self._under_way.items()
            if outlook.whole and name in self._predicted_s
        }

    def _count(self) -> None:
        """Share the time since the last count among the steps under way."""
        now = self._clock()
        for name in self._under_way:
            self._spent_s[name] += (now - self._counted_until) / len(self._under_way)
        self._counted_until = now

    def _pace(self) -> float | None:
        """Compute by which factor this machine takes longer than predicted, by the finished steps.

        None before these took LEAST_S together.
        """
        known = [name for name in self._finished if name in self._predicted_s]
        took_s = sum(self._spent_s[name] for name in known)
        if took_s < LEAST_S:
            return None
        return took_s / sum(self._predicted_s[name] for name in known)


class Outlook:
    """The texts about one running step: its number, and how long it and the run still take."""

    def __init__(self, run: RunOutlook | None = None, step: str = "") -> None:
        self._run, self._step = run or RunOutlook(), step
        self.whole = True  # all parts are made in this run

    def resume(self) -> None:
        """Note that part of the step was made by an earlier run."""
        self.whole = False

    @property
    def mark(self) -> str:
        """Number of the step among those to do, as `[2/10] `. Empty where that is not known."""
        return self._run.mark(self._step)

    def left(self, loop_s: float | None = None) -> str:
        """Say how long step and run still take, as far as known, with a comma before.

        `loop_s`: remaining time of a loop of the step by its rate, None if that is not known.
        """
        step_s = self._run.left_of_step(self._step, loop_s)
        if step_s is None:  # say the loop's time, which is not the step's: other loops may follow
            return "" if loop_s is None else f", about {in_words(loop_s)} left"
        run_s = self._run.left_of_run(step_s)
        of_run = "" if run_s is None else f", {in_words(run_s)} of the run"
        return f", about {in_words(step_s)} left of the step{of_run}"

    def left_of_run(self, loop_s: float | None) -> str:
        """Say how long the run still takes. Empty where that is not known."""
        step_s = self._run.left_of_step(self._step, loop_s)
        run_s = None if step_s is None else self._run.left_of_run(step_s)
        return "" if run_s is None else f"about {in_words(run_s)} left of the run"


def in_words(seconds: float) -> str:
    """Write a time as coarsely as it is known: 40 s, 3 min, 2.5 h."""
    if seconds < 90:
        return f"{max(10, round(seconds, -1)):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


class _Rate:
    """The rate of a loop over items, from those made in this run."""

    def __init__(self, total: int | None, kept: int, clock: Clock = time.monotonic) -> None:
        self._total, self._kept, self._clock, self._begun = total, kept, clock, clock()

    def left(self, done: int) -> float | None:
        """Compute the seconds that the rest takes at the rate so far. None where not known."""
        spent, made = self._clock() - self._begun, done - self._kept
        if self._total is None or made <= 0 or spent < LEAST_S:
            return None
        return spent / made * (self._total - done)


class Progress:
    """Shows nothing. Subclasses show how many items have passed."""

    def track(
        self,
        items: Iterable[Item],
        label: str,
        total: int | None,
        outlook: Outlook | None = None,
        kept: int = 0,
    ) -> Generator[Item, None, None]:
        """Yield the items, and show how many have passed.

        Parameters
        ----------
        items
            To be yielded.
        label
            Shown before the numbers.
        total
            Number of the items, None if unknown.
        outlook
            Says how long step and run still take.
        kept
            Items that an earlier run made, which take no time.
        """
        yield from items


class LogLines(Progress):
    """Logs a line every `seconds` while items pass. Short work logs nothing."""

    def __init__(self, seconds: float = 10.0, clock: Clock = time.monotonic) -> None:
        self._seconds, self._clock = seconds, clock

    def track(
        self,
        items: Iterable[Item],
        label: str,
        total: int | None,
        outlook: Outlook | None = None,
        kept: int = 0,
    ) -> Generator[Item, None, None]:
        """Yield the items, and log a line whenever `seconds` have passed since the last one.

        The parameters are those of `Progress.track`.
        """
        last, rate = self._clock(), _Rate(total, kept, self._clock)
        for done, item in enumerate(items):
            if self._clock() - last >= self._seconds:
                left = "" if outlook is None else outlook.left(rate.left(done))
                log.info("%s: %d%s%s", label, done, f" of {total}" if total else "", left)
                last = self._clock()
            yield item


class Bars(Progress):
    """One live display, with a bar for each loop that is under way."""

    def __init__(self) -> None:
        self._display: rich.progress.Progress | None = None
        self._open = 0

    def track(
        self,
        items: Iterable[Item],
        label: str,
        total: int | None,
        outlook: Outlook | None = None,
        kept: int = 0,
    ) -> Generator[Item, None, None]:
        """Yield the items, and move the loop's bar on. The last loop's end stops the display.

        The parameters are those of `Progress.track`.
        """
        display, rate = self._start(), _Rate(total, kept)
        task = display.add_task(label, total=total, run="")
        try:
            for done, item in enumerate(items, 1):
                yield item
                run = "" if outlook is None else outlook.left_of_run(rate.left(done))
                display.update(task, advance=1, run=run)
        finally:
            display.remove_task(task)
            self._open -= 1
            if self._open == 0:
                display.stop()

    def _start(self) -> rich.progress.Progress:
        """Show the display, made at the first loop, and count the loops that use it."""
        import rich.progress as shown
        from rich.console import Console

        if self._display is None:
            columns = (
                shown.TextColumn("{task.description}"),
                shown.BarColumn(),
                shown.MofNCompleteColumn(),
                shown.TimeRemainingColumn(),
                shown.TextColumn("{task.fields[run]}"),
            )
            self._display = shown.Progress(*columns, console=Console(stderr=True), transient=True)
        if self._open == 0:
            self._display.start()
        self._open += 1
        return self._display


def choose_progress(*, quiet: bool = False) -> Progress:
    """Show bars on a terminal, log lines elsewhere, nothing when quiet."""
    if quiet:
        return Progress()
    return Bars() if sys.stderr.isatty() else LogLines()
