# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Matches between the two cameras of a node, and the points that they triangulate to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array, Floats32, Ints
from hullrecon.vision.features.descriptors import best_of_pairs, sparse_distance
from hullrecon.vision.pairs.gated_search import in_box
from hullrecon.vision.stereo.rectification import Rectification, triangulate


@dataclass(frozen=True, kw_only=True)
class StereoMatches:
    """Rows of the top and of the bottom camera's features that show one point; point (m, 3) in the top camera, metres."""

    top: Ints
    bottom: Ints
    point: Array

    def __len__(self) -> int:
        return len(self.top)


@dataclass(frozen=True, kw_only=True)
class StereoLimits:
    """column: half width of the band, ideal units (pixels over focal length); depths of the scene; ratio, max_distance: of unit
    descriptors."""

    column: float
    nearest_m: float
    farthest_m: float
    ratio: float
    max_distance: float


def no_matches() -> StereoMatches:
    """Return the matches of a node that has none."""
    return StereoMatches(top=np.zeros(0, np.int64), bottom=np.zeros(0, np.int64), point=np.zeros((0, 3)))


def match_stereo(
    rectification: Rectification, top: tuple[Array, Floats32], bottom: tuple[Array, Floats32], limits: StereoLimits
) -> StereoMatches:
    """Return mutual best matches within the band of [Ozog2016 D.2.1]; each side is (ideal coordinates (n, 2), unit
    descriptors (n, 128))."""
    xy_top, xy_bottom = rectification.rectify_top(top[0]), rectification.rectify_bottom(bottom[0])
    most, least = rectification.disparity(limits.nearest_m), rectification.disparity(limits.farthest_m)
    middle = np.array([0.0, 0.5 * float(most + least)])
    half = np.array([limits.column, max(0.5 * float(most - least), limits.column)])
    first, second = in_box(xy_top - middle, half, xy_bottom)
    found = best_of_pairs(first, second, sparse_distance(top[1], bottom[1], first, second), limits.ratio, limits.max_distance)
    points = triangulate(rectification, xy_top[found.first], xy_bottom[found.second])
    ahead = np.isfinite(points).all(axis=1)
    return StereoMatches(top=found.first[ahead], bottom=found.second[ahead], point=points[ahead])
