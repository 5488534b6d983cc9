# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Bottom-track records of Nortek AD2CP: DF20 of Signature instruments, DF21 of DVLs.

Layouts: Nortek, Signature Integrator's Guide 6.1.3 [NortekAD2CP] and, for DF21, the driver of the
Woods Hole Oceanographic Institution [NortekDF21]. Axes are Nortek's XYZ, z out of the transducers.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from hullrecon.dive.logs.readers.unpack import DamagedError, fields
from hullrecon.dive.logs.samples import LOST
from hullrecon.typing import Array

DF20, DF21, WATER_TRACK, TEXT = 0x17, 0x1B, 0x1D, 0xA0  # kinds of blocks
VERSION = 1  # of each record; no other is described publicly
DF20_HEADER, DF21_HEADER = 78, 36  # bytes before the values
HAS_COMPASS, HAS_TILT, HAS_VELOCITY, HAS_DISTANCE, HAS_MERIT = (
    1 << 2,
    1 << 3,
    1 << 5,
    1 << 8,
    1 << 9,
)
FRAMES = ("enu", "xyz", "beam")  # by the code in the record
# codes of the orientation whose angles are those of z out of the transducers
Z_UP, Z_DOWN, AHRS = 4, 5, 7
SMALLEST_UNIT = -9  # exponent of ten of the velocities' unit in m/s
LOST_VELOCITY, LOST_MERIT = -32.0, 10.0  # m/s; DF21 marks what is not valid by -32.768 and 10
BEAMS = 4
DVL_VALUES = (
    # of each beam: velocity, distance, merit, three times; then of x, y, z1, z2: velocity, merit,
    # three times
    "<24f20f"
)


@dataclass(frozen=True, kw_only=True)
class BottomTrack:
    """One ping in SI units. NaN where it is lost or was not measured."""

    t_ns: int
    frame: str  # of the velocity, one of FRAMES
    # m/s, of the instrument over ground: (3,) in "xyz" and "enu"; one a beam in "beam", positive
    # where the beam closes in on the ground
    velocity: Array
    beams: tuple[int, ...]  # number of each, as the instrument numbers them
    distance_m: Array  # (4,) along z to where each beam meets the ground; empty in DF20
    sigma: float  # m/s
    angles_rad: Array  # (3,) heading, pitch, roll
    orientation: int  # code of the axis that the angles refer to (Z_UP, Z_DOWN, AHRS)


def parse(kind: int, data: bytes) -> BottomTrack:
    """Parse the data of a block of one of KINDS. Raises DamagedError for other or damaged data."""
    if kind not in KINDS:
        raise DamagedError(f"blocks of kind {kind:#04x} are not read as bottom tracks")
    version, start = fields("<BB", data)
    if version != VERSION:
        raise DamagedError(f"its version {version} is not known")
    return KINDS[kind].parse(data, start)


def _parse_df20(data: bytes, start: int) -> BottomTrack:
    """Parse a bottom track of data format 20.

    Bits of its configuration tell which values it has. A beam is lost where its distance or its
    figure of merit is not positive. Raises DamagedError where it has neither, as a lost velocity
    could then not be recognised.

    Parameters
    ----------
    data : what lies behind the block's header
    start : byte at which the values of the beams begin
    """
    (config,) = fields("<H", data, 2)
    heading, pitch, roll, layout = fields("<HhhH", data, 24)
    count, code = layout >> 12, layout >> 10 & 3
    (physical,) = fields("<H", data, 56)
    (exponent,) = fields("<b", data, 60)
    (status,) = fields("<I", data, 70)
    if start < DF20_HEADER or count not in (3, 4) or code >= len(FRAMES):
        raise DamagedError("its head contradicts itself")
    if not SMALLEST_UNIT <= exponent <= 0:
        raise DamagedError(f"its velocities are in units of 1e{exponent} m/s")
    if not config & HAS_VELOCITY or not config & (HAS_DISTANCE | HAS_MERIT):
        raise DamagedError(
            "it lacks velocities, or distances and figures of merit that tell the lost ones"
        )
    raw = np.array(fields(f"<{count}i", data, start), float)
    tracked, at = np.ones(count, bool), start + 4 * count
    if config & HAS_DISTANCE:
        tracked &= np.array(fields(f"<{count}i", data, at)) > 0  # a lost one is about -1 m
        at += 4 * count
    if config & HAS_MERIT:
        tracked &= np.array(fields(f"<{count}h", data, at)) > 0  # a lost one is -1, or about -1000
    velocity = raw * 10.0**exponent
    return BottomTrack(
        t_ns=_clock(fields("<6BH", data, 8)),
        frame=FRAMES[code],
        velocity=np.where(tracked, velocity, np.nan)
        if FRAMES[code] == "beam"
        else _vector(velocity, tracked),
        beams=tuple(physical >> 4 * row & 15 for row in range(count)),
        distance_m=np.zeros(0),
        sigma=float("nan"),
        angles_rad=np.radians(np.array([heading, pitch, roll]) / 100)
        if _has_angles(config)
        else LOST,
        orientation=status >> 25 & 7,
    )


