# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A Nortek .ad2cp file as a DVL: bottom tracks in the frame `dvl`, attitude by its own sensors.

`dvl` of an AD2CP file are Nortek's axes: z out of the transducers, x and y as marked on the
housing.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from hullrecon.dive.logs.dvl_beams import tilted_beams
from hullrecon.dive.logs.readers.ad2cp import bottom_track as tracks
from hullrecon.dive.logs.readers.ad2cp.blocks import Block, blocks
from hullrecon.dive.logs.readers.ad2cp.bottom_track import BottomTrack
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.logs.samples import LOST, DvlSample, ImuSample
from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import NED_FROM_ENU
from hullrecon.typing import Array

# THETA: degrees off z; PHI: degrees about z from x towards y.
BEAM = re.compile(
    rb"^BEAMCFGLIST,BEAM=([1-9]),THETA=(\d{1,3}\.?\d{0,6}),PHI=(-?\d{1,3}\.?\d{0,6}),", re.MULTILINE
)
FARTHEST_DEG = 60.0  # a beam that leaves the axis by more is a damaged number
# smallest singular value of the beams' unit vectors from which a velocity (3,) can be solved
FLATTEST = 0.05
CHANNEL, ATTITUDE = (Channel(sensor, "Nortek AD2CP", "sample") for sensor in ("dvl", "imu"))
TURNED_OVER = np.diag([1.0, -1.0, -1.0])


def read_beams(text: bytes) -> dict[int, Array]:
    """Read unit vectors (3,) of the beams, by number, from a configuration. Empty without any.

    Damaged angles are left out.
    """
    found = ((int(number), float(theta), float(phi)) for number, theta, phi in BEAM.findall(text))
    return {
        number: tilted_beams(theta, [phi])[0]
        for number, theta, phi in found
        if theta <= FARTHEST_DEG and abs(phi) <= 360
    }


def directions(beams: Mapping[int, Array], numbers: Sequence[int]) -> Array | None:
    """Stack the beams (n, 3) of these numbers. None where one is not described."""
    return np.array([beams[n] for n in numbers]) if all(n in beams for n in numbers) else None


def velocity_from_beams(closing: Array, units: Array) -> Array:
    """Solve for the velocity (3,) m/s from the velocities along the beams, by least squares.

    Files that hold velocities along the beams alone need it. NaN where fewer than three beams are
    known, or where they leave a direction unobserved.

    Parameters
    ----------
    closing : (n,) along each beam, positive where it closes in on the ground, NaN where lost
    units : (n, 3) unit vectors along the beams
    """
    good = np.isfinite(closing)
    if np.count_nonzero(good) < 3 or np.linalg.svd(units[good], compute_uv=False)[-1] < FLATTEST:
        return np.full(3, np.nan)
    return np.asarray(np.linalg.lstsq(units[good], closing[good], rcond=None)[0])


class Ad2cpLog(FileLog):
    """Reads blocks whose checksums hold. What lies between them is listed as a loss."""

    kind = "Nortek AD2CP"
    gives_samples = True

    def _read(self) -> Iterator[Message]:
        """Yield velocities and attitudes of the bottom tracks, and note what else was met.

        The beams' directions are those of the configuration that stands before a ping.
        """
        seen: Counter[str] = Counter()
        beams: dict[int, Array] = {}
        with self.path.open("rb") as stream:
            for start, end, found in blocks(stream):
                if isinstance(found, str):
                    self._tracker.open_gap(
                        f"{end - start} bytes from byte {start} on hold no whole block: {found}"
                    )
                elif found.kind == tracks.TEXT:
                    beams |= read_beams(found.data)
                elif found.kind in tracks.KINDS:
                    yield from self._pings(found, start, beams, seen)
                else:
                    seen["water track" if found.kind == tracks.WATER_TRACK else "other"] += 1
        self._tracker.finish()
        self.notes += describe(seen)

    def _pings(
        self, block: Block, start: int, beams: dict[int, Array], seen: Counter[str]
    ) -> Iterator[Message]:
        """Yield the readings of one bottom track, or note its loss.

        Parameters
        ----------
        block, start : the record, and the byte at which it begins
        beams : unit vectors by the beams' numbers
        seen : counts what was met, by the words that `describe` reads
        """
        try:
            ping = tracks.parse(block.kind, block.data)
        except DamagedError as error:
            self._tracker.open_gap(f"the bottom track at byte {start} cannot be read: {error}")
            return
        units = directions(beams, ping.beams)
        turn = enu_from_dvl(ping)
        sample = to_sample(ping, units, turn)
        lost = not np.isfinite(sample.velocity).all()
        seen["bottom track"] += 1
        seen[tracks.KINDS[block.kind].name] += 1
        seen["tracked"] += not lost
        seen["without beams"] += lost and ping.frame == "beam" and units is None
        seen["without attitude"] += lost and ping.frame == "enu" and turn is None
        yield self._tracker.record(Message(CHANNEL, ping.t_ns, sample))
        if turn is not None:
            yield Message(ATTITUDE, ping.t_ns, attitude(ping.t_ns, turn))


