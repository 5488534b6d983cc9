# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A Nortek .ad2cp file as a DVL: every bottom track in the frame `dvl`, and the attitude by the
instrument's own sensors.

`dvl` of an AD2CP file are Nortek's axes: z out of the transducers, x and y as marked on the
housing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.readers.ad2cp import bottom_track as tracks
from hullrecon.dive.logs.readers.ad2cp.beam_list import directions, read_beams, velocity_from_beams
from hullrecon.dive.logs.readers.ad2cp.blocks import Block, blocks
from hullrecon.dive.logs.readers.ad2cp.bottom_track import BottomTrack
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.logs.samples import DvlSample, ImuSample
from hullrecon.typing import Array

CHANNEL, ATTITUDE = (Channel(sensor, "Nortek AD2CP", "sample") for sensor in ("dvl", "imu"))
NED_FROM_ENU = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
TURNED_OVER = np.diag([1.0, -1.0, -1.0])


class Ad2cpLog(FileLog):
    """Blocks whose checksums hold; what lies between them is named."""

    kind = "Nortek AD2CP"
    gives_samples = True

    def _read(self) -> Iterator[Message]:
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
        self.remarks += describe(seen)

    def _pings(
        self, block: Block, start: int, beams: dict[int, Array], seen: Counter[str]
    ) -> Iterator[Message]:
        """Yield the readings of one record, or the loss of it; what was met is counted in `seen`."""
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
    """Return velocity and distances along z. units (n, 3): of the beams, None where the file does
    not describe them.
    """
    velocity = ping.velocity
    if ping.frame == "beam":
        velocity = tracks.LOST if units is None else velocity_from_beams(velocity, units)
    elif ping.frame == "enu":
        velocity = tracks.LOST if enu_from_dvl is None else enu_from_dvl.T @ velocity
    return DvlSample(ping.t_ns, velocity, ping.sigma, ping.distance_m, units, along_axis=True)


def enu_from_dvl(ping: BottomTrack) -> Array | None:
    """Return east, north, up of the axes of `dvl` (3, 3), by the angles of the record; None where
    it has none of z.
    """
    if not np.isfinite(ping.angles_rad).all() or ping.orientation not in (
        tracks.Z_UP,
        tracks.Z_DOWN,
        tracks.AHRS,
    ):
        return None
    heading, pitch, roll = ping.angles_rad
    turn = Rotation.from_euler("ZYX", [np.pi / 2 - heading, -pitch, roll]).as_matrix()
    return np.asarray(turn @ TURNED_OVER if ping.orientation == tracks.Z_DOWN else turn)


def attitude(t_ns: int, turn: Array) -> ImuSample:
    """Return the attitude of the frame `dvl` in north-east-down. turn: that of enu_from_dvl."""
    return ImuSample(
        t_ns,
        Rotation.from_matrix(NED_FROM_ENU @ turn).as_quat(),
        tracks.LOST,
        tracks.LOST,
        of_dvl=True,
    )


def describe(seen: Counter[str]) -> list[str]:
    """Return sentences: what a file lacks, what was left aside, what was assumed."""
    out = []
    if seen["bottom track"] and not seen["tracked"]:
        out.append("no bottom track of it is valid: it gives no velocity over ground")
    if not seen["bottom track"]:
        out.append(
            "no bottom-track record was read from it (a current profiler's file?): it gives no velocity over ground"
        )
    if seen["without beams"]:
        out.append(
            f"{seen['without beams']} velocities along the beams were lost: the file does not say where its beams point "
            "(the configuration at its start is missing); have the instrument write XYZ"
        )
    if seen["without attitude"]:
        out.append(
            f"{seen['without attitude']} velocities east, north, up were lost: their records have no attitude of the z axis"
        )
    if seen["DF20"]:
        out.append(
            "distances and figures of merit of its bottom tracks (DF20) were left aside, as no public document says whether "
            "those are along the beams or along z, and in which unit these are"
        )
    if seen["water track"] + seen["other"]:
        out.append(
            f"{seen['water track'] + seen['other']} blocks of other kinds were passed over ({seen['water track']} water tracks)"
        )
    out.append(
        "its frame dvl has Nortek's axes (z out of the transducers); its pressure was left aside; the instrument's clock was "
        "taken as UTC"
    )
    return out
