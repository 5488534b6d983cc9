# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One reading of one sensor, as passed on by every reader.

SI units, stamps in int64 nanoseconds since 1970, NaN for lost values.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Array, Ints

LOST = np.full(3, np.nan)  # a vector that was not measured


@dataclass(frozen=True, slots=True)
class DvlSample:
    """One ping of a DVL."""

    t_ns: int
    velocity: Array  # (3,) m/s, of the instrument over ground in `dvl`
    sigma: float  # m/s, of the velocity; NaN: not given
    ranges: Array  # (b,) m along the beams; empty where the log has none
    beams: Array | None  # (b, 3) unit vectors in `dvl`; None where the log does not carry them
    # instrument that the message's type names, where `beams` are by its data sheet and not logged
    instrument: str = ""
    # m along z of `dvl` to what the beams meet, as the instrument computed it; NaN where the log
    # has none, or one that means something else
    altitude: float = float("nan")
    along_axis: bool = False  # ranges are along z of `dvl`, wherever the beams turn out to point
    # of a table: its writer may have taken distances along the axis for ranges
    by_hand: bool = False
    # what a measured velocity is relative to, where that is not the ground; it is lost then
    not_over_ground: str = ""

    def __post_init__(self) -> None:
        _require(self.velocity.shape == (3,) and self.ranges.ndim == 1)
        _require(self.beams is None or (self.beams.ndim == 2 and self.beams.shape[1] == 3))


@dataclass(frozen=True, slots=True)
class ImuSample:
    """One reading of an attitude sensor, in its own convention."""

    t_ns: int
    quaternion: Array  # (4,) x, y, z, w as logged
    rates: Array  # (3,) rad/s; NaN when not logged
    acceleration: Array  # (3,) m/s2; NaN when not logged
    # the attitude of the frame `dvl` in north-east-down (any north), by sensors inside the DVL
    of_dvl: bool = False

    def __post_init__(self) -> None:
        _require(
            self.quaternion.shape == (4,) and self.rates.shape == self.acceleration.shape == (3,)
        )


@dataclass(frozen=True, slots=True)
class PressureSample:
    """One reading of a pressure sensor."""

    t_ns: int
    pascal: float  # absolute


@dataclass(frozen=True, slots=True)
class DepthSample:
    """One depth or height."""

    t_ns: int
    height: float  # m from the water's surface, as logged
    is_up: bool  # it grows upward, by the convention of its type
    of_dvl: bool = False  # by a sensor inside the DVL


@dataclass(frozen=True, slots=True)
class JointSample:
    """One angle of one servo."""

    t_ns: int
    name: str
    angle: float  # rad


@dataclass(frozen=True, slots=True)
class ImageSample:
    """One image, encoded, or the file that holds it."""

    t_ns: int
    camera: str  # "camera_top", "camera_bottom"
    encoded: bytes  # of a JPEG, PNG, ...
    file: str = ""  # relative to the package; its bytes stay there


@dataclass(frozen=True, slots=True)
class SonarSample:
    """One ping of an imaging sonar."""

    t_ns: int
    image: NDArray[np.generic]  # (beams, ranges), of the logged type
    directions: Array | None  # (beams, 3) unit vectors in `sonar`; None where nothing says
    range_m: Array  # (ranges,)

    def __post_init__(self) -> None:
        """Refuse shapes that do not fit each other, and numbers that are not finite."""
        beams = len(self.image) if self.directions is None else len(self.directions)
        _require(self.image.shape == (beams, len(self.range_m)) and self.image.size > 0)
        _require(
            bool(np.isfinite(self.range_m).all())
            and (self.directions is None or bool(np.isfinite(self.directions).all()))
        )


@dataclass(frozen=True, slots=True)
class PositionSample:
    """One position by GPS or USBL."""

    t_ns: int
    # (3,) latitude and longitude in degrees and height in m where geographic, else x, y, z in m in
    # a local frame; NaN without a fix
    place: Array
    sigma_m: float  # of either horizontal axis; NaN: not given
    geographic: bool
    by_satellite: bool = False  # by an antenna that receives above water only

    def __post_init__(self) -> None:
        _require(self.place.shape == (3,))


def _require(holds: bool) -> None:
    """Refuse fields of other shapes, which a damaged type definition gives."""
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


def is_of_dvl(sample: object) -> bool:
    """Tell whether a sample is an attitude or a depth by sensors inside the DVL."""
    return isinstance(sample, ImuSample | DepthSample) and sample.of_dvl


def stamps(samples: Sequence[Sample]) -> Ints:
    """List the stamps (n,), ns, of samples."""
    return np.array([sample.t_ns for sample in samples], np.int64)


def find_copies(samples: Sequence[Sample], log: Sequence[int]) -> list[int]:
    """Find the rows whose reading, with the same stamp, stands earlier in the same log already.

    They were written twice, and are to be left out. Equal readings of two logs are no copies: they
    are two recordings of one message, by which the clocks of the loggers are compared.

    log: number of the log of each sample.
    """
    keys = np.array([(number, s.t_ns) for number, s in zip(log, samples, strict=True)], np.int64)
    if not len(keys):
        return []
    _, first, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    earlier = first[group.ravel()]
    again = np.flatnonzero(earlier != np.arange(len(keys)))
    return [row for row in again.tolist() if _is_same(samples[earlier[row]], samples[row])]


def are_written_twice(samples: Sequence[Sample]) -> bool:
    """Tell whether most readings with the stamp of the one before are also equal to it."""
    alike = [_is_same(a, b) for a, b in itertools.pairwise(samples) if a.t_ns == b.t_ns]
    return sum(alike) > len(alike) / 2


def _is_same(one: Sample, other: Sample) -> bool:
    """Tell whether two samples are equal in every field, NaN to NaN."""
    names = [field.name for field in fields(one)]
    return type(one) is type(other) and all(
        repr(getattr(one, name)) == repr(getattr(other, name)) for name in names
    )
