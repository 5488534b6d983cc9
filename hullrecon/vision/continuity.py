# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether one image of the upper camera goes on where another ends: how far images carry a path on where the DVL is silent."""

from __future__ import annotations

from collections.abc import Callable

from hullrecon.rig import SensorRig
from hullrecon.typing import Pixels
from hullrecon.vision.image_motion import single_camera_views
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pair_match import Reason


def continuity(
    rig: SensorRig, read: Callable[[int], Pixels | None], max_features: int, min_inliers: int
) -> Callable[[int, int], bool]:
    """Return what tells of two images, by their rows, whether at least min_inliers features move as those of one rigid scene.

    read: an image (h, w, 3) RGB by its row, None where there is none. The two asked last are kept.
    """
    options = MatchOptions(min_inliers=min_inliers)
    matcher, view = single_camera_views(rig, read, max_features, options)

    def goes_on(first: int, second: int) -> bool:
        found = matcher.match(view(first), view(second), None, (options.seed, first, second), True)
        return found.reason in (Reason.MATCHED, Reason.NO_MOTION)

    return goes_on
