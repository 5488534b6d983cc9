# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The tray's servo: its angle at any time, and the side of its backlash on which it rests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import robust_sigma
from hullrecon.records.sensors import JointSamples
from hullrecon.typing import Array, Ints

LEAST_TRAVEL_RAD = np.radians(0.3)  # a servo's reading flickers by less; a command moves it farther


@dataclass(frozen=True)
class Servo:
    """Readings t_ns (n,), angle (n,) rad; direction (n,): +1 or -1, the sense in which it last moved."""

    t_ns: Ints
    angle: Array
    direction: Array

    def angle_at(self, t_ns: Ints) -> Array:
        """Return (m,) rad, linear; the ends held."""
        start = self.t_ns[0]
        return np.asarray(np.interp((t_ns - start).astype(float), (self.t_ns - start).astype(float), self.angle))

    def direction_at(self, t_ns: Ints) -> Array:
        """Return (m,) +1 or -1."""
        return self.direction[np.clip(np.searchsorted(self.t_ns, t_ns, side="right") - 1, 0, len(self.t_ns) - 1)]


def servo(tray: JointSamples | None, start_ns: int) -> Servo:
    """Return the servo of a joint's record in time order; one that was not logged stays at zero."""
    if tray is None or not np.isfinite(tray.angle).any():
        return Servo(np.array([start_ns]), np.zeros(1), np.ones(1))
    known = np.isfinite(tray.angle)
    angle = tray.angle[known]
    flicker = robust_sigma(np.diff(angle, n=2), about=0.0) / np.sqrt(6) if len(angle) > 2 else 0.0
    return Servo(tray.t_ns[known], angle, _directions(angle, max(LEAST_TRAVEL_RAD, 6 * float(flicker))))


def _directions(angle: Array, travel: float) -> Array:
    """Return +1 or -1 a reading: the sense flips when the angle has come back by `travel` from its farthest point, and is dated
    back to that point. A scan, since each flip decides what the next one is measured from."""
    out = np.ones(len(angle))
    sense, far, turned, first = 0, 0, 0, angle[0]
    for i, value in enumerate(angle.tolist()):
        if sense == 0:
            sense = int(value - first > travel) - int(first - value > travel)
        if (value - angle[far]) * sense >= 0:
            far = i
        elif (angle[far] - value) * sense > travel:
            out[turned : far + 1] = sense
            sense, turned, far = -sense, far + 1, i
    out[turned:] = sense or 1
    return out
