# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find steps of the pressure sensor's depth that the vehicle did not make, and correct them.

The port of a sensor clogs or comes free, or a sensor is tared under water or switches to another
range. Between two readings the DVL measures the change of depth to millimetres. So a larger step is
an error of the sensor, and the readings on either side of it are right but for a constant offset.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.geometry.robust import robust_sigma
from hullrecon.navigation.sensors.smoothing import running_median
from hullrecon.navigation.suspects.comparisons.comparison import LONGEST_GAP_S
from hullrecon.navigation.suspects.comparisons.dvl_track import track_of
from hullrecon.records.clock import NS, format_time, seconds
from hullrecon.records.sensors import PressureSamples, SensorRecords
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

# Least step between two readings that counts, less the DVL's change of depth: m, and sigmas of the
# readings' noise
LEAST_STEP_M, STEP_SIGMAS = 0.3, 6.0
MEDIAN = 5  # readings of the running median, so that one or two outliers are no step
BESIDE_S = 2.0  # span of the readings on either side of a step from which its size is measured
# More steps than this are another fault: readings rounded to half a metre, or another motion
MOST_STEPS = 5


@dataclass(frozen=True, kw_only=True)
class DepthSteps:
    """Steps (k) of the depth that the DVL did not measure."""

    t_ns: Ints  # (k,) stamps of the first reading after each step
    size: Array  # (k,) m, positive where the sensor seems to sink
    # Corrected readings. Those of all parts between steps are shifted onto the level of the part
    # with the most readings
    mended: PressureSamples

    def finding(self, where: str) -> Finding:
        """Make the finding of how much the depth stepped, and when.

        where: the topic of the pressure sensor.
        """
        values = {
            "by_m": [float(step) for step in self.size],
            "first": format_time(int(self.t_ns[0])),
            "offset_m": self.largest_offset_m,
        }
        return Finding("depth-steps", values, where)

    @property
    def largest_offset_m(self) -> float:
        """Largest difference between the levels of two parts, m.

        Which level is right is not known, so any depth may be off by as much.
        """
        return float(np.ptp(np.concatenate([[0.0], np.cumsum(self.size)])))


def depth_steps(records: SensorRecords, rig: Rig) -> DepthSteps | None:
    """Find steps of the pressure sensor's depth beyond the change of depth by the DVL.

    None without a DVL, an IMU or enough readings, and where no step is found or more than
    MOST_STEPS.
    """
    pressure, track = records.pressure, track_of(records, rig)
    if pressure is None or track is None:
        return None
    usable = np.isfinite(pressure.depth)
    usable &= (pressure.t_ns >= track.t_ns[0]) & (pressure.t_ns <= track.t_ns[-1])
    t_ns = pressure.t_ns[usable]
    if len(t_ns) < 2 * MEDIAN:
        return None
    t_s = seconds(t_ns, int(track.t_ns[0]))
    # Depth less that by the DVL, up to a constant. It changes by noise and steps only
    by_dvl = np.interp(t_s, track.way.t_s, track.way.total[:, 2] - track.lever[:, 2])
    excess = pressure.depth[usable] - by_dvl
    level = running_median(excess[:, None], MEDIAN)[:, 0]
    white = robust_sigma(np.diff(excess, n=2), about=0.0) / np.sqrt(6)  # sigma of a reading
    is_step = np.abs(np.diff(level)) > max(LEAST_STEP_M, STEP_SIGMAS * white)
    rows = 1 + np.flatnonzero(is_step & _is_without_gap(t_ns, track.t_ns))
    if not 0 < len(rows) <= MOST_STEPS:
        return None

    # Size of each step, from the levels on either side of it
    ends = [0, *rows.tolist(), len(t_s)]
    size = np.array(
        [
            _level_beside(excess[at:after], t_s[at:after] - t_s[at])
            - _level_beside(excess[before:at], t_s[before:at] - t_s[at])
            for before, at, after in zip(ends[:-2], ends[1:-1], ends[2:], strict=True)
        ]
    )
    # Offset of each part from the part with the most readings, onto whose level all are shifted
    offset = np.concatenate([[0.0], np.cumsum(size)])
    offset -= offset[np.argmax(np.diff(ends))]
    part = np.searchsorted(t_ns[rows], pressure.t_ns, side="right")
    mended = replace(pressure, depth=pressure.depth - offset[part])
    return DepthSteps(t_ns=t_ns[rows], size=size, mended=mended)


def _is_without_gap(read_ns: Ints, ping_ns: Ints) -> Mask:
    """Tell for each two neighbouring readings (n - 1,) whether no long gap lies between them.

    Neither the readings nor the pings about them may be LONGEST_GAP_S apart: in an outage the
    DVL's change of depth is only interpolated.

    Parameters
    ----------
    read_ns
        Stamps (n,) of the pressure sensor, all within the span of the pings.
    ping_ns
        Stamps of the pings with a velocity.
    """
    after = np.searchsorted(ping_ns, read_ns[1:])
    before = np.searchsorted(ping_ns, read_ns[:-1], side="right") - 1
    apart_ns = np.maximum(ping_ns[after] - ping_ns[before], np.diff(read_ns))
    return np.asarray(apart_ns < LONGEST_GAP_S * NS)


def _level_beside(excess: Array, since_step_s: Array) -> float:
    """Compute the level of one part beside a step: the median of its readings near the step.

    Where no reading lies within BESIDE_S of the step, the median of the whole part.

    Parameters
    ----------
    excess
        Depth (m,) less that by the DVL, m.
    since_step_s
        Times (m,) since the step, negative before it.
    """
    near = np.abs(since_step_s) < BESIDE_S
    return float(np.median(excess[near] if near.any() else excess))
