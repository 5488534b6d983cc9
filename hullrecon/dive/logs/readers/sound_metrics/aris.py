# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""An .aris file as an imaging sonar: every frame is a ping in the frame `sonar` of a sonar that
stands upright.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hullrecon.dive.logs.messages.sonar import in_fan
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.sound_metrics.aris_frames import ArisFrame, FrameHeader, frames
from hullrecon.dive.logs.readers.sound_metrics.beam_angles import NAMES, beam_azimuths
from hullrecon.dive.logs.samples import SonarSample
from hullrecon.typing import Array

CHANNEL = Channel("sonar", "Sound Metrics ARIS", "sample")
TURNED_DEG = 0.5  # a rotator that moves by less has not turned
ALWAYS = (
    "a file of an ARIS has no checksums; stamps are those of the computer that recorded it, taken as UTC (sonar.time_offset "
    "corrects its clock); beams are those of a sonar that stands upright (one upside down has roll 180 in sonar.mount); "
    "heading, tilts, depth and position in its frames were left aside"
)


class ArisLog(FileLog):
    """Frames whose header holds what an ARIS writes; what lies between them is named."""

    kind = "Sound Metrics ARIS"
    gives_samples = True

    def _read(self) -> Iterator[Message]:
        seen = _Seen()
        with self.path.open("rb") as stream:
            for start, end, found in frames(stream):
                if isinstance(found, str):
                    self._tracker.open_gap(
                        f"{end - start} bytes from byte {start} on hold no whole frame: {found}"
                    )
                    continue
                seen.add(found.header)
                if found.header.is_sounding:
                    yield self._tracker.record(
                        Message(CHANNEL, found.header.t_ns, to_sample(found))
                    )
        self._tracker.finish()
        self.remarks += seen.remarks()


def to_sample(frame: ArisFrame) -> SonarSample:
    """Return the ping; its directions are None where nothing is published for that model, lens and
    number of beams.
    """
    header = frame.header
    azimuth = beam_azimuths(header.model, header.beams, is_telephoto=header.is_telephoto)
    return SonarSample(
        header.t_ns, frame.image, None if azimuth is None else in_fan(azimuth), header.range_m
    )


class _Seen:
    """What was met in a file that a reader of its pings should know."""

    def __init__(self) -> None:
        self._frames = self._silent = 0
        self._kinds: set[tuple[int, int, bool]] = set()
        self._rotator: list[Array] = []  # lowest and highest angles

    def add(self, header: FrameHeader) -> None:
        self._frames += 1
        self._silent += not header.is_sounding
        self._kinds.add((header.model, header.beams, header.is_telephoto))
        angles = np.where(np.isfinite(header.rotator_deg), header.rotator_deg, 0.0)
        low, high = self._rotator or (angles, angles)
        self._rotator = [np.minimum(low, angles), np.maximum(high, angles)]

    def remarks(self) -> list[str]:
        if not self._frames:
            return ["no frame of it could be read"]
        kinds = [
            f"{NAMES.get(model, f'an ARIS of unknown model {model}')}, {beams} beams{', telephoto lens' * is_telephoto}"
            for model, beams, is_telephoto in sorted(self._kinds)
        ]
        out = ["; ".join(kinds[:4])]
        if any(is_telephoto for *_, is_telephoto in self._kinds):
            out.append(
                "a telephoto lens narrows the aperture out of the fan: sonar.elevation_deg has to be that lens's"
            )
        if self._silent:
            out.append(f"{self._silent} frames were left out: the transmitter was off")
        turned = dict(
            zip(("pan", "tilt", "roll"), self._rotator[1] - self._rotator[0], strict=True)
        )
        moved = [
            f"{name} by {degrees:.0f} degrees"
            for name, degrees in turned.items()
            if degrees > TURNED_DEG
        ]
        if moved:
            out.append(
                f"its rotator turned ({', '.join(moved)}), which is not read: log it as the joint that sonar.joint names"
            )
        return [*out, ALWAYS]
