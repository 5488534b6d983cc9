# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the beams of a Nortek instrument point: the lines BEAMCFGLIST of the configuration that it
writes into its files.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from hullrecon.dive.logs.dvl_beams import tilted_beams
from hullrecon.typing import Array

# THETA: degrees off z; PHI: degrees about z from x towards y.
BEAM = re.compile(
    rb"^BEAMCFGLIST,BEAM=([1-9]),THETA=(\d{1,3}\.?\d{0,6}),PHI=(-?\d{1,3}\.?\d{0,6}),", re.MULTILINE
)
FARTHEST_DEG = 60.0  # a beam that leaves the axis by more is a damaged number
# smallest singular value of directions that still make a velocity of three components
FLATTEST = 0.05


def read_beams(text: bytes) -> dict[int, Array]:
    """Return unit vectors (3,) by the beams' numbers; {} for a text without them."""
    found = ((int(number), float(theta), float(phi)) for number, theta, phi in BEAM.findall(text))
    return {
        number: tilted_beams(theta, [phi])[0]
        for number, theta, phi in found
        if theta <= FARTHEST_DEG and abs(phi) <= 360
    }


def directions(beams: Mapping[int, Array], numbers: Sequence[int]) -> Array | None:
    """Return (n, 3) unit vectors of the beams of these numbers; None where one of them is not
    described.
    """
    return np.array([beams[n] for n in numbers]) if all(n in beams for n in numbers) else None


def velocity_from_beams(closing: Array, units: Array) -> Array:
    """Return the velocity (3,) m/s whose parts along units (n, 3) are `closing` (n,) with the
    smallest squares; NaN with less than three beams left, or with beams that leave a direction
    open.
    """
    good = np.isfinite(closing)
    if np.count_nonzero(good) < 3 or np.linalg.svd(units[good], compute_uv=False)[-1] < FLATTEST:
        return np.full(3, np.nan)
    return np.asarray(np.linalg.lstsq(units[good], closing[good], rcond=None)[0])
