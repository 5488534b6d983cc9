# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The tray's servo: its angle at any time, and the side of its backlash on which it rests."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.geometry.robust import robust_sigma
from hullrecon.records.clock import describe_silence, unread_s
from hullrecon.records.sensors import JointSamples
from hullrecon.typing import Array, Ints, Mask

LEAST_TRAVEL_RAD = np.radians(0.3)  # a servo's reading flickers by less; a command moves it farther
# sigma of the rate at which, and the largest angle by which, a tray may turn while nothing is read
UNREAD_RATE_RAD_S, UNREAD_RAD = 0.05, 0.5
# sigma of an angle whose readings are useless: trays tilt by up to some 30 degrees
UNKNOWN_TRAY_RAD = np.radians(10.0)
USELESS_ANGLES = ("tray-still", "tray-little")  # codes of the findings of `doubtful_angles`
# Readings in a row that repeat one, and how noise shows in the others: by neighbouring second
# differences of opposite signs (white noise correlates them by -2/3) that hardly ever are zero
LEAST_FROZEN, OPPOSED, FEW_REPEATS = 10, -0.25, 0.05
FEW_READINGS = 3  # fewer readings are a setting, not the record of a moving tray
# span of a tray's angles over their noise, from which on it has moved: white noise spans six to
# seven sigmas. It is also how many different values it has to have, as a coarse encoder has few
MOVED = 10.0


@dataclass(frozen=True, kw_only=True)
class Servo:
    """Readings of the tray's angle."""

    t_ns: Ints  # (n,)
    angle: Array  # (n,) rad
    is_read: bool = True  # False for a tray taken to be at zero, as no angle was logged

    def angle_at(self, t_ns: Ints) -> Array:
        """Interpolate the angle (m,) rad linearly, constant beyond the ends."""
        start = self.t_ns[0]
        return np.asarray(
            np.interp((t_ns - start).astype(float), (self.t_ns - start).astype(float), self.angle)
        )

    @cached_property
    def direction(self) -> Array:
        """Find in which sense (n,), +1 or -1, it last moved at each reading."""
        flicker = _flicker(self.angle) if len(self.angle) > 2 else 0.0
        return _directions_of_motion(self.angle, max(LEAST_TRAVEL_RAD, 6 * flicker))

    def direction_at(self, t_ns: Ints) -> Array:
        """Look up the sense of rotation (m,), +1 or -1, of the last reading before each time."""
        return self.direction[
            np.clip(np.searchsorted(self.t_ns, t_ns, side="right") - 1, 0, len(self.t_ns) - 1)
        ]

    def unread_sigma(self, t_ns: Ints) -> Array:
        """Compute the sigma (m,) rad of the angle by which the tray may have turned unread.

        It is 0 where the tray was not silent. Between two readings it is no more than their
        difference: a joint that is logged only when it turns is silent while it stands.
        """
        if len(self.t_ns) < FEW_READINGS:
            return np.zeros(len(t_ns))
        right = np.searchsorted(self.t_ns, t_ns)
        inside = (right > 0) & (right < len(self.t_ns))
        turned = np.abs(
            self.angle[np.minimum(right, len(self.angle) - 1)]
            - self.angle[np.maximum(right - 1, 0)]
        )
        most = np.where(inside, np.minimum(turned, UNREAD_RAD), UNREAD_RAD)
        return np.asarray(np.minimum(UNREAD_RATE_RAD_S * unread_s(self.t_ns, t_ns), most))

    def silence(self, t_ns: Ints) -> str:
        """Say for how long the servo was silent along nodes t_ns (m,). "" if it never was."""
        return describe_silence(self.t_ns, t_ns) if self.is_read else ""


def servo(tray: JointSamples | None, start_ns: int) -> Servo:
    """Build the servo from a joint's record in time order. Readings without an angle are dropped.

    A joint that was not logged stays at zero. start_ns: stamp that this single angle is given.
    """
    if tray is None or not np.isfinite(tray.angle).any():
        return Servo(t_ns=np.array([start_ns]), angle=np.zeros(1), is_read=False)
    known = np.isfinite(tray.angle)
    return Servo(t_ns=tray.t_ns[known], angle=tray.angle[known])


def doubtful_angles(tray: JointSamples | None, unit: str, sigma_rad: float) -> list[Finding]:
    """Report tray angles that cannot be right: a single one, and radians taken for degrees.

    The latter are suspected where a tray moves, but by less than its own sigma. Nothing is reported
    for fewer than FEW_READINGS, which are a setting.

    Parameters
    ----------
    tray
        Readings of the tray's joint, None if it was not logged.
    unit
        Unit in which the angles were taken to be logged, "rad" or "deg".
    sigma_rad
        Sigma of the tray's angle, as configured.
    """
    angle = np.zeros(0) if tray is None else tray.angle[np.isfinite(tray.angle)]
    if len(angle) < FEW_READINGS:
        return []
    span_rad = float(np.ptp(angle))
    if not span_rad:
        values = {"count": len(angle), "angle_deg": float(np.degrees(angle[0])) + 0.0}
        return [Finding("tray-still", values)]
    if unit != "deg" or not has_moved(angle) or span_rad > sigma_rad:
        return []
    values = {"span_deg": float(np.degrees(span_rad)), "sigma_deg": float(np.degrees(sigma_rad))}
    return [Finding("tray-little", values)]


def has_moved(angle: Array) -> bool:
    """Tell whether a servo's angles (n,), three or more, are those of a motion and not of noise."""
    return len(np.unique(angle)) > MOVED and float(np.ptp(angle)) > MOVED * _flicker(angle)


def frozen_readings(angle: Array) -> Mask:
    """Find readings (n,) that repeat the one before to the last digit, in runs that no noise makes.

    There the driver has hung and the tray may have moved. No reading is found where the others show
    no noise: such a servo repeats its angle while it rests.
    """
    same = np.concatenate([[False], np.diff(angle) == 0])
    run = np.cumsum(~same)
    is_long = np.bincount(run)[run] >= LEAST_FROZEN
    bend = np.diff(angle[~is_long & np.isfinite(angle)], n=2)
    if len(bend) < LEAST_FROZEN or same[~is_long].mean() > FEW_REPEATS:
        return np.zeros(len(angle), bool)
    most = 3 * np.median(np.abs(bend))  # a servo that starts or stops bends farther
    bend = np.clip(bend, -most, most)
    has_noise = bend[1:] @ bend[:-1] < OPPOSED * (bend @ bend)
    return np.asarray(is_long & same & has_noise)


def _flicker(angle: Array) -> float:
    """Estimate the noise of a servo's readings, rad, from their second differences."""
    return float(robust_sigma(np.diff(angle, n=2), about=0.0)) / float(np.sqrt(6))


def _directions_of_motion(angle: Array, travel: float) -> Array:
    """Find in which sense, +1 or -1, a servo last moved at each reading.

    The sense changes when the angle has come back by `travel` rad from its farthest point. The
    change is dated back to that point. A servo that never moves so far has the sense +1. The scan
    is sequential, as each change decides from where the next one counts.
    """
    out = np.ones(len(angle))
    # sense so far (0: none yet), row of the farthest angle, and first row of the present sense
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
