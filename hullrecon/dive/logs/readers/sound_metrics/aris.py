# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""An .aris file as an imaging sonar: frames are pings in the frame `sonar` of an upright sonar.

The lens spaces beams unevenly. Sound Metrics publishes tables of the middle of each beam, for each
type of lens the mean of several [ArisFileSDK]. Here an odd polynomial of fifth order that was
fitted to the table stands for it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hullrecon.dive.logs.messages.sonar import in_fan
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.sound_metrics.aris_frames import ArisFrame, FrameHeader, frames
from hullrecon.dive.logs.samples import SonarSample
from hullrecon.findings.finding import Finding
from hullrecon.typing import Array

ARIS_1800, ARIS_3000, ARIS_1200 = 0, 1, 2  # the header's numbers
NAMES = {ARIS_1800: "ARIS 1800", ARIS_3000: "ARIS 3000", ARIS_1200: "ARIS 1200"}
WIDE_48, TELEPHOTO_48 = (16.0901, -3.3308, 0.8195), (7.5101, -0.1277, -0.0445)
# deg, of u, u^3 and u^5, where u runs from -1 at the first to 1 at the last beam, by model, beams
# and whether a telephoto lens is on. The fits are off the tables by 0.01 degrees at most; that of
# 96 beams without telephoto lens by 0.07 at the edge, where the table itself is not the same on
# both sides.
ANGLES: dict[tuple[int, int, bool], tuple[float, float, float]] = {
    (ARIS_1200, 48, False): WIDE_48,
    (ARIS_1800, 48, False): WIDE_48,
    (ARIS_1800, 96, False): (16.3222, -3.2622, 0.7569),
    (ARIS_3000, 64, False): (15.0083, -0.0585, -0.0609),
    (ARIS_3000, 128, False): (15.1319, -0.0648, -0.0537),
    (ARIS_1200, 48, True): TELEPHOTO_48,
    (ARIS_1800, 48, True): TELEPHOTO_48,
    (ARIS_1800, 96, True): (7.5912, -0.1249, -0.0488),
}
CHANNEL = Channel("sonar", "Sound Metrics ARIS", "sample")
TURNED_DEG = 0.5  # a rotator that moves by less has not turned
MOST_KINDS = 4  # combinations of model, beams and lens that are listed


def beam_azimuths(model: int, beams: int, *, is_telephoto: bool) -> Array | None:
    """Compute azimuths (beams,) rad from the middle of the fan, growing from port to starboard.

    None where Sound Metrics publishes none for this model, lens and number of beams.
    """
    factors = ANGLES.get((model, beams, is_telephoto))
    if factors is None:
        return None
    u = np.linspace(-1, 1, beams)
    return np.asarray(
        np.radians(sum(factor * u**power for factor, power in zip(factors, (1, 3, 5), strict=True)))
    )


class ArisLog(FileLog):
    """Reads frames whose header an ARIS may have written. Other bytes are losses."""

    kind = "Sound Metrics ARIS"
    gives_samples = True

    def _read(self) -> Iterator[Message]:
        """Yield the frames that were taken with the transmitter on. Others are only counted."""
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
        self.notes += seen.notes()


def to_sample(frame: ArisFrame) -> SonarSample:
    """Convert a frame. Directions are None where Sound Metrics publishes none for its fan."""
    header = frame.header
    azimuth = beam_azimuths(header.model, header.beams, is_telephoto=header.is_telephoto)
    return SonarSample(
        header.t_ns, frame.image, None if azimuth is None else in_fan(azimuth), header.range_m
    )


class _Seen:
    """Collect what a file holds: models, lenses, silent frames, a rotator that turned."""

    def __init__(self) -> None:
        self._frames = self._silent = 0
        self._kinds: set[tuple[int, int, bool]] = set()
        self._rotator: list[Array] = []  # lowest and highest angles

    def add(self, header: FrameHeader) -> None:
        """Count a frame."""
        self._frames += 1
        self._silent += not header.is_sounding
        self._kinds.add((header.model, header.beams, header.is_telephoto))
        angles = np.where(np.isfinite(header.rotator_deg), header.rotator_deg, 0.0)
        low, high = self._rotator or (angles, angles)
        self._rotator = [np.minimum(low, angles), np.maximum(high, angles)]

    def notes(self) -> list[Finding]:
        """Report what the frames are of, and what was assumed about them."""
        if not self._frames:
            return [Finding("aris-empty")]
        kinds = [
            f"{NAMES.get(model, f'an ARIS of unknown model {model}')}, {beams} "
            f"beams{', telephoto lens' * is_telephoto}"
            for model, beams, is_telephoto in sorted(self._kinds)
        ]
        out = [Finding("aris-kinds", {"kinds": "; ".join(kinds[:MOST_KINDS])})]
        if any(is_telephoto for *_, is_telephoto in self._kinds):
            out.append(Finding("aris-telephoto"))
        if self._silent:
            out.append(Finding("aris-silent", {"count": self._silent}))
        turned = dict(
            zip(("pan", "tilt", "roll"), self._rotator[1] - self._rotator[0], strict=True)
        )
        moved = {axis: float(deg) for axis, deg in turned.items() if deg > TURNED_DEG}
        if moved:
            out.append(Finding("aris-rotator", {"turned_deg": moved}))
        return [*out, Finding("aris-read")]
