# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What each sensor measured: times in int64 ns since 1970, SI units, NaN for lost values."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class DvlPings(Rows):
    """Pings of a DVL."""

    t_ns: Ints
    velocity: Array  # (n, 3) m/s of the instrument in `dvl`, NaN when lost
    velocity_sigma: Array  # (n,) m/s
    ranges: Array  # (n, b) m along the beams, NaN when lost
    beams: Array  # (b, 3) unit vectors in `dvl`
    # share by which all ranges may be too long or short, beyond what the speed of sound makes
    range_scale_sigma: Array = field(default_factory=lambda: np.array(0.0))

    SHARED: ClassVar = frozenset({"beams", "range_scale_sigma"})


@dataclass(frozen=True, kw_only=True)
class ImuSamples(Rows):
    """Attitude and rates."""

    t_ns: Ints
    quaternion: Array  # (n, 4) global_from_vehicle (NED-like, converted at ingest)
    angular_velocity: Array  # (n, 3) rad/s in `vehicle`, NaN when not logged
    acceleration: Array  # (n, 3) m/s2 in `vehicle`, NaN when not logged


@dataclass(frozen=True, kw_only=True)
class PressureSamples(Rows):
    """Depth by the pressure sensor."""

    t_ns: Ints
    depth: Array  # (n,) m of the sensor below the surface, positive down


@dataclass(frozen=True, kw_only=True)
class JointSamples(Rows):
    """The angle of a servo as logged."""

    t_ns: Ints
    angle: Array  # (n,) rad


@dataclass(frozen=True, kw_only=True)
class ImageIndex(Rows):
    """Images of one camera in time order."""

    t_ns: Ints
    # (n,) path relative to the package, "" if the bytes are in the ingest artifact's
    # images_<camera>.bin
    file: NDArray[np.str_]
    offset: Ints  # (n,) in that file
    size: Ints  # (n,) bytes
    usable: Mask  # (n,) it decoded
    # bits used by the values of 16-bit images, 8 to 16
    bits: Ints = field(default_factory=lambda: np.array(16))

    SHARED: ClassVar = frozenset({"bits"})


@dataclass(frozen=True, kw_only=True)
class SonarPings(Rows):
    """Pings of an imaging sonar."""

    t_ns: Ints
    image: NDArray[np.uint8]  # (n, beams, ranges)
    directions: Array  # (beams, 3) unit vectors in `sonar`
    range_m: Array  # (ranges,) bin centres

    SHARED: ClassVar = frozenset({"directions", "range_m"})


@dataclass(frozen=True, kw_only=True)
class PositionFixes(Rows):
    """Position fixes (USBL, GNSS)."""

    t_ns: Ints
    north_east: Array  # (n, 2) m from the first fix, with the north of its frame
    # (n, 2) m, the same as if latitude and longitude, or x and y, had been exchanged in the log
    exchanged: Array
    sigma: Array  # (n,) m of either


SensorRecord = DvlPings | ImuSamples | PressureSamples | JointSamples | SonarPings | PositionFixes


@dataclass(frozen=True, kw_only=True)
class SensorRecords:
    """Measurements of one dive's sensors, without images. None for a sensor that was not read."""

    dvl: DvlPings | None = None
    imu: ImuSamples | None = None
    pressure: PressureSamples | None = None
    tray: JointSamples | None = None
    sonar_tray: JointSamples | None = None
    sonar: SonarPings | None = None
    position: PositionFixes | None = None

    def by_name(self) -> dict[str, SensorRecord]:
        """Collect the records that exist by their field's name, in the order of the fields."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if value is not None}
