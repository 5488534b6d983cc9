# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Hold what each sensor measured: times in int64 nanoseconds since 1970, SI units, NaN for lost
values.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class DvlPings(Rows):
    """velocity (n, 3) m/s of the instrument in `dvl` (NaN when lost), velocity_sigma (n,) m/s,
    ranges (n, b) m along the beams (NaN when lost), beams (b, 3) unit vectors in `dvl`.
    """

    t_ns: Ints
    velocity: Array
    velocity_sigma: Array
    ranges: Array
    beams: Array

    SHARED: ClassVar = frozenset({"beams"})


@dataclass(frozen=True, kw_only=True)
class ImuSamples(Rows):
    """quaternion (n, 4): rotation of `vehicle` in `global` (NED-like, converted at ingest); rates
    (n, 3) rad/s and acceleration (n, 3) m/s2 in `vehicle`, NaN when not logged.
    """

    t_ns: Ints
    quaternion: Array
    angular_velocity: Array
    acceleration: Array


@dataclass(frozen=True, kw_only=True)
class PressureSamples(Rows):
    """depth (n,) m of the sensor below the surface, positive down."""

    t_ns: Ints
    depth: Array


@dataclass(frozen=True, kw_only=True)
class JointSamples(Rows):
    """angle (n,) rad of one servo as logged."""

    t_ns: Ints
    angle: Array


@dataclass(frozen=True, kw_only=True)
class ImageIndex(Rows):
    """Images of one camera in time order. file (n,) str: path relative to the package, or "" when
    the bytes lie in the ingest artifact's images_<camera>.bin at offset (n,), size (n,). usable
    (n,) bool: it decoded. bits (): that values of images of 16 bits take, 8 to 16.
    """

    t_ns: Ints
    file: NDArray[np.str_]
    offset: Ints
    size: Ints
    usable: Mask
    bits: Ints = field(default_factory=lambda: np.array(16))

    SHARED: ClassVar = frozenset({"bits"})


@dataclass(frozen=True, kw_only=True)
class SonarPings(Rows):
    """image (n, beams, ranges) uint8, directions (beams, 3) unit vectors in `sonar`, range_m
    (ranges,) bin centres.
    """

    t_ns: Ints
    image: NDArray[np.uint8]
    directions: Array
    range_m: Array

    SHARED: ClassVar = frozenset({"directions", "range_m"})


@dataclass(frozen=True, kw_only=True)
class PositionFixes(Rows):
    """Positions from outside, of GPS or USBL. north_east (n, 2) m of the first fix, north as its
    frame has it; sigma (n,) m of either.
    """

    t_ns: Ints
    north_east: Array
    sigma: Array


SensorRecord = DvlPings | ImuSamples | PressureSamples | JointSamples | SonarPings | PositionFixes


@dataclass(frozen=True, kw_only=True)
class SensorRecords:
    """What the sensors of one dive measured, images apart; None for a sensor of which nothing was
    read.
    """

    dvl: DvlPings | None = None
    imu: ImuSamples | None = None
    pressure: PressureSamples | None = None
    tray: JointSamples | None = None
    sonar_tray: JointSamples | None = None
    sonar: SonarPings | None = None
    position: PositionFixes | None = None

    def by_name(self) -> dict[str, SensorRecord]:
        """Return the records that are there by their field's name, in the order of the fields."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if value is not None}
