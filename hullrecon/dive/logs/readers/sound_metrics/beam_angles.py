# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the beams of an ARIS point, by its model, its lens and the number of beams.

The lens spaces beams unevenly. Sound Metrics publishes the middle of each beam, the mean of several
lenses a type [ArisFileSDK]; here each table is an odd polynomial of fifth order that was fitted to
it.
"""

from __future__ import annotations

import numpy as np

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


def beam_azimuths(model: int, beams: int, *, is_telephoto: bool) -> Array | None:
    """Return azimuths (beams,) rad from the middle of the fan, growing from port to starboard; None
    where nothing is published for that model, lens and number of beams.
    """
    factors = ANGLES.get((model, beams, is_telephoto))
    if factors is None:
        return None
    u = np.linspace(-1, 1, beams)
    return np.asarray(
        np.radians(sum(factor * u**power for factor, power in zip(factors, (1, 3, 5), strict=True)))
    )
