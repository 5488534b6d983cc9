# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether one image of the upper camera goes on where another ends: how far images carry a path on where the DVL is silent."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from hullrecon.rig import SensorRig
from hullrecon.typing import Pixels
from hullrecon.vision.features.extraction import FeatureOptions, extract, no_features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pair_match import Reason
from hullrecon.vision.pairs.matching import PairMatcher
from hullrecon.vision.stereo.camera_rig import CameraRig
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import NodeView, view_of_node


def continuity(
    rig: SensorRig, read: Callable[[int], Pixels | None], max_features: int, min_inliers: int
) -> Callable[[int, int], bool]:
    """Return what tells of two images, by their rows, whether at least min_inliers features move as those of one rigid scene.

    read: an image (h, w, 3) RGB by its row, None where there is none. The two asked last are kept.
    """
    cameras, options = CameraRig(rig), MatchOptions(min_inliers=min_inliers)
    matcher, feature_options = PairMatcher(cameras, options), FeatureOptions(max_features=max_features)

    @lru_cache(maxsize=2)
    def view(row: int) -> NodeView:
        image = read(row)
        found = no_features() if image is None else extract(image, feature_options)
        return view_of_node(cameras, found, no_features(), no_matches(), None, options.sigma_px)

    def goes_on(first: int, second: int) -> bool:
        found = matcher.match(view(first), view(second), None, (options.seed, first, second), True)
        return found.reason in (Reason.MATCHED, Reason.NO_MOTION)

    return goes_on
