# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of a DIDSON's .ddf file, versions 3 and 4: the images alone.

The layout's sizes are those of Sound Metrics' ARIS File SDK [ArisFileSDK]. A frame states its
window by codes, whose meaning in metres changed with the instrument, and its time by a clock
without a zone. It does not state where its beams point. The table that names the file gives all
three. There are no checksums.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.readers.unpack import DamagedError, fields

MAGIC = b"DDF"
# bytes of the file's header and of each frame's, by version
HEADERS = {3: (512, 256), 4: (1024, 1024)}
ARIS = 5
MAGIC_AT = 12  # in a frame's header
SAMPLES = 512  # of each beam
BEAMS = (48, 96)


def read_frame(path: Path, number: int) -> NDArray[np.uint8]:
    """Read the image (beams, samples) of a frame by its number from 0.

    Beams run from port to starboard of an upright sonar. Raises DamagedError for a file of another
    version, a frame that is not there, and one that is damaged.
    """
    with path.open("rb") as stream:
        head = stream.read(20)
        version, beams = fields("<3xB12xI", head)
        if version == ARIS:
            raise DamagedError(
                "it is a file of an ARIS, which has stamps of its own: name it in logs.files"
            )
        if version not in HEADERS or beams not in BEAMS:
            raise DamagedError(
                f"a file of a DIDSON of version {version} with {beams} beams is not read"
            )
        before, header = HEADERS[version]
        stream.seek(before + number * (header + SAMPLES * beams))
        start = stream.read(header)
        data = stream.read(SAMPLES * beams)
    if len(data) < SAMPLES * beams:
        raise DamagedError("it holds no whole frame of that number")
    if start[MAGIC_AT : MAGIC_AT + 4] != head[:4]:
        raise DamagedError("no frame begins where that of that number should")
    image = np.frombuffer(data, np.uint8).reshape(SAMPLES, beams)
    return np.ascontiguousarray(image[:, ::-1].T)