def to_sample(ping: BottomTrack, units: Array | None, enu_from_dvl: Array | None) -> DvlSample:
    """Convert a bottom track to velocity in `dvl` and distances along its z.

    The velocity is NaN where the file lacks what is needed to turn it into `dvl`: the beams'
    directions for velocities along beams, the attitude for velocities in east, north, up.

    Parameters
    ----------
    ping : bottom track
    units : (n, 3) unit vectors along the beams, None where the file does not describe them
    enu_from_dvl : (3, 3), None where the attitude is not known
    """
    velocity = ping.velocity
    if ping.frame == "beam":
        velocity = LOST if units is None else velocity_from_beams(velocity, units)
    elif ping.frame == "enu":
        velocity = LOST if enu_from_dvl is None else enu_from_dvl.T @ velocity
    return DvlSample(ping.t_ns, velocity, ping.sigma, ping.distance_m, units, along_axis=True)


def enu_from_dvl(ping: BottomTrack) -> Array | None:
    """Build the rotation (3, 3) from `dvl` to east, north, up, of the instrument's own attitude.

    None where an angle is missing, or where the instrument took another axis than z as vertical.
    """
    from scipy.spatial.transform import Rotation  # slow to import, and few logs need it

    if not np.isfinite(ping.angles_rad).all() or ping.orientation not in (
        tracks.Z_UP,
        tracks.Z_DOWN,
        tracks.AHRS,
    ):
        return None
    heading, pitch, roll = ping.angles_rad
    # heading is clockwise from north, a rotation about z (up) anticlockwise from east. Nortek's
    # pitch is opposite in sense to a rotation about y
    turn = Rotation.from_euler("ZYX", [np.pi / 2 - heading, -pitch, roll]).as_matrix()
    return np.asarray(turn @ TURNED_OVER if ping.orientation == tracks.Z_DOWN else turn)


def attitude(t_ns: int, turn: Array) -> ImuSample:
    """Convert enu_from_dvl, `turn` (3, 3), to an attitude of `dvl` in north-east-down."""
    from scipy.spatial.transform import Rotation

    return ImuSample(
        t_ns,
        Rotation.from_matrix(NED_FROM_ENU @ turn).as_quat(),
        LOST,
        LOST,
        of_dvl=True,
    )


def describe(seen: Counter[str]) -> list[Finding]:
    """List as findings what a file lacks, what was ignored and what was assumed.

    seen: counts of blocks and pings, by the words that `Ad2cpLog` counts under.
    """
    others = seen["water track"] + seen["other"]
    found: list[tuple[object, str, dict[str, object]]] = [
        (seen["bottom track"] and not seen["tracked"], "ad2cp-not-tracked", {}),
        (not seen["bottom track"], "ad2cp-no-bottom", {}),
        (seen["without beams"], "ad2cp-no-beams", {"count": seen["without beams"]}),
        (seen["without attitude"], "ad2cp-no-attitude", {"count": seen["without attitude"]}),
        (seen["DF20"], "ad2cp-df20", {}),
        (others, "ad2cp-others", {"count": others, "water_tracks": seen["water track"]}),
        (True, "ad2cp-read", {}),
    ]
    return [Finding(code, values) for holds, code, values in found if holds]
