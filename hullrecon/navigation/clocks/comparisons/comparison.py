# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A comparison of two sensors' clocks by a motion that both measured (docs/methods.md, Clocks).

Offsets here say by how much a sensor's stamps are late: they are to be subtracted from the stamps,
and are negative where these are early.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.records.clock import NS
from hullrecon.typing import Array, Ints

TRAY_AXIS = np.array([0.0, 1.0, 0.0])  # of tray and vehicle


class ClockedSensor(StrEnum):
    """Sensors with a clock of their own. Both cameras share one clock."""

    DVL = "DVL"
    IMU = "IMU"
    PRESSURE = "pressure"
    IMAGES = "images"


Offsets = Mapping[ClockedSensor, float]  # by which stamps are late, s; 0 for sensors not in it
Span = tuple[int, int]  # first and last instant, ns


@dataclass(frozen=True, kw_only=True)
class ClockComparison:
    """Residuals of two sensors' measurements of one motion, as a function of time offsets."""

    first: ClockedSensor
    second: ClockedSensor
    systematic_s: float  # sigma of the relative offset's error that no number of rows reduces
    begin_ns: Ints  # (n,) first instant of the motion of each row
    end_ns: Ints  # (n,) its last instant
    block: Ints  # (n,) number of the block; errors are common within a block only
    # residuals (n, k) of rows (n,) at some offsets, NaN where unknown
    evaluate: Callable[[Offsets, Ints], Array]
    rows: Ints  # (n,) the rows that are used, as `evaluate` numbers them
    least_rows: int  # that are needed for an estimate
    least_blocks: int = 1

    def residuals(self, offsets: Offsets) -> Array:
        """Compute the residuals (n, k) of all rows at some offsets."""
        return self.evaluate(offsets, self.rows)

    def moved(self, offsets: Offsets, more_s: float) -> dict[ClockedSensor, float]:
        """Add more_s to the first sensor's offset, and keep the others."""
        return {**offsets, self.first: offsets.get(self.first, 0.0) + more_s}

    def within(self, span: Span) -> ClockComparison:
        """Keep the rows between two instants."""
        kept = np.flatnonzero((self.begin_ns >= span[0]) & (self.end_ns <= span[1]))
        cut = {name: getattr(self, name)[kept] for name in ("begin_ns", "end_ns", "block", "rows")}
        return replace(self, **cut)

    @property
    def is_enough(self) -> bool:
        """Tell whether the rows suffice to estimate an offset with its sigma."""
        enough = len(self.rows) >= self.least_rows
        return enough and len(np.unique(self.block)) >= self.least_blocks


def shift_between_ns(offsets: Offsets, sensor: ClockedSensor, other: ClockedSensor) -> int:
    """Compute what to add to stamps of `other` so that `sensor` can be looked up at them, ns."""
    return round((offsets.get(sensor, 0.0) - offsets.get(other, 0.0)) * NS)


def fast_rotation(attitude: AttitudeHistory) -> Callable[[Ints], Rotation]:
    """Make a function that interpolates R_g_v (m) at times (m,) as attitude.rotation does, faster.

    The search calls it at a thousand offsets. So what depends on the readings alone is computed
    once.
    """
    # Slerp is a sum of both quaternions, weighted by sines of shares of the angle between them.
    t_ns, start = attitude.t_ns, attitude.quaternion[:-1]
    if len(t_ns) < 2:
        return attitude.rotation
    same_side = np.where((start * attitude.quaternion[1:]).sum(axis=1) < 0, -1.0, 1.0)
    stop = attitude.quaternion[1:] * same_side[:, None]
    # between both quaternions, in half turns, as of `sinc`
    angle = 2 * np.arcsin(np.minimum(0.5 * np.linalg.norm(stop - start, axis=1), 1.0)) / np.pi
    start, stop = (ends / np.sinc(angle)[:, None] for ends in (start, stop))
    duration = np.maximum(1, np.diff(t_ns))

    def rotation(at_ns: Ints) -> Rotation:
        """Interpolate R_g_v (m). Before the first and after the last reading, it is theirs."""
        at = np.clip(at_ns, t_ns[0], t_ns[-1])
        row = np.clip(np.searchsorted(t_ns, at, side="right") - 1, 0, len(duration) - 1)
        share, turn = (at - t_ns[row]) / duration[row], angle[row]
        back, ahead = (part * np.sinc(part * turn) for part in (1 - share, share))
        return Rotation.from_quat(back[:, None] * start[row] + ahead[:, None] * stop[row])

    return rotation
