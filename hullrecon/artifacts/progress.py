# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Show progress on standard error, and remember Ctrl-C and SIGTERM."""

from __future__ import annotations

import logging
import signal
import sys
import time
from collections.abc import Iterable, Iterator
from types import FrameType
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import rich.progress

Item = TypeVar("Item")
log = logging.getLogger(__name__)
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_requested: list[int] = []


def listen() -> None:
    """Let SIGINT and SIGTERM raise KeyboardInterrupt, and forget earlier signals.

    Signals are remembered, as libraries turn a KeyboardInterrupt in their import into other errors.
    """
    _requested.clear()
    for number in _SIGNALS:
        signal.signal(number, _interrupt)


def is_requested() -> bool:
    """Test whether a signal has come, whatever became of its KeyboardInterrupt."""
    return bool(_requested)


def raise_if_requested() -> None:
    """Raise KeyboardInterrupt if a signal has come whose KeyboardInterrupt a library swallowed."""
    if _requested:
        raise KeyboardInterrupt


def _interrupt(number: int, frame: FrameType | None) -> None:
    _requested.append(number)
    raise KeyboardInterrupt


class Progress:
    """Shows nothing. Subclasses show how many items have passed."""

    def track(self, items: Iterable[Item], label: str, total: int | None) -> Iterator[Item]:
        yield from items


class LogLines(Progress):
    """Logs a line every `seconds` while items pass. Short work logs nothing."""

    def __init__(self, seconds: float = 10.0) -> None:
        self._seconds = seconds

    def track(self, items: Iterable[Item], label: str, total: int | None) -> Iterator[Item]:
        last = time.monotonic()
        for done, item in enumerate(items):
            if time.monotonic() - last >= self._seconds:
                log.info("%s: %d%s", label, done, f" of {total}" if total else "")
                last = time.monotonic()
            yield item


class Bars(Progress):
    """One live display, with a bar for each loop that is under way."""

    def __init__(self) -> None:
        self._display: rich.progress.Progress | None = None
        self._open = 0

    def track(self, items: Iterable[Item], label: str, total: int | None) -> Iterator[Item]:
        display = self._start()
        task = display.add_task(label, total=total)
        try:
            for item in items:
                yield item
                display.advance(task)
        finally:
            display.remove_task(task)
            self._open -= 1
            if self._open == 0:
                display.stop()

    def _start(self) -> rich.progress.Progress:
        import rich.progress as shown
        from rich.console import Console

        if self._display is None:
            columns = (
                shown.TextColumn("{task.description}"),
                shown.BarColumn(),
                shown.MofNCompleteColumn(),
                shown.TimeRemainingColumn(),
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
