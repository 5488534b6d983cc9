# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find and parse the ensembles of a Teledyne PD0 file.

Layout: Teledyne RD Instruments, WorkHorse Commands and Output Data Format [TeledynePD0]. The
Explorer DVL writes the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.readers.unpack import DamagedError, fields
from hullrecon.typing import Array

MAGIC = b"\x7f\x7f"
FIXED, VARIABLE, VELOCITY, BOTTOM = 0x0000, 0x0080, 0x0100, 0x0600
LOST = -32768
FRAMES = ("beam", "instrument", "ship", "earth")
BEAM_ANGLES = {0: 15.0, 1: 20.0, 2: 30.0}  # degrees, by the code in the system configuration
MIN_BEAM_ANGLE, MAX_BEAM_ANGLE = 5.0, 60.0
# bytes that are searched at a time, and that are read beyond so that the longest ensemble is whole
BLOCK, REACH = 1 << 20, 65535 + 2


@dataclass(frozen=True, kw_only=True)
class Ensemble:
    """One ping as the instrument wrote it, in SI units. NaN where lost or not measured."""

    number: int
    t_ns: int
    frame: str  # of every velocity, one of FRAMES
    tilts_applied: bool
    faces_up: bool
    beam_angle_rad: float
    alignment_rad: float
    heading_rad: float
    pitch_rad: float
    roll_rad: float
    depth_m: float
    range_m: Array  # (4,) to the bottom along the instrument's axis, not along the beam
    # (4,) m/s, of the bottom relative to the instrument: x, y, z and error velocity; in frame
    # "beam" of the four beams
    bottom: Array
    water: Array  # (cells, 4) m/s, likewise
    cell_m: Array  # (cells,) along the axis

    @property
    def has_attitude(self) -> bool:
        """Tell whether heading, pitch or roll is not zero: without sensors all three are."""
        return any((self.heading_rad, self.pitch_rad, self.roll_rad))


def is_pd0(start: bytes) -> bool:
    """Tell whether a file starts with an ensemble.

    The first data type lies directly behind the list of data types.
    """
    return (
        len(start) >= 8
        and start.startswith(MAGIC)
        and int.from_bytes(start[6:8], "little") == 6 + 2 * start[5] > 6
    )


def holds_ensemble(start: bytes) -> bool:
    """Tell whether a whole ensemble lies in the first bytes of a file, as behind a greeting."""
    return any(_ensemble_at(start, int(at))[0] is not None for at in _checked_starts(start))


def ensembles(stream: BinaryIO) -> Iterator[tuple[int, int, Ensemble | str]]:
    """Yield each ping (start, end, ensemble), and each stretch of other bytes (start, end, why).

    Pings whose checksum is wrong, or that cannot be parsed, count as other bytes. start, end: bytes
    of the file.
    """
    at = bad = 0  # where the search is, and where bytes of no ensemble begin
    why = ""
    while True:
        stream.seek(at)
        data = stream.read(BLOCK + REACH)
        if not data:
            break
        starts = _checked_starts(data)
        inside, limit = 0, min(BLOCK, len(data))
        while inside < limit:
            found, reason = _ensemble_at(data, inside)
            if found is None:
                why = why or reason
                # after damage, go on at the next head whose checksum holds
                row = int(np.searchsorted(starts, inside, side="right"))
                inside = min(int(starts[row]), limit) if row < len(starts) else limit
                continue
            start, end = at + inside, at + inside + _size(data, inside)
            if start > bad:
                yield bad, start, why
            yield start, end, found
            bad, why = end, ""
            inside = end - at
        at += inside
    if at > bad:
        yield bad, at, why


def _checked_starts(data: bytes) -> NDArray[np.intp]:
    """Find the bytes at which an ensemble with right magic, length and checksum starts.

    The sum over an ensemble is the difference of two values of one running sum, so that each byte
    is added once, however many heads claim it.
    """
    values = np.frombuffer(data, np.uint8).astype(np.uint32)
    running = np.concatenate([np.zeros(1, np.uint32), np.cumsum(values, dtype=np.uint32)])
    start = np.flatnonzero((values[:-3] == MAGIC[0]) & (values[1:-2] == MAGIC[1]))
    count = values[start + 2] + 256 * values[start + 3]
    fits = start + count + 2 <= len(values)
    start, count = start[fits], count[fits].astype(np.intp)
    end = start + count
    holds = (running[end] - running[start]) % 65536 == values[end] + 256 * values[end + 1]
    return np.asarray(start[holds], np.intp)


def _ensemble_at(data: bytes, at: int) -> tuple[Ensemble | None, str]:
    """Parse the ensemble at a byte, or explain why there is none."""
    try:
        return parse(data[at : _end_of(data, at)]), ""
    except DamagedError as error:
        return None, str(error)


