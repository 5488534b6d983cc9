# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find stamps that came in bursts, and spread them over the time in which they were measured.

A computer that reads a serial buffer now and then stamps the readings when it received them. Such
stamps, and those of a clock of whole seconds, put several readings at nearly one time, and none
until the next ones have gathered.
"""

from __future__ import annotations

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS
from hullrecon.typing import Array, Ints

CLOSE = 0.2  # of the mean step: readings of one burst are closer
LEAST_BURSTS, LEAST_SIZE = 10, 3  # bursts in a stream, and readings in the median burst
# times the median interval between bursts; nine of ten intervals have to stay below
UNEVEN = 2.0
LONGEST_S = 5.0  # between bursts; an instrument that measures in bursts pauses for minutes
# Between sensor and logger. A longer time is an offset between two clocks, a shorter one the time
# that messages took to be logged
FAR_S = 60.0


def spread_bursts(name: str, stamp: Ints, logged: Ints, notes: list[Finding]) -> Ints:
    """Spread stamps that come in bursts over the time in which they were measured.

    Where the logging times do not come in bursts, they replace the stamps. Otherwise each burst is
    spread evenly over the time in which it gathered. Stamps without bursts are left unchanged.

    Parameters
    ----------
    name : of the stream, for the notes
    stamp, logged : (n,) ns, by sensor and by logger; alike where the log has one time only
    notes : a finding of the bursts is added

    Returns
    -------
    stamps (n,), ns, row by row those of `stamp`
    """
    order = np.argsort(stamp, kind="stable")
    starts = _burst_starts(stamp[order])
    if starts is None:
        return stamp
    values: dict[str, object] = {"count": len(stamp), "bursts": len(starts)}
    if _burst_starts(np.sort(logged)) is None:
        logged_minus_stamp_ns = int(np.median(logged - stamp))
        notes.append(Finding("stamps-in-bursts", {**values, "within_s": None}, name))
        # times of the logger's clock, put onto the sensor's clock where the two are far apart
        return logged - (logged_minus_stamp_ns if abs(logged_minus_stamp_ns) > FAR_S * NS else 0)
    spread, within_s = _spread_evenly(stamp[order], starts)
    notes.append(Finding("stamps-in-bursts", {**values, "within_s": within_s}, name))
    out = np.empty_like(stamp)
    out[order] = spread
    return out


def _burst_starts(t_ns: Ints) -> Ints | None:
    """Find the first row (b,) of each burst among sorted stamps.

    A buffer that is read at a fixed rate gives bursts at even intervals. None where the stamps do
    not come in bursts, or where the bursts follow each other at uneven or long intervals, as the
    time over which they gathered is then unknown.
    """
    if len(t_ns) < LEAST_BURSTS * LEAST_SIZE:
        return None
    step = np.diff(t_ns)
    starts = np.flatnonzero(np.r_[True, step >= CLOSE * step.mean()])
    sizes, interval = np.diff(np.r_[starts, len(t_ns)]), np.diff(t_ns[starts])
    if len(starts) < LEAST_BURSTS or np.median(sizes) < LEAST_SIZE:
        return None
    median_interval = float(np.median(interval))
    is_even = np.percentile(interval, 90) < UNEVEN * median_interval <= UNEVEN * LONGEST_S * NS
    return starts if is_even else None


def _spread_evenly(t_ns: Ints, starts: Ints) -> tuple[Ints, float]:
    """Spread the stamps of each burst evenly over the time in which its readings gathered.

    A buffer is read at the end of that time: its burst is spread back to the burst before. A clock
    of whole seconds, which gives all readings of a burst one stamp, shows the beginning of that
    time: its burst is spread up to the next one.

    Parameters
    ----------
    t_ns : (n,) stamps, sorted
    starts : (b,) first row of each burst

    Returns
    -------
    stamps (n,), ns, and how well they are known, s: the median time between two of them
    """
    ends = np.r_[starts[1:], len(t_ns)]
    is_coarse = bool((t_ns[ends - 1] == t_ns[starts]).mean() > 0.5)
    # the time given to each burst: where its readings began, or where they ended
    at = t_ns[starts] if is_coarse else t_ns[ends - 1]
    interval = np.diff(at)
    median_interval = int(np.median(interval))
    lasts = np.r_[interval, median_interval] if is_coarse else np.r_[median_interval, interval]
    lasts = np.minimum(lasts, 2 * median_interval)  # a pause is no time in which readings gathered
    begin = at if is_coarse else at - lasts
    burst = np.repeat(np.arange(len(starts)), ends - starts)
    # readings lie in the middle of equal parts of the time in which the burst gathered
    share: Array = (np.arange(len(t_ns)) - starts[burst] + 0.5) / (ends - starts)[burst]
    spread = begin[burst] + np.round(share * lasts[burst]).astype(np.int64)
    return spread, float(np.median(lasts / (ends - starts))) / NS
