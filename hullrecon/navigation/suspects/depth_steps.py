# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find steps in the depth that the vehicle did not make, and take them off.

A port clogs or comes free, a sensor is tared under water or falls back to another range. Between
two readings the DVL knows the way down to millimetres. So a step tells nothing of the vehicle, and
the readings before and after it are as good as ever but for their level.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.geometry.robust import robust_sigma
from hullrecon.navigation.sensors.smoothing import running_median
from hullrecon.navigation.suspects.comparisons import LONGEST_GAP_S, track_of
from hullrecon.records.clock import NS, format_time, seconds
from hullrecon.records.sensors import PressureSamples, SensorRecords
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

LEAST_STEP_M, STEP_SIGMAS = 0.3, 6.0  # between two readings, beyond the DVL's way
MEDIAN = 5  # readings of the running median, which single outliers do not move
BESIDE_S = 2.0  # of readings on either side that tell a step's size
# more are no steps of a level: readings that are rounded to half a metre, or another motion
MOST_STEPS = 5


@dataclass(frozen=True, kw_only=True)
class DepthSteps:
    """Steps (k) of the depth that the DVL did not see."""

    t_ns: Ints  # (k,) of the first reading after each
    size: Array  # (k,) m, positive where the sensor seems to sink
    mended: PressureSamples  # all on the level of the longest part between two steps

    def finding(self, where: str) -> Finding:
        """Say by how much the depth stepped, and when. where: the sensor's topic."""
        values = {
            "by_m": [float(step) for step in self.size],
            "first": format_time(int(self.t_ns[0])),
            "offset_m": self.largest_offset_m,
        }
        return Finding("depth-steps", values, where)

    @property
    def largest_offset_m(self) -> float:
        """Largest difference between the levels of two parts, m."""
        return float(np.ptp(np.concatenate([[0.0], np.cumsum(self.size)])))


def depth_steps(records: SensorRecords, rig: Rig) -> DepthSteps | None:
    """Compare neighbouring readings of the pressure sensor with the way of the DVL.

    None where no step, or more than a level has, is found.
    """
    pressure, track = records.pressure, track_of(records, rig)
    if pressure is None or track is None:
        return None
    known = np.isfinite(pressure.depth)
    known &= (pressure.t_ns >= track.t_ns[0]) & (pressure.t_ns <= track.t_ns[-1])
    t_ns = pressure.t_ns[known]
    if len(t_ns) < 2 * MEDIAN:
        return None
    t_s = seconds(t_ns, int(track.t_ns[0]))
    sunk = np.interp(t_s, track.way.t_s, track.way.total[:, 2] - track.lever[:, 2])
    gap = pressure.depth[known] - sunk
    level = running_median(gap[:, None], MEDIAN)[:, 0]
    white = robust_sigma(np.diff(gap, n=2), about=0.0) / np.sqrt(6)
    is_step = np.abs(np.diff(level)) > max(LEAST_STEP_M, STEP_SIGMAS * white)
    rows = 1 + np.flatnonzero(is_step & _is_heard(t_ns, track.t_ns))
    if not 0 < len(rows) <= MOST_STEPS:
        return None

    # Levels on either side of each step, and all parts moved onto the level of the longest.
    ends = [0, *rows.tolist(), len(t_s)]
    size = np.array(
        [
            _level(gap[at:after], t_s[at:after] - t_s[at])
            - _level(gap[before:at], t_s[before:at] - t_s[at])
            for before, at, after in zip(ends[:-2], ends[1:-1], ends[2:], strict=True)
        ]
    )
    offset = np.concatenate([[0.0], np.cumsum(size)])
    offset -= offset[np.argmax(np.diff(ends))]
    part = np.searchsorted(t_ns[rows], pressure.t_ns, side="right")
    mended = replace(pressure, depth=pressure.depth - offset[part])
    return DepthSteps(t_ns=t_ns[rows], size=size, mended=mended)


def _is_heard(read_ns: Ints, heard_ns: Ints) -> Mask:
    """Tell of neighbouring readings (n - 1,) whether neither they nor the DVL's were silent.

    Across a silence its way is a guess. read_ns (n,): within the span of heard_ns.
    """
    after = np.searchsorted(heard_ns, read_ns[1:])
    before = np.searchsorted(heard_ns, read_ns[:-1], side="right") - 1
    apart_ns = np.maximum(heard_ns[after] - heard_ns[before], np.diff(read_ns))
    return np.asarray(apart_ns < LONGEST_GAP_S * NS)


def _level(gap: Array, from_step_s: Array) -> float:
    """Compute the median of a part's readings, of those within BESIDE_S of a step if there are."""
    near = np.abs(from_step_s) < BESIDE_S
    return float(np.median(gap[near] if near.any() else gap))
