# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Put the sensors of a bag onto one time base, by when their messages were logged.

Each message of a bag has two times: the stamp of its sensor and when it was logged. Their
difference is known for every topic, so that stamps of different bases (a simulator's time, a clock
that was never set, a topic without stamps) can be joined.
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
# later; a stamp that lags further behind is of another clock
LONGEST_DELAY_S = 60.0
LEAST = 5  # readings that tell an offset
# of a clock's error in rate; crystals are within 1e-4. A delay that grows faster is a queue's, one
# that shrinks faster a queue's that empties, unless the stamps run ahead of when they were logged
FASTEST_DRIFT, FASTEST_AHEAD = 1e-3, 0.05
LEAST_DRIFT_S = 0.05  # over the log, that is put right
STRAIGHT = 0.2  # of the drift, that 80 % of the delays stay within of a line
BLOCK_S = 2.0  # over which the offset of a clock that runs at another rate is constant


@dataclass(frozen=True, eq=False)
class BagStamps:
    """The stamps of one sensor in bags, in the order of the logs."""

    stamp_ns: Ints  # (n,)
    logged_ns: Ints  # (n,), equal to the stamp where the message has none

    @property
    def delay_ns(self) -> Ints:
        return self.logged_ns - self.stamp_ns

    @property
    def is_stamped(self) -> bool:
        return bool(self.delay_ns.any())

    @property
    def median_ns(self) -> int:
        return int(np.median(self.delay_ns))

    @property
    def spread_s(self) -> float:
        """The range of 80 % of the delays."""
        low, high = np.percentile(self.delay_ns, [10, 90])
        return float(high - low) / NS

    @property
    def is_steady(self) -> bool:
        return self.spread_s < JUMP_S

    @property
    def runs_at_another_rate(self) -> bool:
        """Tell whether the clock is far from the logger's, and comes nearer or goes away evenly."""
        largest_s = float(np.abs(np.diff(self.delay_ns)).max()) / NS
        is_even = largest_s < 0.5 * self.spread_s
        return is_even and abs(self.median_ns) > LONGEST_DELAY_S * NS

    def drift(self) -> tuple[float, Ints] | None:
        """Measure how much faster the clock runs than the logger's, and its delays by that, ns.

        None where the delays do not grow or shrink along a line, as those of a clock do. A clock
        that is slow by more than FASTEST_DRIFT cannot be told from a queue that grows.
        """
        at_s = (self.logged_ns - self.logged_ns[0]) / NS
        delay_s = (self.delay_ns - self.delay_ns[0]) / NS
        slope, start_s = np.polyfit(at_s, delay_s, 1) if np.ptp(at_s) > 0 else (0.0, 0.0)
        grown_s = abs(slope) * float(np.ptp(at_s))
        low, high = np.percentile(delay_s - start_s - slope * at_s, [10, 90])
        if abs(slope) > FASTEST_AHEAD:
            return None
        if max(LEAST_DRIFT_S, (high - low) / STRAIGHT) > grown_s:
            return None
        by_rate_s = start_s + slope * at_s
        return -float(slope), self.delay_ns[0] + np.round(by_rate_s * NS).astype(np.int64)


