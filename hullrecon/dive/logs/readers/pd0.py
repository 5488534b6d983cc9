# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A Teledyne .pd0 file as a DVL: bottom tracks in the frame `dvl`, its attitude and depth.

`dvl` of a PD0 file: z out of the transducers, x towards beam 3, y towards beam 2. The instrument's
own axes are x towards beam 2, y towards beam 3, z into the housing (Teledyne RD Instruments,
Coordinate Transformation), whichever way it faces.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hullrecon.dive.logs.formats import pd0_ensemble
from hullrecon.dive.logs.formats.pd0_ensemble import Ensemble, ensembles
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.dive.logs.samples import LOST, DepthSample, DvlSample, ImuSample
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import NED_FROM_ENU
from hullrecon.typing import Array

CHANNEL, ATTITUDE, DEPTH = (
    Channel(sensor, "Teledyne PD0", "sample") for sensor in ("dvl", "imu", "pressure")
)
HEX_MAGIC = pd0_ensemble.MAGIC.hex().upper().encode()
DVL_FROM_INSTRUMENT = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
AZIMUTH_RAD = np.radians([-90.0, 90.0, 0.0, 180.0])  # of beams 1 to 4 about z of `dvl`


class Pd0Log(FileLog):
    """Reads ensembles whose checksum holds. What lies between them is listed as a loss."""

    kind = "Teledyne PD0"
    gives_samples = True

    def _read(self) -> Iterator[Message]:
        """Yield velocity, attitude and depth of each ensemble.

        Attitudes of exactly zero and depths of zero are left out: it has no such sensor then.
        Raises InputError for a file without any whole ensemble.
        """
        frames, has_bottom = set(), False
        with self.path.open("rb") as stream:
            for start, end, found in ensembles(stream):
                if isinstance(found, str):
                    self._tracker.open_gap(
                        f"{end - start} bytes from byte {start} on hold no whole ensemble: {found}"
                    )
                    continue
                frames.add(found.frame)
                has_bottom = has_bottom or bool(np.isfinite(found.range_m).any())
                yield self._tracker.record(Message(CHANNEL, found.t_ns, to_sample(found)))
                if found.has_attitude:
                    yield Message(ATTITUDE, found.t_ns, attitude(found))
                if found.depth_m > 0:
                    yield Message(
                        DEPTH,
                        found.t_ns,
                        DepthSample(found.t_ns, found.depth_m, is_up=False, of_dvl=True),
                    )
        self._tracker.finish()
        if not frames:
            raise self._without_ensembles()
        if not has_bottom:
            self.notes.append(Finding("pd0-no-bottom"))
        self.notes.append(Finding("pd0-read", {"frames": " and ".join(sorted(frames))}))

    def _without_ensembles(self) -> InputError:
        """Make the error for a file that holds no whole ensemble: it may be hexadecimal text."""
        with self.path.open("rb") as stream:
            is_text = stream.read(len(HEX_MAGIC)).upper() == HEX_MAGIC
        return InputError(
            f"{printable(self.path.name)} holds no whole ensemble"
            + (": it is the hexadecimal text of PD0" if is_text else ""),
            where=printable(str(self.path.parent)),
            remedy="write it in binary, by `xxd -r -p`"
            if is_text
            else "give it as the DVL's software recorded it, or leave it out of logs.files",
        )


def to_sample(ping: Ensemble) -> DvlSample:
    """Convert a bottom track to the frame `dvl`, with ranges along the beams.

    The ensemble holds the bottom's velocity relative to the instrument, hence the minus, and
    distances along the axis.
    """
    velocity = -DVL_FROM_INSTRUMENT @ instrument_velocity(ping)
    tilt = ping.beam_angle_rad
    beams = np.stack(
        [
            np.sin(tilt) * np.cos(AZIMUTH_RAD),
            np.sin(tilt) * np.sin(AZIMUTH_RAD),
            np.full(4, np.cos(tilt)),
        ],
        axis=1,
    )
    return DvlSample(ping.t_ns, velocity, float("nan"), ping.range_m / np.cos(tilt), beams)


def attitude(ping: Ensemble) -> ImuSample:
    """Compute the attitude of `dvl` in north-east-down, by the instrument's compass and tilts."""
    from scipy.spatial.transform import Rotation  # slow to import, and few logs need it

    enu_from_instrument = earth_from_instrument(ping.heading_rad, *_tilts(ping))
    ned_from_dvl = NED_FROM_ENU @ enu_from_instrument @ DVL_FROM_INSTRUMENT.T
    return ImuSample(
        ping.t_ns, Rotation.from_matrix(ned_from_dvl).as_quat(), LOST, LOST, of_dvl=True
    )


def instrument_velocity(ping: Ensemble) -> Array:
    """Turn the bottom's velocity (3,) m/s into the instrument's axes. NaN when lost."""
    if ping.frame == "beam":
        return from_beams(ping.bottom, ping.beam_angle_rad)
    vector = ping.bottom[:3]
    if ping.frame == "instrument":
        return vector
    # the ship's axes are the instrument's turned by its alignment, about the axis of a heading
    heading = ping.heading_rad if ping.frame == "earth" else -ping.alignment_rad
    return (
        earth_from_instrument(heading, *(_tilts(ping) if ping.tilts_applied else (0.0, 0.0))).T
        @ vector
    )


def from_beams(beams: Array, angle_rad: float) -> Array:
    """Compute a velocity (3,) in the instrument's axes from those along four beams, m/s.

    beams: (4,) positive towards the transducer, NaN where lost. One lost beam is replaced as if the
    error velocity were zero. NaN where more are lost.
    """
    b = beams.copy()
    lost = np.flatnonzero(np.isnan(b))
    if len(lost) == 1:
        # either pair of opposite beams, 1 and 2 or 3 and 4, sums to the velocity along the axis
        opposite = {0: (1, 2, 3), 1: (0, 2, 3), 2: (3, 0, 1), 3: (2, 0, 1)}
        partner, one, other = opposite[int(lost[0])]
        b[lost[0]] = b[one] + b[other] - b[partner]
    across, along = 1 / (2 * np.sin(angle_rad)), 1 / (4 * np.cos(angle_rad))
    return np.array([across * (b[0] - b[1]), across * (b[3] - b[2]), along * b.sum()])


def earth_from_instrument(heading: float, pitch: float, roll: float) -> Array:
    """Build the rotation enu_from_instrument (3, 3), to east, north, up.

    The angles are in rad, as the instrument defines them (Teledyne RD Instruments, Coordinate
    Transformation, equation 18).
    """
    ch, sh, cp, sp, cr, sr = (
        np.cos(heading),
        np.sin(heading),
        np.cos(pitch),
        np.sin(pitch),
        np.cos(roll),
        np.sin(roll),
    )
    return np.array(
        [
            [ch * cr + sh * sp * sr, sh * cp, ch * sr - sh * sp * cr],
            [-sh * cr + ch * sp * sr, ch * cp, -sh * sr - ch * sp * cr],
            [-cp * sr, sp, cp * cr],
        ]
    )


def _tilts(ping: Ensemble) -> tuple[float, float]:
    """Convert the logged tilts to pitch and roll, rad, of `earth_from_instrument`.

    The sensor of pitch measures the tilt of an axis against the horizon, which differs from the
    angle of pitch where the instrument rolls. Half a turn is added to roll where it faces up.
    """
    pitch = float(np.arctan(np.tan(ping.pitch_rad) * np.cos(ping.roll_rad)))
    return pitch, ping.roll_rad + (np.pi if ping.faces_up else 0.0)
