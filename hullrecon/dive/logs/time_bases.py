# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Put the sensors of a bag onto one time base, by when their messages were logged.

Each message of a bag has two times: the stamp of its sensor and when it was logged. The time of
logging minus the stamp is known for every topic. With it stamps of different bases (a simulator's
time, a clock that was never set, a topic without stamps) are put onto one base. It is positive
where the stamp is earlier than the logging, and is called the lag here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.dive.logs.timeline import JUMP_S
from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS
from hullrecon.typing import Ints

# messages are logged after they are stamped, the slowest (images, acoustic positions) seconds
# later; a stamp that is earlier still is of another clock
LONGEST_LAG_S = 60.0
LEAST = 5  # readings that tell an offset
# Errors of a clock's rate; crystals are within 1e-4. A lag that grows faster than the first is a
# queue's that fills. One that shrinks faster is a queue's that empties, unless the stamps run ahead
# of the logging: then it is a clock up to the second
FASTEST_DRIFT, FASTEST_AHEAD = 1e-3, 0.05
LEAST_DRIFT_S = 0.05  # over the log; a smaller drift is not corrected
STRAIGHT = 0.2  # of the drift: the band about a line that holds 80 % of the lags is narrower
# Blocks whose median lags are interpolated linearly, where a clock runs at another rate: long
# enough to hold many messages, short enough for the rate to be constant
BLOCK_S = 2.0


@dataclass(frozen=True, eq=False)
class BagStamps:
    """The stamps of one sensor in bags, in the order of the logs."""

    stamp_ns: Ints  # (n,)
    logged_ns: Ints  # (n,) by the logger's clock; the stamp where a message has only one time

    @property
    def logged_minus_stamp_ns(self) -> Ints:
        """The lag (n,) of logging after the stamp."""
        return self.logged_ns - self.stamp_ns

    @property
    def is_stamped(self) -> bool:
        """Whether the sensor's stamps are other than the times of logging."""
        return bool(self.logged_minus_stamp_ns.any())

    @property
    def median_lag_ns(self) -> int:
        return int(np.median(self.logged_minus_stamp_ns))

    @property
    def spread_s(self) -> float:
        """The width of the interval that holds the middle 80 % of the lags."""
        low, high = np.percentile(self.logged_minus_stamp_ns, [10, 90])
        return float(high - low) / NS

    @property
    def is_steady(self) -> bool:
        """Whether the lag is nearly constant, so that both clocks keep pace."""
        return self.spread_s < JUMP_S

    @property
    def runs_at_another_rate(self) -> bool:
        """Tell whether the clock is far from the logger's, and comes nearer or goes away evenly."""
        largest_s = float(np.abs(np.diff(self.logged_minus_stamp_ns)).max()) / NS
        is_even = largest_s < 0.5 * self.spread_s
        return is_even and abs(self.median_lag_ns) > LONGEST_LAG_S * NS

    def drift(self) -> tuple[float, Ints] | None:
        """Fit a line to the lags of a clock that runs faster or slower than the logger's.

        None where the lags do not grow or shrink along a line, as those of a clock do. The line is
        also found for a queue of messages that grows: from the lags it looks like a clock that is
        slow by more than FASTEST_DRIFT.

        Returns
        -------
        rate, s a second by which the clock is fast (negative: slow), and lags (n,) of the line, ns
        """
        at_s = (self.logged_ns - self.logged_ns[0]) / NS
        lag_s = (self.logged_minus_stamp_ns - self.logged_minus_stamp_ns[0]) / NS
        slope, start_s = np.polyfit(at_s, lag_s, 1) if np.ptp(at_s) > 0 else (0.0, 0.0)
        grown_s = abs(slope) * float(np.ptp(at_s))
        low, high = np.percentile(lag_s - start_s - slope * at_s, [10, 90])
        if abs(slope) > FASTEST_AHEAD:
            return None
        if max(LEAST_DRIFT_S, (high - low) / STRAIGHT) > grown_s:
            return None
        by_rate_s = start_s + slope * at_s
        lag_ns = self.logged_minus_stamp_ns[0] + np.round(by_rate_s * NS).astype(np.int64)
        return -float(slope), lag_ns


