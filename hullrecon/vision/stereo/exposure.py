# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of images that were not exposed at their node's time, moved to where they were then.

A camera that fires after its partner, or reads its rows one after another, has moved on meanwhile:
at 0.3 m/s by 6 mm in 20 ms, some pixels. How it moved is known from navigation, and how that moves
a feature follows from the feature's depth. Every user of a feature then has one pose for a node
(docs/methods.md 4).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.records.trajectory import Exposures
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints
from hullrecon.vision.features.extraction import Features
from hullrecon.vision.stereo.matching import StereoMatches, rectify, triangulate
from hullrecon.vision.stereo.node_view import NodeFeatures

NEIGHBOURS = 4  # nearest stereo matches, of which a feature without a match gets the mean depth
# Depths for which stereo matches are searched where the depth of the scene was not measured, m
DEPTHS_M = (0.5, 1.0, 2.0, 4.0, 8.0)
# Alternations between the depths of matches and the positions of features. Each multiplies the
# error by the distance moved between the exposures over the baseline, some hundredths.
ROUNDS = 4


def move_features(
    rig: Rig, seen: NodeFeatures, depth_m: float, exposure: Exposures
) -> NodeFeatures:
    """Move the features of a node's images to where they were at the node's time.

    Features that would leave the camera's view stay where they are.

    Parameters
    ----------
    rig
        Gives the lens models and where the cameras sit on the tray.
    seen
        Features as found in the images, and stereo matches. How far a feature moves depends on its
        depth, which is that of its match or of the nearest ones.
    depth_m
        Depth of the scene, used where there are fewer than NEIGHBOURS matches. NaN: features are
        left unchanged.
    exposure
        Exposure times and motion of this node, one row.
    """
    bottom_point = seen.stereo.point
    if rig.stereo_mount is not None:
        bottom_point = rig.stereo_mount.inverse().apply(seen.stereo.point)
    top_depth = _depths(seen.top, seen.stereo.top, seen.stereo.point[:, 2], depth_m)
    bottom_depth = _depths(seen.bottom, seen.stereo.bottom, bottom_point[:, 2], depth_m)
    return replace(
        seen,
        top=_move(rig, Camera.TOP, seen.top, top_depth, exposure),
        bottom=_move(rig, Camera.BOTTOM, seen.bottom, bottom_depth, exposure),
    )


def settle_depths(
    rig: Rig, seen: NodeFeatures, depth_m: float, exposure: Exposures
) -> StereoMatches:
    """Triangulate stereo matches whose two images were exposed at different times.

    Returns the matches with their points relative to the top camera at the node's time. How far a
    feature has to be moved depends on its depth, and the depth on the moved features: both are
    computed in turn, ROUNDS times. Matches without a valid point are left out. Parameters are those
    of `move_features`.
    """
    turned = rectify(rig.tray_from(Camera.TOP).inverse() @ rig.tray_from(Camera.BOTTOM))
    for _ in range(ROUNDS if len(seen.stereo) else 0):
        moved = move_features(rig, seen, depth_m, exposure)
        ideal = [
            rig.model(camera).undistort(features.keypoints[rows, :2])
            for camera, features, rows in (
                (Camera.TOP, moved.top, seen.stereo.top),
                (Camera.BOTTOM, moved.bottom, seen.stereo.bottom),
            )
        ]
        point = triangulate(turned, turned.rectify_top(ideal[0]), turned.rectify_bottom(ideal[1]))
        known = np.asarray(np.isfinite(point).all(axis=1))
        seen = replace(seen, stereo=replace(seen.stereo, point=point).take(known))
    return seen.stereo


def _depths(features: Features, rows: Ints, depth_m: Array, otherwise_m: float) -> Array:
    """Assign a depth (n,), m, to each feature of one camera, by which it can be moved.

    It is the depth of its own stereo match, else the mean of the nearest matches in the image. With
    fewer than NEIGHBOURS matches all get the depth of the scene.

    Parameters
    ----------
    features
        The camera's features, n.
    rows
        Features (k,) with a stereo match.
    depth_m
        Depths (k,) of these matches in this camera.
    otherwise_m
        Depth of the scene.
    """
    from scipy.spatial import cKDTree

    place = features.place
    depth = np.full(len(features), otherwise_m)
    if len(rows) < NEIGHBOURS:
        return depth
    at = features.keypoints[:, :2]
    depth = depth_m[cKDTree(at[rows]).query(at, k=NEIGHBOURS)[1]].mean(axis=1)
    depth[rows] = depth_m
    # Features at one pixel have one depth, that of the first.
    return np.asarray(depth[place])


def _move(
    rig: Rig, camera: Camera, features: Features, depth_m: Array, exposure: Exposures
) -> Features:
    """Move a camera's features by the tray's motion between their row's exposure and the node.

    A feature without a depth, or that would leave the camera's view, is left unchanged. depth_m:
    (n,) of each feature in that camera, NaN where unknown.
    """
    if not len(features):
        return features
    model, mount = rig.model(camera), rig.tray_from(camera)
    pixel = features.keypoints[:, :2]
    tray = exposure.motion(camera, pixel[:, 1].astype(float) / (model.height - 1))
    ray = np.hstack([model.undistort(pixel), np.ones((len(pixel), 1))])
    at_node = model.project((mount.inverse() @ tray @ mount).apply(depth_m[:, None] * ray))
    keypoints, known = features.keypoints.copy(), np.isfinite(at_node).all(axis=1)
    keypoints[known, :2] = at_node[known]
    return replace(features, keypoints=keypoints)
