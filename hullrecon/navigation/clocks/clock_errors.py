# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Errors of sensors' clocks: in words, and taken off the stamps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import groupby

import numpy as np

from hullrecon.navigation.dead_reckoning.nodes import pair_frames
from hullrecon.records.clock import format_time
from hullrecon.records.sensors import ImageIndex
from hullrecon.typing import Ints

SAME_S = 0.1  # errors of neighbouring stretches that part by less are one


class Sensor(StrEnum):
    """Sensors that have a clock of their own; both cameras share one."""

    DVL = "DVL"
    IMU = "IMU"
    PRESSURE = "pressure"
    IMAGES = "images"


@dataclass(frozen=True, kw_only=True)
class ClockError:
    """The clock of a sensor is late_s late, early where that is negative, on stamps from from_ns to
    to_ns; beside: the sensors whose clocks it was held against.
    """

    sensor: Sensor
    from_ns: int
    to_ns: int
    late_s: float
    sigma_s: float
    beside: tuple[Sensor, ...]


def on_time(t_ns: Ints, errors: Iterable[ClockError], sensor: Sensor) -> Ints:
    """Return a sensor's stamps (n,) less what its clock was late."""
    out = t_ns.copy()
    for error in errors:
        if error.sensor is sensor:
            out[(t_ns >= error.from_ns) & (t_ns <= error.to_ns)] -= round(error.late_s * 1e9)
    return out


def late_beside(errors: Iterable[ClockError], sensor: Sensor, other: Sensor) -> float:
    """Return by how many seconds a sensor is later than another one, of errors in one stretch."""
    late_s = {error.sensor: error.late_s for error in errors}
    return late_s.get(sensor, 0.0) - late_s.get(other, 0.0)


def put_images_right(
    top: ImageIndex | None, bottom: ImageIndex | None, errors: Sequence[ClockError]
) -> tuple[ImageIndex | None, ImageIndex | None]:
    """Return the images of both cameras with their clock put right; those of the lower camera where
    they pair with the upper one's so.
    """
    if top is None or not any(error.sensor is Sensor.IMAGES for error in errors):
        return top, bottom
    moved = replace(top, t_ns=on_time(top.t_ns, errors, Sensor.IMAGES))
    if bottom is None:
        return moved, None
    along = replace(bottom, t_ns=on_time(bottom.t_ns, errors, Sensor.IMAGES))
    paired = [
        len(pair_frames(np.sort(moved.t_ns), np.sort(lower.t_ns))) for lower in (along, bottom)
    ]
    return moved, along if paired[0] >= paired[1] else bottom


def join_errors(errors: Sequence[ClockError]) -> list[ClockError]:
    """Return errors by sensor and time, those of neighbouring stretches that are much the same as
    one, the surer one.
    """
    out: list[ClockError] = []
    for found in sorted(errors, key=lambda one: (list(Sensor).index(one.sensor), one.from_ns)):
        last = out[-1] if out else None
        if (
            last is not None
            and (last.sensor, last.to_ns) == (found.sensor, found.from_ns)
            and _same(last, found)
        ):
            surer = min(last, found, key=lambda one: one.sigma_s)
            out[-1] = replace(surer, from_ns=last.from_ns, to_ns=found.to_ns)
        else:
            out.append(found)
    return out


def _same(first: ClockError, second: ClockError) -> bool:
    return abs(first.late_s - second.late_s) <= max(
        SAME_S, 3 * float(np.hypot(first.sigma_s, second.sigma_s))
    )


def describe_errors(errors: Sequence[ClockError]) -> list[str]:
    """Return a sentence for each sensor whose clock was wrong; errors as join_errors gives them."""
    out = []
    for sensor, parts in groupby(errors, key=lambda error: error.sensor):
        found = list(parts)
        spans = ", ".join(
            f"{abs(part.late_s):.2f} s {'late' if part.late_s > 0 else 'early'} (sigma {part.sigma_s:.3f} s)"
            f" from {format_time(part.from_ns)} to {format_time(part.to_ns)}"
            for part in found
        )
        *most, last = found[0].beside
        beside = f"those of {', '.join(most)} and {last}" if most else f"that of {last}"
        out.append(f"{sensor}: the clock is {spans}, beside {beside}; the stamps were put right")
    return out
