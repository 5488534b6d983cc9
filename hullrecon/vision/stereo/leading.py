# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which of a node's two cameras leads, and whether what they have in common is more than chance.

A camera whose light is out, or that is covered, still sends noise, in which SIFT finds 120 to 1600
features.
"""

from __future__ import annotations

import math

from hullrecon.vision.features.extraction import Features
from hullrecon.vision.stereo.matching import StereoMatches

# Stereo matches over the geometric mean of the two cameras' features: noise and an image of a hull
# have at most 0.042, two cameras that see at least 0.147, where one of them looks past the hull
# (10,702 nodes of 53 runs; 0.163 on a real seabed).
FAIR_SHARE = 0.06
CLEARLY_MORE = 2.0


def is_fair_share(matches: int, top: Features, bottom: Features) -> bool:
    """Return whether two images have more in common than one of noise has with any."""
    return matches >= FAIR_SHARE * math.sqrt(
        (len(top) - top.corners) * (len(bottom) - bottom.corners)
    )


def bottom_leads(top: Features, bottom: Features, stereo: StereoMatches) -> bool:
    """Return whether the bottom camera leads: the two have nothing in common, and it sees clearly
    more.

    Features are weighted by how light they are: what is found in the dark is noise.
    """
    return not len(stereo) and len(bottom) > 0 and _light(bottom) > CLEARLY_MORE * _light(top)


def _light(features: Features) -> float:
    return len(features) + float(features.color.sum(dtype=float)) / 3