def _parse_df21(data: bytes, start: int) -> BottomTrack:
    """Parse a bottom track of data format 21, in which status bits tell which values are valid.

    Values that are not valid are NaN. Of its two vertical velocities the mean is taken. Arguments
    as of `_parse_df20`. Raises DamagedError.
    """
    (count,) = fields("<H", data, 14)
    (status,) = fields("<I", data, 20)
    if start < DF21_HEADER or count != BEAMS:
        raise DamagedError("its head contradicts itself")
    try:
        values = np.array(struct.unpack_from(DVL_VALUES, data, start))
    except struct.error:
        raise DamagedError("it ends too early") from None
    valid = np.array(
        [bool(status >> bit & 1) for bit in range(20)]
    )  # velocity, distance, merit of beams; velocity, merit of xyz
    distance, velocity, merit = values[4:8], values[24:28], values[28:32]
    velocity = np.where(valid[12:16] & (velocity > LOST_VELOCITY), velocity, np.nan)
    merit = np.where(valid[16:20] & (merit > 0) & (merit < LOST_MERIT), merit, np.nan)
    return BottomTrack(
        t_ns=_clock(fields("<6BH", data, 6)),
        frame="xyz",
        velocity=np.array([*velocity[:2], _mean(velocity[2:])]),
        beams=tuple(range(1, BEAMS + 1)),
        distance_m=np.where(valid[4:8] & (distance > 0) & np.isfinite(distance), distance, np.nan),
        sigma=float(np.sqrt((merit[0] ** 2 + merit[1] ** 2 + _mean(merit[2:]) ** 2) / 3)),
        angles_rad=LOST,
        orientation=0,
    )


def _has_angles(config: int) -> bool:
    """Tell whether a configuration states heading, pitch and roll."""
    return bool(config & HAS_COMPASS and config & HAS_TILT)


def _vector(values: Array, tracked: Array) -> Array:
    """Make a velocity (3,) of x, y and one or two values of z, which are averaged.

    NaN where any beam is lost.
    """
    return np.array([*values[:2], values[2:].mean()]) if tracked.all() else LOST


def _mean(values: Array) -> float:
    """Average the values that are not lost. NaN where all are."""
    good = values[np.isfinite(values)]
    return float(good.mean()) if len(good) else float("nan")


def _clock(stamp: tuple[int, ...]) -> int:
    """Read the instrument's clock as UTC: years since 1900, months from 0, last units of 100 us."""
    year, month, *rest, ticks = stamp
    try:
        whole = datetime(1900 + year, 1 + month, *rest, tzinfo=UTC)  # type: ignore[arg-type,misc]
    except ValueError:
        raise DamagedError("its clock shows no time") from None
    if ticks >= 10_000:
        raise DamagedError("its clock shows no time")
    return int(whole.timestamp()) * 1_000_000_000 + ticks * 100_000


@dataclass(frozen=True)
class Kind:
    """A kind of record."""

    name: str
    parse: Callable[[bytes, int], BottomTrack]  # of its data and the byte where its values start


# of bottom tracks, by the blocks' kind
KINDS = {DF20: Kind("DF20", _parse_df20), DF21: Kind("DF21", _parse_df21)}
