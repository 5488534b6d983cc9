# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The features of a node's two cameras, and those of the leading camera with depths.

A camera whose light is out, or that is covered, still sends noise, in which SIFT finds 120 to 1600
features. Then the camera that sees more leads.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.rig import Rig
from hullrecon.typing import Array, Floats32, Ints, Mask
from hullrecon.vision.features.descriptors import MatchDescriptors, match_descriptors, to_unit
from hullrecon.vision.features.extraction import Features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.stereo.matching import (
    StereoMatches,
    StereoSide,
    match_stereo,
    no_matches,
    rectify,
)

# Depths at which stereo matches are searched where the depth of the scene was not measured: from
# the nearest that a camera is focused for to more than the visibility of harbour water.
DEPTH_RANGE_M = (0.3, 15.0)
# Least number of stereo matches over the geometric mean of the two cameras' features. An image of
# noise matched with one of a hull has at most 0.042. Two cameras that both see have at least 0.147,
# even where one of them looks past the hull (10,702 nodes of 53 runs; 0.163 on a real seabed).
FAIR_SHARE = 0.06
CLEARLY_MORE = 2.0  # ratio of features above which the bottom camera is the leading one
NEIGHBOURS = 8  # nearest matches in the image with whose depths that of a match is compared
SAME_DEPTH_SIGMAS = 6.0  # robust sigmas of local spread within which two inverse depths agree


@dataclass(frozen=True, kw_only=True)
class NodeFeatures:
    """Features of a node's two cameras, empty where one has no image, and their matches."""

    top: Features
    bottom: Features
    stereo: StereoMatches = field(default_factory=no_matches)

    @property
    def leading(self) -> Features:
        """Features of the leading camera, those that are matched with other nodes."""
        return self.bottom if self.bottom_leads else self.top

    @property
    def bottom_leads(self) -> bool:
        """Whether the leading camera is the bottom one.

        It is where the two cameras have nothing in common and the bottom one sees clearly more.
        Features are weighted by brightness: features found in the dark are noise.
        """
        if len(self.stereo) or not len(self.bottom):
            return False
        return _light(self.bottom) > CLEARLY_MORE * _light(self.top)


