# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What one node sees: features of its leading camera with depths, ready for the search in another
node.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.rig import Rig
from hullrecon.typing import Array, Floats32, Ints, Mask
from hullrecon.vision.features.descriptors import to_unit
from hullrecon.vision.features.extraction import Features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.stereo.leading import bottom_leads, is_fair_share
from hullrecon.vision.stereo.matching import (
    StereoLimits,
    StereoMatches,
    StereoSide,
    match_stereo,
    no_matches,
)
from hullrecon.vision.stereo.rectification import Rectification, rectify


@dataclass(frozen=True, kw_only=True)
class DepthPrior:
    """Depth of the scene along the camera's axis from the DVL: mean, sigma, nearest and farthest,
    metres. normal: unit normal of the surface in the camera's axes, pointing away from it; None
    where the returns lie on a line.
    """

    mean: float
    sigma: float
    nearest: float
    farthest: float
    normal: tuple[float, float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class NodeView:
    """A node for pair matching. camera: the leading one.

    xy (n, 2) ideal coordinates in the leading camera, descriptor (n, 128) unit, corner (n,): not of
    SIFT, place (n,): the row that stands for all at its pixel. other (n, 2): ideal coordinates in
    the bottom camera of the stereo match, NaN where none; point (n, 3) in the leading camera, NaN
    where none; both of the place, whichever of its rows was matched. depth, depth_sigma (n,):
    measured, carried over from stereo neighbours, from the prior, or NaN. normal: the prior's, in
    the leading camera's axes.
    """

    camera: Camera
    xy: Array
    descriptor: Floats32
    corner: Mask
    place: Ints
    other: Array
    point: Array
    depth: Array
    depth_sigma: Array
    normal: tuple[float, float, float] | None = None

    def __len__(self) -> int:
        return len(self.xy)

    @property
    def stereo(self) -> Mask:
        """Return which features (n,) have a stereo point."""
        return np.isfinite(self.point[:, 0])


def stereo_of_node(
    rig: Rig, top: Features, bottom: Features, prior: DepthPrior | None, options: MatchOptions
) -> StereoMatches:
    """Return the matches between a node's two cameras; none for a mono rig or a lost image, nor
    where there are no more than noise has with an image.
    """
    if rig.stereo_mount is None or not len(top) or not len(bottom):
        return no_matches()
    nearest, farthest = (
        (prior.nearest, prior.farthest) if prior else (options.nearest_m, options.farthest_m)
    )
    limits = StereoLimits(
        column=options.column_px / rig.focal_px(Camera.TOP),
        nearest_m=nearest,
        farthest_m=farthest,
        ratio=options.ratio,
        max_distance=options.max_distance,
        harris_share=options.harris_share,
    )
    sides = [
        StereoSide(
            xy=rig.model(k).undistort(f.keypoints[:, :2]),
            descriptor=to_unit(f.descriptors),
            corner=f.corner,
            place=f.place,
        )
        for k, f in zip(Camera, (top, bottom), strict=True)
    ]
    found = match_stereo(rectify(rig.stereo_mount), sides[0], sides[1], limits)
    found = drop_isolated_depths(found, sides[0].xy[found.top])
    return found if is_fair_share(len(found), top, bottom) else no_matches()


def drop_isolated_depths(
    matches: StereoMatches, xy: Array, neighbours: int = 8, factor: float = 6.0
) -> StereoMatches:
    """Return the matches whose inverse depth agrees with that of some neighbours in the image; a
    chance match has none like it.

    Kept when at least a quarter of the nearest neighbours lie within `factor` robust sigmas of
    local spread.
    """
    from scipy.spatial import cKDTree

    if len(matches) <= neighbours:
        return matches
    inverse = 1 / matches.point[:, 2]
    near = np.asarray(cKDTree(xy).query(xy, k=neighbours + 1)[1])[:, 1:]
    gap = np.abs(inverse[near] - inverse[:, None])
    typical = np.median(np.abs(inverse[near] - np.median(inverse[near], axis=1, keepdims=True)))
    close = (gap < factor * NORMAL_MAD * max(float(typical), 1e-4)).sum(axis=1) >= neighbours // 4
    return StereoMatches(
        top=matches.top[close], bottom=matches.bottom[close], point=matches.point[close]
    )


def view_of_node(
    rig: Rig,
    top: Features,
    bottom: Features,
    stereo: StereoMatches,
    prior: DepthPrior | None,
    sigma_px: float,
) -> NodeView:
    """Return the node as pair matching wants it."""
    camera = Camera.BOTTOM if bottom_leads(top, bottom, stereo) else Camera.TOP
    lead = top if camera is Camera.TOP else bottom
    xy = rig.model(camera).undistort(lead.keypoints[:, :2]) if len(lead) else np.zeros((0, 2))
    other, point = np.full((len(lead), 2), np.nan), np.full((len(lead), 3), np.nan)
    if len(stereo):
        other[stereo.top] = rig.model(Camera.BOTTOM).undistort(bottom.keypoints[stereo.bottom, :2])
        point[stereo.top] = stereo.point
    place = lead.place
    depth, sigma = _depths(rig, xy, point, prior, sigma_px)
    return NodeView(
        camera=camera,
        xy=xy,
        descriptor=to_unit(lead.descriptors),
        corner=lead.corner,
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
    """Return depth and sigma (n,), m, of every feature: its own, its four nearest stereo
    neighbours', or the prior's.
    """
    from scipy.spatial import cKDTree

    depth = np.full(len(xy), prior.mean if prior else np.nan)
    sigma = np.full(len(xy), prior.sigma if prior else np.nan)
    own = np.isfinite(point[:, 0])
    if rig.stereo_mount is None or own.sum() < 4:
        return depth, sigma
    rectification: Rectification = rectify(rig.stereo_mount)
    measured = point[own, 2]
    near = cKDTree(xy[own]).query(xy[~own], k=4)[1]
    depth[own], depth[~own] = measured, measured[near].mean(axis=1)
    sigma[own] = (
        measured**2 * np.sqrt(2) * sigma_px / rig.focal_px(Camera.TOP) / rectification.baseline_m
    )
    sigma[~own] = np.hypot(1.5 * measured[near].std(axis=1), 0.02 * depth[~own])
    return depth, sigma
