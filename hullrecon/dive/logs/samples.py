# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One reading of one sensor, as every reader hands it on: SI units, int64 nanoseconds since 1970,
NaN for what is lost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Array


@dataclass(frozen=True, slots=True)
class DvlSample:
    """velocity (3,) m/s of the instrument in `dvl`; sigma m/s (NaN: not given); ranges (b,) m along
    the beams; beams (b, 3) unit vectors in `dvl`, None where the log does not carry them. ranges is
    empty where the log has none. instrument: set where the beams are not logged but those of the
    one instrument that the message's type names. altitude: m along z of `dvl` to what the beams
    meet, as the instrument computed it; NaN where the log has none, or one that means something
    else. along_axis: the ranges are along z of `dvl`, wherever the beams turn out to point.
    """

    t_ns: int
    velocity: Array
    sigma: float
    ranges: Array
    beams: Array | None
    instrument: str = ""
    altitude: float = float("nan")
    along_axis: bool = False

    def __post_init__(self) -> None:
        _require(self.velocity.shape == (3,) and self.ranges.ndim == 1)
        _require(self.beams is None or (self.beams.ndim == 2 and self.beams.shape[1] == 3))


@dataclass(frozen=True, slots=True)
class ImuSample:
    """quaternion (4,) x y z w as logged; rates (3,) rad/s, acceleration (3,) m/s2, NaN when not
    logged. of_dvl: the attitude of the frame `dvl` in north-east-down (any north), by sensors
    inside of the DVL.
    """

    t_ns: int
    quaternion: Array
    rates: Array
    acceleration: Array
    of_dvl: bool = False

    def __post_init__(self) -> None:
        _require(
            self.quaternion.shape == (4,) and self.rates.shape == self.acceleration.shape == (3,)
        )


@dataclass(frozen=True, slots=True)
class PressureSample:
    t_ns: int
    pascal: float  # absolute


@dataclass(frozen=True, slots=True)
class DepthSample:
    """height: as logged, m, from the water's surface; is_up: it grows upward, by the convention of
    its type. of_dvl: by a sensor inside of the DVL.
    """

    t_ns: int
    height: float
    is_up: bool
    of_dvl: bool = False


@dataclass(frozen=True, slots=True)
class JointSample:
    t_ns: int
    name: str
    angle: float  # rad


@dataclass(frozen=True, slots=True)
class ImageSample:
    """encoded: bytes of a JPEG, PNG, ...; or file: a path relative to the package, whose bytes stay
    there.
    """

    t_ns: int
    camera: str
    encoded: bytes
    file: str = ""


@dataclass(frozen=True, slots=True)
class SonarSample:
    """image (beams, ranges) of the logged type; directions (beams, 3) unit vectors in `sonar`, None
    where nothing says where the beams point; range_m (ranges,).
    """

    t_ns: int
    image: NDArray[np.generic]
    directions: Array | None
    range_m: Array

    def __post_init__(self) -> None:
        beams = len(self.image) if self.directions is None else len(self.directions)
        _require(self.image.shape == (beams, len(self.range_m)) and self.image.size > 0)
        _require(
            bool(np.isfinite(self.range_m).all())
            and (self.directions is None or bool(np.isfinite(self.directions).all()))
        )


@dataclass(frozen=True, slots=True)
class PositionSample:
    """place (3,): latitude, longitude deg, height m where geographic, else x, y, z m in a local
    frame; NaN without a fix. sigma_m: of either horizontal axis, NaN where it is not given.
    by_satellite: by an antenna that receives above water.
    """

    t_ns: int
    place: Array
    sigma_m: float
    geographic: bool
    by_satellite: bool = False

    def __post_init__(self) -> None:
        _require(self.place.shape == (3,))


def _require(holds: bool) -> None:
    """Refuse fields of other shapes: a damaged definition gives them, which would fail far from
    here.
    """
    if not holds:
        raise ValueError("its values are not of the shape of such a reading")


Sample = (
    DvlSample
    | ImuSample
    | PressureSample
    | DepthSample
    | JointSample
    | ImageSample
    | SonarSample
    | PositionSample
)
