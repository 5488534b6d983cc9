# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The part of a recording that is used: [dive] from and to."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from hullrecon.dive.logs.readers.plain import PlainLog
from hullrecon.dive.logs.readers.protocol import Log, Message
from hullrecon.errors import InputError
from hullrecon.records.clock import NS, format_time

Instant = datetime | float | None  # a date and time, or s from the log's start; None: no limit
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
# a day; where sensor and logger differ by more, one clock is a simulator's or was never set
FAR_NS = 86400 * NS


@dataclass(frozen=True, kw_only=True)
class TimeWindow:
    """The stamps that are used, both limits included. None: no limit."""

    first_ns: int | None
    last_ns: int | None

    def holds(self, t_ns: int) -> bool:
        """Tell whether a stamp lies in the window."""
        return (self.first_ns is None or t_ns >= self.first_ns) and (
            self.last_ns is None or t_ns <= self.last_ns
        )

    def time_of(self, t_ns: int, logged_ns: int) -> int:
        """Choose the time of a message that is compared with the limits: its stamp or its logging.

        It is the stamp, or, where the two are a day or more apart, the one nearer to a limit: one
        of them is then of a simulator's clock, or of one that was never set.
        """
        limit = self.last_ns if self.first_ns is None else self.first_ns
        if limit is None or abs(logged_ns - t_ns) < FAR_NS:
            return t_ns
        return min(t_ns, logged_ns, key=lambda time: abs(time - limit))

    def describe(self) -> str:
        """Describe the window in words."""
        limits = (("from", self.first_ns), ("to", self.last_ns))
        return " ".join(f"{word} {format_time(t_ns)}" for word, t_ns in limits if t_ns is not None)


def time_window(start: Instant, end: Instant, logs: Sequence[Log]) -> TimeWindow | None:
    """Compute the window of a dive from dive.from and dive.to. None without limits.

    Seconds count from the first message of all logs, as it was logged (of tables, from the earliest
    first row). Raises InputError where the window ends before it begins.
    """
    if start is None and end is None:
        return None
    counted = any(isinstance(limit, (int, float)) for limit in (start, end))
    origin_ns = _first_message_ns(logs) if counted else 0
    window = TimeWindow(first_ns=_limit_ns(start, origin_ns), last_ns=_limit_ns(end, origin_ns))
    if (
        window.first_ns is not None
        and window.last_ns is not None
        and window.last_ns <= window.first_ns
    ):
        raise InputError(
            "the time window ends before it begins",
            where="dive.to",
            remedy="set it later than dive.from",
        )
    return window


def _limit_ns(limit: Instant, origin_ns: int) -> int | None:
    """Convert a limit of the window to ns since 1970. None where it is not given."""
    if limit is None:
        return None
    if isinstance(limit, datetime):
        return (limit - EPOCH) // timedelta(microseconds=1) * 1000
    return origin_ns + round(limit * NS)


def _first_message_ns(logs: Sequence[Log]) -> int:
    """Find when the first message of all logs was logged, ns. Raises InputError without any."""
    first = [message.t_ns for log in logs for message in _first_messages(log)]
    if not first:
        raise InputError(
            "the logs hold no message from which seconds could be counted", where="logs.files"
        )
    return min(first)


def _first_messages(log: Log) -> list[Message]:
    """Read the first message of a log, of a folder of tables the first row of each."""
    return (
        log.first_messages()
        if isinstance(log, PlainLog)
        else [*itertools.islice(log.messages(), 1)]
    )
