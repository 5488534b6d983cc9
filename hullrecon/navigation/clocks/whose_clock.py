# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whose clock is wrong, where those of several sensors part: rules over how late each is beside
another.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.navigation.clocks.clock_errors import ClockError, Sensor
from hullrecon.navigation.clocks.stretches import Span
from hullrecon.navigation.clocks.time_shift import TimeShift

# An error that is put right, s; smaller ones are not told from none: bumps of the hull and waves
# look like some. Of the DVL's clock where one sensor alone tells it, and where images and pressure
# sensor do, whose own errors have nothing in common.
LEAST_S: Mapping[Sensor, float] = {
    Sensor.DVL: 0.25,
    Sensor.IMU: 0.05,
    Sensor.PRESSURE: 0.25,
    Sensor.IMAGES: 0.05,
}
LEAST_BY_TWO_S = 0.08
LEAST_BY_HULL_S = 0.2  # of an IMU that the form of the hull alone is held against
SIGMAS = 5.0
KNOWN_S = 0.1  # sigma of a shift that says something though it is none
AGREE_S = 0.2  # shifts by two sensors that differ by less are one


@dataclass(frozen=True, kw_only=True)
class Late:
    """By how much a sensor's clock is later than another one, s, with its sigma; sure: that it is
    at all.
    """

    seconds: float
    sigma_s: float
    sure: bool

    def and_later(self, more: Late) -> Late:
        """Return how late a clock is that is later still than this one."""
        sigma_s = float(np.hypot(self.sigma_s, more.sigma_s))
        return Late(
            seconds=self.seconds + more.seconds, sigma_s=sigma_s, sure=self.sure or more.sure
        )


def usable(found: TimeShift | None) -> Late | None:
    """Return by how much a clock is late, where that is known: surely so, or well enough to say
    that it is not.
    """
    if found is None or not found.is_unique():
        return None
    sure = found.is_sure(SIGMAS)
    return (
        Late(seconds=found.seconds, sigma_s=found.sigma_s, sure=sure)
        if sure or found.sigma_s <= KNOWN_S
        else None
    )


def against_most(span: Span, late: Mapping[Sensor, Late]) -> list[ClockError]:
    """Return the errors of the clocks that are not those of most sensors; of as many, those with
    the IMU are right.
    """

    def share_one(group: Sequence[Sensor]) -> bool:
        apart = {
            pair: abs(late[pair[0]].seconds - late[pair[1]].seconds)
            for pair in itertools.combinations(group, 2)
        }
        return all(
            seconds < max(LEAST_S[sensor] for sensor in pair) for pair, seconds in apart.items()
        )

    groups = [
        g
        for size in range(1, len(late) + 1)
        for g in itertools.combinations(late, size)
        if share_one(g)
    ]
    right = max(groups, key=lambda group: (len(group), Sensor.IMU in group))
    best = late[min(right, key=lambda sensor: late[sensor].sigma_s)]
    out = []
    for sensor, own in late.items():
        seconds, sigma_s = own.seconds - best.seconds, float(np.hypot(own.sigma_s, best.sigma_s))
        if sensor not in right and abs(seconds) >= max(LEAST_S[sensor], SIGMAS * sigma_s):
            out.append(
                error_of(
                    sensor, span, seconds, sigma_s, [other for other in Sensor if other in right]
                )
            )
    return out


def agree(turned: Late, sunk: Late) -> bool:
    """Return whether IMU and pressure sensor part from the DVL by the same."""
    return abs(sunk.seconds - turned.seconds) <= max(AGREE_S, 3 * turned.sigma_s)


def by_turn_and_depth(span: Span, turned: Late, sunk: Late | None) -> ClockError | None:
    """Return whose clock is wrong where the IMU parts from the DVL: the pressure sensor tells;
    without it the DVL's is. None where all three part: that one alone is wrong, and the turns
    deceive, is likelier.
    """
    if sunk is None:
        return error_of(Sensor.DVL, span, -turned.seconds, turned.sigma_s, [Sensor.IMU])
    if agree(turned, sunk):
        return error_of(
            Sensor.DVL, span, -sunk.seconds, sunk.sigma_s, [Sensor.IMU, Sensor.PRESSURE]
        )
    if not sunk.sure or abs(sunk.seconds) < LEAST_S[Sensor.PRESSURE]:
        return error_of(
            Sensor.IMU, span, turned.seconds, turned.sigma_s, [Sensor.DVL, Sensor.PRESSURE]
        )
    return None


def by_depth_too(span: Span, late: Mapping[Sensor, Late], sunk: Late | None) -> list[ClockError]:
    """Return the error of the DVL's clock where images and pressure sensor both tell it and much
    the same, with images and IMU that agree; none else. The depth tells it more exactly than the
    directions in which the camera went.
    """
    dvl, imu = late[Sensor.DVL], late.get(Sensor.IMU)
    if (
        sunk is None
        or not (dvl.sure and sunk.sure)
        or (imu is not None and abs(imu.seconds) >= LEAST_S[Sensor.IMU])
    ):
        return []
    if (
        min(abs(dvl.seconds), abs(sunk.seconds)) < LEAST_BY_TWO_S
        or abs(dvl.seconds + sunk.seconds) > AGREE_S
    ):
        return []
    others = [Sensor.IMU] * (imu is not None) + [Sensor.PRESSURE, Sensor.IMAGES]
    return [error_of(Sensor.DVL, span, -sunk.seconds, sunk.sigma_s, others)]


def error_of(
    sensor: Sensor, span: Span, late_s: float, sigma_s: float, beside: Sequence[Sensor]
) -> ClockError:
    return ClockError(
        sensor=sensor,
        from_ns=span[0],
        to_ns=span[1],
        late_s=late_s,
        sigma_s=sigma_s,
        beside=tuple(beside),
    )
