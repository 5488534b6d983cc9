# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How the upper camera moved from one of its images to another, by the two images alone."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from hullrecon.rig import Rig
from hullrecon.typing import Array, Pixels
from hullrecon.vision.features.extraction import FeatureOptions, extract, no_features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.matching import PairMatcher
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import NodeView, view_of_node


def single_camera_views(
    rig: Rig, read: Callable[[int], Pixels | None], max_features: int, options: MatchOptions
) -> tuple[PairMatcher, Callable[[int], NodeView]]:
    """Return what matches images of the upper camera, and what gives an image's features by its
    row.

    read: an image (h, w, 3) RGB by its row, None where there is none. The features of the two asked
    last are kept.
    """
    feature_options = FeatureOptions(max_features=max_features)

    @lru_cache(maxsize=2)
    def view(row: int) -> NodeView:
        image = read(row)
        found = no_features() if image is None else extract(image, feature_options)
        return view_of_node(rig, found, no_features(), no_matches(), None, options.sigma_px)

    return PairMatcher(rig, options), view


def image_motion(
    rig: Rig, read: Callable[[int], Pixels | None], max_features: int, min_inliers: int
) -> Callable[[int, int], tuple[Array, Array] | None]:
    """Return what gives, from two rows, second_from_first (4, 4) of the upper camera, its
    translation of any length, and sigmas (2,) rad of its turn and of its direction, about the axis
    that is known worst; None where fewer than min_inliers features agree on one.
    """
    options = MatchOptions(min_inliers=min_inliers)
    matcher, view = single_camera_views(rig, read, max_features, options)

    def between(first: int, second: int) -> tuple[Array, Array] | None:
        found = matcher.match(
            view(first), view(second), None, (options.seed, first, second), True
        ).motion
        if found is None:
            return None
        length = float(np.linalg.norm(found.second_from_first[:3, 3]))
        direction = found.second_from_first[:3, 3] / length
        across = np.eye(3) - np.outer(direction, direction)
        variance = [
            found.covariance[3:, 3:],
            across @ found.covariance[:3, :3] @ across / length**2,
        ]
        return found.second_from_first, np.sqrt([np.linalg.eigvalsh(one)[-1] for one in variance])

    return between
