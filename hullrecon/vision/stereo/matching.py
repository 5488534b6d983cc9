# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Matches between the two cameras of a node, and the points that they triangulate to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array, Floats32, Ints, Mask
from hullrecon.vision.features.descriptors import best_of_pairs, sparse_distance
from hullrecon.vision.features.kinds import like_pairs, limit_corners
from hullrecon.vision.features.places import match_places
from hullrecon.vision.pairs.gated_search import in_box
from hullrecon.vision.stereo.rectification import Rectification, triangulate


@dataclass(frozen=True, kw_only=True)
class StereoMatches:
    """Rows of the top and of the bottom camera's features that show one point, each standing for
    all at its pixel; point (m, 3) in the top camera, metres.
    """

    top: Ints
    bottom: Ints
    point: Array

    def __len__(self) -> int:
        return len(self.top)


@dataclass(frozen=True, kw_only=True)
class StereoLimits:
    """column: half width of the band, ideal units (pixels over focal length); depths of the scene;
    ratio, max_distance: of unit descriptors; harris_share: of the matches that may be corners.
    """

    column: float
    nearest_m: float
    farthest_m: float
    ratio: float
    max_distance: float
    harris_share: float = 0.0


@dataclass(frozen=True, kw_only=True)
class StereoSide:
    """One camera's features: xy (n, 2) ideal coordinates, descriptor (n, 128) unit, corner (n,):
    which are corners, place (n,): the row that stands for all at its pixel.
    """

    xy: Array
    descriptor: Floats32
    corner: Mask
    place: Ints


def no_matches() -> StereoMatches:
    """Return the matches of a node that has none."""
    return StereoMatches(
        top=np.zeros(0, np.int64), bottom=np.zeros(0, np.int64), point=np.zeros((0, 3))
    )


def match_stereo(
    rectification: Rectification, top: StereoSide, bottom: StereoSide, limits: StereoLimits
) -> StereoMatches:
    """Return mutual best matches within the band of [Ozog2016 D.2.1]."""
    xy_top, xy_bottom = rectification.rectify_top(top.xy), rectification.rectify_bottom(bottom.xy)
    most, least = (
        rectification.disparity(limits.nearest_m),
        rectification.disparity(limits.farthest_m),
    )
    middle = np.array([0.0, 0.5 * float(most + least)])
    half = np.array([limits.column, max(0.5 * float(most - least), limits.column)])
    near = like_pairs(*in_box(xy_top - middle, half, xy_bottom), top.corner, bottom.corner)
    distance = sparse_distance(top.descriptor, bottom.descriptor, *near)
    found = best_of_pairs(*near, distance, limits.ratio, limits.max_distance)
    found = match_places(found, top.place, bottom.place)
    found = limit_corners(found, top.corner[found.first], limits.harris_share)
    points = triangulate(rectification, xy_top[found.first], xy_bottom[found.second])
    ahead = np.isfinite(points).all(axis=1)
    return StereoMatches(top=found.first[ahead], bottom=found.second[ahead], point=points[ahead])