def join_time_bases(
    sensors: Mapping[str, BagStamps],
) -> tuple[dict[str, Ints], list[Finding]]:
    """Compute what to add to stamps (n,), ns, of each sensor that is on another time base.

    The base of most sensors holds, of two alike the one nearer to the logger's clock.
    """
    known = {name: stamps for name, stamps in sensors.items() if len(stamps.stamp_ns) >= LEAST}
    if len(known) < 2:
        return {}, []
    # The sensors of the right base: the largest group with one offset from the logger's clock.
    offset_ns = {name: stamps.median_ns for name, stamps in known.items()}
    alike = [
        [name for name in known if abs(offset_ns[name] - middle) < JUMP_S * NS]
        for middle in offset_ns.values()
    ]
    right = max(alike, key=lambda names: (len(names), -min(abs(offset_ns[n]) for n in names)))
    shifts: dict[str, Ints] = {}
    notes: list[Finding] = []
    # Clocks that drift, and queues that fall behind, which look like slow clocks.
    drifts = {name: found for name in known if (found := known[name].drift()) is not None}
    behind = [name for name, (rate, _) in drifts.items() if rate < -FASTEST_DRIFT]
    for name in behind:
        _, delay_ns = drifts.pop(name)
        if len(behind) < len(known):  # else the logger's clock is fast
            seconds = float(delay_ns[-1] - delay_ns[0]) / NS
            notes.append(Finding("stamps-fall-behind", {"seconds": seconds}, name))
    if 0 < len(drifts) < len(right):
        straight_ns = round(float(np.median([offset_ns[n] for n in right if n not in drifts])))
        for name, (rate, delay_ns) in drifts.items():
            is_ahead = delay_ns[-1] < straight_ns - LEAST_DRIFT_S * NS
            if rate > FASTEST_DRIFT and not is_ahead:
                continue
            shifts[name] = delay_ns - straight_ns
            notes.append(Finding("clock-drifts", {"per_million": 1e6 * rate}, name))
    # All others of another base are shifted onto the right one.
    for name, stamps in ((name, known[name]) for name in known if name not in shifts):
        shift = None if name in right else _shift(stamps, [known[other] for other in right])
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


def _shift(stamps: BagStamps, right: Sequence[BagStamps]) -> Ints | None:
    """Compute what to add to a sensor's stamps. None where they are right, or none can tell.

    A steady sensor is logged by a constant delay after its stamp. Where a sensor of the right base
    is steady too, the difference of delays is the shift. Stamps that were logged seconds late are
    right all the same. Those ahead of the logger's clock by a second are not. Where either is not
    steady, times of logging carry the stamps over.
    """
    steady = [other.median_ns for other in right if other.is_steady]
    if stamps.is_steady and steady:
        shift_ns = stamps.median_ns - round(float(np.median(steady)))
        is_late = stamps.is_stamped and -JUMP_S * NS < shift_ns < LONGEST_DELAY_S * NS
        return None if is_late else np.full(len(stamps.stamp_ns), shift_ns, np.int64)
    if steady and not stamps.runs_at_another_rate:
        return None  # it jumps, or was logged late now and then
    # Either clock runs at another rate than the logger's, as a simulator's does. When a steady
    # sensor measured is known from the logger's clock, else only when it was logged.
    logged = stamps.logged_ns - (stamps.median_ns if stamps.is_steady else 0)
    if steady:  # the right base keeps the logger's pace
        return logged - round(float(np.median(steady))) - stamps.stamp_ns
    # the right base does not: its own delays tell where it was at each time of logging
    longest = max(right, key=lambda other: len(other.stamp_ns))
    return logged + _follow(logged, longest) - stamps.stamp_ns


def _follow(logged_ns: Ints, other: BagStamps) -> Ints:
    """Compute what to add to times of logging, to have the stamps of another sensor."""
    order = np.argsort(other.logged_ns, kind="stable")
    at, delay = other.logged_ns[order], other.delay_ns[order]
    block = (at - at[0]) // round(BLOCK_S * NS)
    parts = np.split(np.arange(len(at)), np.flatnonzero(np.diff(block)) + 1)
    middle_s, delay_s = (
        np.array([float(np.median(values[part] - values[0])) for part in parts]) / NS
        for values in (at, delay)
    )
    if len(middle_s) > 1:  # the first and last readings lie beyond the middles
        ends_s = np.array([0.0, (at[-1] - at[0]) / NS])
        slope = [(delay_s[k + 1] - delay_s[k]) / (middle_s[k + 1] - middle_s[k]) for k in (0, -2)]
        beyond_s = delay_s[[0, -1]] + slope * (ends_s - middle_s[[0, -1]])
        middle_s, delay_s = (
            np.concatenate([end[:1], inner, end[1:]])
            for end, inner in ((ends_s, middle_s), (beyond_s, delay_s))
        )
    more_s = np.interp((logged_ns - at[0]) / NS, middle_s, delay_s)
    return np.asarray(-delay[0] - np.round(more_s * NS), np.int64)
