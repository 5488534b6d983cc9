# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Faults of a sensor's clock: stamps that are late or early, and a clock that runs fast or slow."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.faults.hypothesis import Hypothesis
from hullrecon.records.clock import NS
from hullrecon.records.sensors import SensorRecords
from hullrecon.typing import Ints

# By which stamps may be late (negative: early), as far as navigation/clocks searches. Near zero the
# steps are so small that the comparison of depths agrees at the nearest
TRIED_LATE_S = [s * late for late in (*np.arange(0.25, 5.0, 0.25), *range(5, 61)) for s in (1, -1)]
FASTEST = 0.03  # largest error of a clock's rate: quartz is right to 1e-4, a wrong divider is not

Stream = TypeVar("Stream")


@dataclass(frozen=True, kw_only=True)
class ClockFault:
    """A fault of a clock, and the stamps without it."""

    fault: str  # "clock" (offset) or "rate"
    value: str
    late_s: float  # by which the stamps are late (the last one, where the clock runs fast)
    t_ns: Ints  # corrected

    def hypothesis(self, sensor: Sensor, mended: SensorRecords) -> Hypothesis:
        """Make the hypothesis that a sensor has this fault."""
        return Hypothesis(
            sensor=sensor, fault=self.fault, value=self.value, mended=mended, late_s=self.late_s
        )

    def correct(self, record: Stream) -> Stream:
        """Replace a record's stamps by the corrected ones."""
        return replace(record, t_ns=self.t_ns)  # type: ignore[type-var]


def clock_faults(t_ns: Ints, farthest_s: float = np.inf) -> Iterator[ClockFault]:
    """Yield what may be wrong with a sensor's clock: offsets, and errors of its rate.

    t_ns (n,): stamps. farthest_s: larger offsets are not tried.
    """
    since_ns = t_ns - t_ns[:1]
    lasts_s = float(np.ptp(t_ns)) / NS if len(t_ns) else 0.0
    for late_s in (late_s for late_s in TRIED_LATE_S if abs(late_s) < farthest_s):
        moved = t_ns - round(late_s * NS)
        yield ClockFault(fault="clock", value=f"{late_s:g} s", late_s=late_s, t_ns=moved)
        if abs(late_s) < FASTEST * lasts_s:
            rate = late_s / lasts_s
            moved = t_ns - np.round(rate * since_ns).astype(np.int64)
            yield ClockFault(fault="rate", value=f"{100 * rate:+.1f}", late_s=late_s, t_ns=moved)