@dataclass(frozen=True, kw_only=True)
class DepthPrior:
    """Depth of the scene along a camera's axis by the DVL, m."""

    mean: float
    sigma: float
    nearest: float  # limits of the depth at which stereo matches are searched
    farthest: float
    # unit normal of the surface in the camera, pointing away from it; None for returns on a line
    normal: tuple[float, float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class NodeView:
    """The n features of a node's leading camera, prepared for pair matching.

    SIFT may give several features at one pixel, with different orientations. A stereo match of one
    of them counts for all at that pixel (`place`).
    """

    camera: Camera  # the leading one
    xy: Array  # (n, 2) ideal coordinates in the leading camera
    descriptor: Floats32  # (n, 128) unit vectors
    place: Ints  # (n,) the row that stands for all at its pixel
    other: Array  # (n, 2) stereo match in the bottom camera, ideal coordinates, NaN for none
    point: Array  # (n, 3) triangulated in the leading camera, m, NaN for none
    depth: Array  # (n,) m: measured, of stereo neighbours, of the prior, or NaN
    depth_sigma: Array  # (n,) m
    normal: tuple[float, float, float] | None = None  # of the surface, as in DepthPrior

    def __len__(self) -> int:
        return len(self.xy)

    @property
    def stereo(self) -> Mask:
        """Features (n,) with a stereo point."""
        return np.isfinite(self.point[:, 0])


def stereo_of_node(
    rig: Rig,
    top: Features,
    bottom: Features,
    prior: DepthPrior | None,
    options: MatchOptions,
    match: MatchDescriptors = match_descriptors,
) -> StereoMatches:
    """Match the two cameras of a node, and triangulate the matches.

    Matches at a depth that no neighbour has are dropped. Empty on a mono rig, with a lost image, or
    with no more matches than an image of noise has.

    Parameters
    ----------
    rig
        Gives the lens models and the stereo mount.
    top, bottom
        Features of either camera.
    prior
        Depth of the scene. None: DEPTH_RANGE_M is searched.
    options
        Gives the width of the search across the epipolar line (column_px).
    match
        Matches descriptors among the pairs that geometry allows.
    """
    if rig.stereo_mount is None or not len(top) or not len(bottom):
        return no_matches()
    sides = [
        StereoSide(
            xy=rig.model(camera).undistort(features.keypoints[:, :2]),
            descriptor=to_unit(features.descriptors),
            place=features.place,
        )
        for camera, features in zip(Camera, (top, bottom), strict=True)
    ]
    found = match_stereo(
        rectify(rig.stereo_mount),
        top=sides[0],
        bottom=sides[1],
        depth_m=(prior.nearest, prior.farthest) if prior else DEPTH_RANGE_M,
        column=options.column_px / rig.focal_px(Camera.TOP),
        match_descriptors=match,
    )
    found = drop_isolated_depths(found, sides[0].xy[found.top])
    return found if is_fair_share(len(found), top, bottom) else no_matches()


def is_fair_share(matches: int, top: Features, bottom: Features) -> bool:
    """Decide whether two images have more matches than an image of noise has with any image.

    Without it a dark camera's chance matches would count as depths. Features without a score do not
    count.
    """
    return matches >= FAIR_SHARE * math.sqrt(int(top.scored.sum()) * int(bottom.scored.sum()))


def drop_isolated_depths(matches: StereoMatches, xy: Array) -> StereoMatches:
    """Drop matches whose inverse depth agrees with too few of their neighbours in the image.

    A chance match has no neighbour of like depth. A match is kept if at least a quarter of its
    nearest neighbours have the same inverse depth, within the spread that is usual among neighbours
    of this image. xy: (m, 2) positions of the matches in the image.
    """
    from scipy.spatial import cKDTree

    if len(matches) <= NEIGHBOURS:
        return matches
    inverse = 1 / matches.point[:, 2]
    near = np.asarray(cKDTree(xy).query(xy, k=NEIGHBOURS + 1)[1])[:, 1:]
    gap = np.abs(inverse[near] - inverse[:, None])
    typical = np.median(np.abs(inverse[near] - np.median(inverse[near], axis=1, keepdims=True)))
    limit = SAME_DEPTH_SIGMAS * NORMAL_MAD * max(float(typical), 1e-4)
    return matches.take((gap < limit).sum(axis=1) >= NEIGHBOURS // 4)


def view_of_node(
    rig: Rig, features: NodeFeatures, prior: DepthPrior | None, sigma_px: float
) -> NodeView:
    """Prepare the features of a node's leading camera for pair matching.

    Each gets its ray, its stereo match and point where it has one, and a depth by which other
    nodes' cameras know where to search for it.

    Parameters
    ----------
    rig
        Gives the lens models and the stereo mount.
    features
        Features of both cameras, with their stereo matches.
    prior
        Depth of the scene by the DVL, None where not measured.
    sigma_px
        Sigma of a feature's position, from which the sigma of its depth follows.
    """
    camera = Camera.BOTTOM if features.bottom_leads else Camera.TOP
    lead, stereo = features.leading, features.stereo
    xy = rig.model(camera).undistort(lead.keypoints[:, :2]) if len(lead) else np.zeros((0, 2))
    other, point = np.full((len(lead), 2), np.nan), np.full((len(lead), 3), np.nan)
    if len(stereo):
        seen = features.bottom.keypoints[stereo.bottom, :2]
        other[stereo.top] = rig.model(Camera.BOTTOM).undistort(seen)
        point[stereo.top] = stereo.point
    # Features at one pixel are one measurement: each has the match and depth of the first of them.
    place = lead.place
    depth, sigma = _depths(rig, xy, point, prior, sigma_px)
    return NodeView(
        camera=camera,
        xy=xy,
        descriptor=to_unit(lead.descriptors),
        place=place,
        other=other[place],
        point=point[place],
        depth=depth[place],
        depth_sigma=sigma[place],
        normal=prior.normal if prior else None,
    )


def _depths(
    rig: Rig, xy: Array, point: Array, prior: DepthPrior | None, sigma_px: float
) -> tuple[Array, Array]:
    """Assign a depth and its sigma (n,), m, to each feature of the leading camera.

    It is the depth of its own stereo point, else the mean of the four nearest points in the image.
    With fewer than four stereo points all get the prior's, NaN without one. xy: (n, 2) ideal
    coordinates. point: (n, 3) stereo points, NaN for none. sigma_px: of a feature's position.
    """
    from scipy.spatial import cKDTree

    depth = np.full(len(xy), prior.mean if prior else np.nan)
    sigma = np.full(len(xy), prior.sigma if prior else np.nan)
    own = np.isfinite(point[:, 0])
    if rig.stereo_mount is None or own.sum() < 4:
        return depth, sigma
    measured = point[own, 2]
    near = cKDTree(xy[own]).query(xy[~own], k=4)[1]
    depth[own], depth[~own] = measured, measured[near].mean(axis=1)
    baseline_m = rectify(rig.stereo_mount).baseline_m
    # z = b / disparity, and the disparity has the sigma of two positions.
    sigma[own] = measured**2 * np.sqrt(2) * sigma_px / rig.focal_px(Camera.TOP) / baseline_m
    # Generous, as it only widens the search: the relief between the neighbours, and 2 % of the
    # depth.
    sigma[~own] = np.hypot(1.5 * measured[near].std(axis=1), 0.02 * depth[~own])
    return depth, sigma


def _light(features: Features) -> float:
    """Sum 1 + brightness (mean of R, G, B, 0 to 255) over the features of an image.

    It says how much a camera sees: features of a dark image are noise and count little.
    """
    return len(features) + float(features.color.sum(dtype=float)) / 3