def join_time_bases(
    sensors: Mapping[str, BagStamps],
) -> tuple[dict[str, Ints], list[Finding]]:
    """Compute what to add to the stamps of each sensor that is on another time base.

    The base that most sensors share is the right one. Where two are shared by as many sensors, it
    is the one nearer to the logger's clock. Sensors of fewer than LEAST readings are left
    unchanged, and so are stamps of a queue that fills or empties: they only look like those of a
    clock that drifts. Nothing is moved where only one sensor remains.

    Returns
    -------
    by sensor, (n,) ns to add, without the sensors whose stamps stay; and findings
    """
    known = {name: stamps for name, stamps in sensors.items() if len(stamps.stamp_ns) >= LEAST}
    if len(known) < 2:
        return {}, []
    # The sensors of the right base: the largest group with one offset from the logger's clock.
    lag_ns = {name: stamps.median_lag_ns for name, stamps in known.items()}
    alike = [
        [name for name in known if abs(lag_ns[name] - middle) < JUMP_S * NS]
        for middle in lag_ns.values()
    ]
    right = max(alike, key=lambda names: (len(names), -min(abs(lag_ns[n]) for n in names)))
    shifts: dict[str, Ints] = {}
    notes: list[Finding] = []
    # Clocks that drift, and queues that fall behind, which look like slow clocks: the time from
    # stamp to logging grows in both.
    drifts = {name: found for name in known if (found := known[name].drift()) is not None}
    behind = [name for name, (rate, _) in drifts.items() if rate < -FASTEST_DRIFT]
    for name in behind:
        _, line_ns = drifts.pop(name)
        if len(behind) < len(known):  # else the logger's clock is fast
            seconds = float(line_ns[-1] - line_ns[0]) / NS
            notes.append(Finding("stamps-fall-behind", {"seconds": seconds}, name))
    if 0 < len(drifts) < len(right):
        usual_ns = round(float(np.median([lag_ns[n] for n in right if n not in drifts])))
        for name, (rate, line_ns) in drifts.items():
            is_ahead = line_ns[-1] < usual_ns - LEAST_DRIFT_S * NS
            if rate > FASTEST_DRIFT and not is_ahead:
                continue  # a queue that empties
            shifts[name] = line_ns - usual_ns
            notes.append(Finding("clock-drifts", {"per_million": 1e6 * rate}, name))
    # All others of another base are shifted onto the right one.
    for name, stamps in ((name, known[name]) for name in known if name not in shifts):
        shift = None if name in right else _find_shift(stamps, [known[other] for other in right])
        if shift is None:
            continue
        shifts[name] = shift
        spread_s = max(known[other].spread_s for other in (*right, name))
        values = {
            "count": len(shift),
            "seconds": float(np.median(shift)) / NS,
            "others": right,
            "spread_s": spread_s if spread_s < JUMP_S else None,
        }
        notes.append(Finding("time-base-joined", values, name))
    return shifts, notes


def _find_shift(stamps: BagStamps, right: Sequence[BagStamps]) -> Ints | None:
    """Compute what to add to the stamps (n,), ns, of a sensor that is not of the right base.

    A steady sensor is logged by a constant lag after its stamp. Where a sensor of the right base is
    steady too, the difference of the two lags is what to add. Where either is not steady, the times
    of logging carry the stamps over.

    Parameters
    ----------
    stamps : those of the sensor
    right : those of the sensors of the right base

    Returns
    -------
    (n,) ns, or None where the stamps may stay. Stamps that were only logged seconds later than
    others are right, those ahead of the logger's clock by a second or more are not. None too where
    the lag jumps, so that nothing tells.
    """
    steady_ns = [other.median_lag_ns for other in right if other.is_steady]
    if stamps.is_steady and steady_ns:
        shift_ns = stamps.median_lag_ns - round(float(np.median(steady_ns)))
        is_logged_late = stamps.is_stamped and -JUMP_S * NS < shift_ns < LONGEST_LAG_S * NS
        return None if is_logged_late else np.full(len(stamps.stamp_ns), shift_ns, np.int64)
    if steady_ns and not stamps.runs_at_another_rate:
        return None  # it jumps, or was logged late now and then
    # Either clock runs at another rate than the logger's, as a simulator's does. When a steady
    # sensor measured is known from the logger's clock, else only when it was logged.
    logged = stamps.logged_ns - (stamps.median_lag_ns if stamps.is_steady else 0)
    if steady_ns:  # the right base keeps the logger's pace
        return logged - round(float(np.median(steady_ns))) - stamps.stamp_ns
    # the right base does not: its own lags tell where it was at each time of logging
    longest = max(right, key=lambda other: len(other.stamp_ns))
    return logged + _to_clock_of(longest, logged) - stamps.stamp_ns


def _to_clock_of(other: BagStamps, logged_ns: Ints) -> Ints:
    """Compute what to add to logging times (n,), ns, to put them onto another sensor's clock.

    That is the negative of the other sensor's lag at these times. Its lags are reduced to medians
    over blocks of BLOCK_S, which are interpolated linearly. The line through the first two and the
    last two blocks is extended to the other sensor's first and last reading.
    """
    order = np.argsort(other.logged_ns, kind="stable")
    at, lag = other.logged_ns[order], other.logged_minus_stamp_ns[order]
    block = (at - at[0]) // round(BLOCK_S * NS)
    parts = np.split(np.arange(len(at)), np.flatnonzero(np.diff(block)) + 1)
    # median time and lag of each block, relative to the first reading
    middle_s, lag_s = (
        np.array([float(np.median(values[part] - values[0])) for part in parts]) / NS
        for values in (at, lag)
    )
    if len(middle_s) > 1:  # the first and last readings lie beyond the middles
        ends_s = np.array([0.0, (at[-1] - at[0]) / NS])
        slope = [(lag_s[k + 1] - lag_s[k]) / (middle_s[k + 1] - middle_s[k]) for k in (0, -2)]
        lag_at_ends_s = lag_s[[0, -1]] + slope * (ends_s - middle_s[[0, -1]])
        middle_s, lag_s = (
            np.concatenate([end[:1], inner, end[1:]])
            for end, inner in ((ends_s, middle_s), (lag_at_ends_s, lag_s))
        )
    interpolated_s = np.interp((logged_ns - at[0]) / NS, middle_s, lag_s)
    return np.asarray(-lag[0] - np.round(interpolated_s * NS), np.int64)
