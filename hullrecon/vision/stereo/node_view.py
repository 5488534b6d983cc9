# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What one node sees: features of its leading camera with depths, ready for the search in another node."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.typing import Array, Floats32, Mask
from hullrecon.vision.features.descriptors import unit
from hullrecon.vision.features.extraction import Features
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.stereo.matching import StereoLimits, StereoMatches, match_stereo, no_matches
from hullrecon.vision.stereo.rectification import Rectification, Rig, rectify


@dataclass(frozen=True)
class DepthPrior:
    """Depth of the scene along the camera's axis from the DVL: mean, sigma, nearest and farthest, metres. normal: unit normal
    of the surface in the camera's axes, pointing away from it; None where the returns lie on a line."""

    mean: float
    sigma: float
    nearest: float
    farthest: float
    normal: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class View:
    """A node for pair matching. camera: the leading one, 0 top or 1 bottom (where the top has no image).

    xy (n, 2) ideal coordinates in the leading camera, descriptor (n, 128) unit. other (n, 2): ideal coordinates in the bottom
    camera of the stereo match, NaN where none; point (n, 3) in the leading camera, NaN where none. depth, depth_sigma (n,):
    measured, carried over from stereo neighbours, from the prior, or NaN. normal: the prior's, in the leading camera's axes.
    """

    camera: int
    xy: Array
    descriptor: Floats32
    other: Array
    point: Array
    depth: Array
    depth_sigma: Array
    normal: tuple[float, float, float] | None = None

    def __len__(self) -> int:
        return len(self.xy)

    @property
    def stereo(self) -> Mask:
        return np.isfinite(self.point[:, 0])


def stereo_of_node(rig: Rig, top: Features, bottom: Features, prior: DepthPrior | None, options: MatchOptions) -> StereoMatches:
    """Matches between a node's two cameras; none for a mono rig or a lost image."""
    if rig.bottom is None or rig.top_from_bottom is None or not len(top) or not len(bottom):
        return no_matches()
    nearest, farthest = (prior.nearest, prior.farthest) if prior else (options.nearest_m, options.farthest_m)
    limits = StereoLimits(options.column_px / rig.focal(0), nearest, farthest, options.ratio, options.max_distance)
    sides = [(rig.camera(k).undistort(f.keypoints[:, :2]), unit(f.descriptors)) for k, f in enumerate((top, bottom))]
    found = match_stereo(rectify(rig.top_from_bottom), sides[0], sides[1], limits)
    return drop_lonely_depths(found, sides[0][0][found.top])


def drop_lonely_depths(matches: StereoMatches, xy: Array, neighbours: int = 8, factor: float = 6.0) -> StereoMatches:
    """Matches whose inverse depth agrees with that of some neighbours in the image; a chance match has none like it.

    Kept when at least a quarter of the nearest neighbours lie within `factor` robust sigmas of local spread.
    """
    from scipy.spatial import cKDTree

    if len(matches) <= neighbours:
        return matches
    inverse = 1 / matches.point[:, 2]
    near = np.asarray(cKDTree(xy).query(xy, k=neighbours + 1)[1])[:, 1:]
    gap = np.abs(inverse[near] - inverse[:, None])
    typical = np.median(np.abs(inverse[near] - np.median(inverse[near], axis=1, keepdims=True)))
    close = (gap < factor * NORMAL_MAD * max(float(typical), 1e-4)).sum(axis=1) >= neighbours // 4
    return StereoMatches(matches.top[close], matches.bottom[close], matches.point[close])


def view_of_node(
    rig: Rig, top: Features, bottom: Features, stereo: StereoMatches, prior: DepthPrior | None, sigma_px: float
) -> View:
    """The node as pair matching wants it; the bottom camera leads where the top one has no features."""
    camera = 0 if len(top) or not len(bottom) else 1
    lead = (top, bottom)[camera]
    xy = rig.camera(camera).undistort(lead.keypoints[:, :2]) if len(lead) else np.zeros((0, 2))
    other, point = np.full((len(lead), 2), np.nan), np.full((len(lead), 3), np.nan)
    if len(stereo) and rig.bottom is not None:
        other[stereo.top] = rig.bottom.undistort(bottom.keypoints[stereo.bottom, :2])
        point[stereo.top] = stereo.point
    depth, sigma = _depths(rig, xy, point, prior, sigma_px)
    return View(camera, xy, unit(lead.descriptors), other, point, depth, sigma, prior.normal if prior else None)


def _depths(rig: Rig, xy: Array, point: Array, prior: DepthPrior | None, sigma_px: float) -> tuple[Array, Array]:
    """Depth and sigma of every feature: its own, its four nearest stereo neighbours', or the prior's."""
    from scipy.spatial import cKDTree

    depth = np.full(len(xy), prior.mean if prior else np.nan)
    sigma = np.full(len(xy), prior.sigma if prior else np.nan)
    own = np.isfinite(point[:, 0])
    if rig.top_from_bottom is None or own.sum() < 4:
        return depth, sigma
    rectification: Rectification = rectify(rig.top_from_bottom)
    measured = point[own, 2]
    near = cKDTree(xy[own]).query(xy[~own], k=4)[1]
    depth[own], depth[~own] = measured, measured[near].mean(axis=1)
    sigma[own] = measured**2 * np.sqrt(2) * sigma_px / rig.focal(0) / rectification.baseline_m
    sigma[~own] = np.hypot(1.5 * measured[near].std(axis=1), 0.02 * depth[~own])
    return depth, sigma