def parse(data: bytes) -> Ensemble:
    """Parse one whole ensemble, given without its checksum.

    Velocities of bottom and water are NaN or empty where it has none. Raises DamagedError where its
    fixed or variable leader is missing, its beam angle is impossible, or its clock shows no time.
    """
    parts = _parts(data)
    if FIXED not in parts or VARIABLE not in parts:
        raise DamagedError("its leaders are missing")
    fixed, variable = parts[FIXED], parts[VARIABLE]
    (system,) = fields("<H", fixed, 4)
    beams, cells = fields("<BB", fixed, 8)
    transform, alignment = fields("<Bh", fixed, 25)
    heading, pitch, roll = fields("<Hhh", variable, 18)
    bottom = parts.get(BOTTOM)
    return Ensemble(
        number=fields("<H", variable, 2)[0] + (fields("<B", variable, 11)[0] << 16),
        t_ns=_clock(variable),
        frame=FRAMES[transform >> 3 & 3],
        tilts_applied=bool(transform & 4),
        faces_up=bool(system & 0x80),
        beam_angle_rad=float(np.radians(_beam_angle(system, fixed))),
        alignment_rad=float(np.radians(alignment / 100)),
        heading_rad=float(np.radians(heading / 100)),
        pitch_rad=float(np.radians(pitch / 100)),
        roll_rad=float(np.radians(roll / 100)),
        depth_m=fields("<H", variable, 16)[0] / 10,
        range_m=_ranges(bottom),
        bottom=np.full(4, np.nan) if bottom is None else _velocities(bottom, 24, 1)[0],
        water=_velocities(parts[VELOCITY], 2, cells)
        if VELOCITY in parts and beams == 4
        else np.zeros((0, 4)),
        cell_m=(fields("<H", fixed, 32)[0] + fields("<H", fixed, 12)[0] * np.arange(cells)) / 100,
    )


def _size(data: bytes, at: int) -> int:
    """Read how many bytes an ensemble has with its checksum."""
    return int(fields("<H", data, at + 2)[0]) + 2


def _end_of(data: bytes, at: int) -> int:
    """Find the byte behind the ensemble at `at`, whose checksum has to hold."""
    if data[at : at + 2] != MAGIC:
        raise DamagedError("no ensemble starts there")
    end = at + _size(data, at)
    if end > len(data):
        raise DamagedError("the last ensemble is cut off")
    if (
        int(np.frombuffer(data[at : end - 2], np.uint8).sum(dtype=np.int64)) % 65536
        != fields("<H", data, end - 2)[0]
    ):
        raise DamagedError("a checksum is wrong")
    return end


def _parts(data: bytes) -> dict[int, bytes]:
    """Split an ensemble into its data types, by number."""
    (count,) = fields("<B", data, 5)
    offsets = fields(f"<{count}H", data, 6)
    ends = sorted({*offsets, len(data)})
    out = {}
    for offset in offsets:
        end = next((e for e in ends if e > offset), len(data))
        out[fields("<H", data, offset)[0]] = data[offset:end]
    return out


def _clock(variable: bytes) -> int:
    """Read the instrument's clock as UTC.

    The clock with a century is preferred where there is one. Else years below 80 are of this
    century. Raises DamagedError where it shows no time.
    """
    year, *rest = fields("<7B", variable, 4)
    year += 2000 if year < 80 else 1900
    if len(variable) >= 65 and fields("<B", variable, 57)[0] in (19, 20):
        century, year, *rest = fields("<8B", variable, 57)
        year += 100 * century
    *calendar, hundredths = rest
    try:
        whole = datetime(year, *calendar, tzinfo=UTC)  # type: ignore[arg-type,misc]
    except ValueError:
        raise DamagedError("its clock shows no time") from None
    return int(whole.timestamp()) * 1_000_000_000 + hundredths * 10_000_000


def _beam_angle(system: int, fixed: bytes) -> float:
    """Read the angle of the beams off the axis, degrees. Raises DamagedError for odd ones."""
    code = system >> 8 & 3
    angle = BEAM_ANGLES[code] if code in BEAM_ANGLES else float(fields("<B", fixed, 58)[0])
    if not MIN_BEAM_ANGLE <= angle <= MAX_BEAM_ANGLE:
        raise DamagedError(f"its beams stand {angle:g} degrees off the axis")
    return angle


def _ranges(bottom: bytes | None) -> Array:
    """Read the distances (4,) along the axis, m, of a bottom track. NaN where lost, written as 0.

    Distances above 655.35 m have a third byte, at the end of long records.
    """
    if bottom is None:
        return np.full(4, np.nan)
    high = fields("<4B", bottom, 77) if len(bottom) >= 81 else (0, 0, 0, 0)
    centimetres = np.array(fields("<4H", bottom, 16), float) + 65536.0 * np.array(high)
    return np.where(centimetres > 0, centimetres / 100, np.nan)


def _velocities(data: bytes, offset: int, rows: int) -> Array:
    """Read velocities (rows, 4), m/s, NaN where lost."""
    millimetres = np.array(fields(f"<{4 * rows}h", data, offset), float).reshape(rows, 4)
    return np.where(millimetres == LOST, np.nan, millimetres / 1000)
