# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from vision.scene import camera_rig

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import exp, from_rpy
from hullrecon.records.trajectory import Exposures
from hullrecon.vision.features.extraction import Features
from hullrecon.vision.stereo.exposure import move_features, settle_depths
from hullrecon.vision.stereo.matching import StereoMatches
from hullrecon.vision.stereo.node_view import NodeFeatures

MODEL = CameraModel(400, 320, 350.0, 350.0, 199.0, 160.0, k1=-0.05)
RIG = camera_rig(
    MODEL,
    MODEL,
    exp([0.002, 0.1, 0.001, 0.01, -0.02, 0.01]),
    tray_origin=(0.4, 0.0, 0.1),
    tray_from_top=from_rpy([0.0, 0.05, -0.05], np.radians([90.0, 0.0, 90.0])),
)
TWIST = np.array([0.02, 0.28, 0.05, 0.02, -0.03, 0.04])


def exposure(late_s, readout_s=(0.0, 0.0)):
    return Exposures(
        late_s=np.array([[0.0, late_s]]),
        twist=TWIST[None],
        depth_m=np.array([1.2]),
        readout_s=np.array(readout_s),
    )


def in_node(camera, points):
    return points if camera is Camera.TOP else RIG.top_from_bottom.inverse().apply(points)


def photographed(camera, points, at):
    """Pixels of points, given in the top camera at the node's time, as a camera that reads its
    rows in turn sees them while the tray moves.
    """
    points, mount, row = in_node(camera, points), RIG.tray_from(camera), np.zeros(len(points))
    for _ in range(10):
        share = row / (MODEL.height - 1)
        moved = mount.inverse() @ at.motion(camera, share).inverse() @ mount
        pixel = MODEL.project(moved.apply(points))
        row = pixel[:, 1]
    return pixel


def features(pixel):
    n = len(pixel)
    keypoints = np.hstack([pixel, np.ones((n, 2))]).astype(np.float32)
    return Features(keypoints, np.zeros((n, 128), np.uint8), np.zeros((n, 3), np.uint8))


@pytest.mark.parametrize("late_s", [-0.06, -0.02, 0.02, 0.06])
@pytest.mark.parametrize("readout_s", [0.0, 0.03])
def test_late_features_move_to_node_time(late_s, readout_s):
    random = np.random.default_rng(1)
    points = random.uniform([-0.4, -0.2, 1.0], [0.4, 0.3, 1.5], (200, 3))
    at = exposure(late_s, (readout_s, readout_s))
    seen = [photographed(camera, points, at) for camera in Camera]
    rows = np.arange(len(points))
    rough = points * random.uniform(0.9, 1.1, (len(points), 1))
    stereo = StereoMatches(top=rows, bottom=rows, point=rough)
    nodes = NodeFeatures(top=features(seen[0]), bottom=features(seen[1]), stereo=stereo)
    settled = settle_depths(RIG, nodes, 1.2, at)
    moved = move_features(
        RIG, NodeFeatures(top=nodes.top, bottom=nodes.bottom, stereo=settled), 1.2, at
    )
    np.testing.assert_allclose(settled.point, points, atol=0.004)
    for camera, found in zip(Camera, (moved.top, moved.bottom), strict=True):
        true = MODEL.project(in_node(camera, points))
        np.testing.assert_allclose(found.keypoints[:, :2], true, atol=0.03)
    assert np.abs(seen[1] - true).max() > 1.0


def test_features_without_match_move_by_depth_of_scene():
    at, points = exposure(0.02), np.array([[0.1, 0.1, 1.2], [-0.2, 0.0, 1.2]])
    points = RIG.top_from_bottom.apply(points)
    bottom = features(photographed(Camera.BOTTOM, points, at))
    seen = NodeFeatures(top=features(np.zeros((0, 2))), bottom=bottom)
    moved = move_features(RIG, seen, 1.2, at).bottom.keypoints[:, :2]
    np.testing.assert_allclose(moved, MODEL.project(in_node(Camera.BOTTOM, points)), atol=0.02)


def test_feature_of_unknown_depth_stays():
    bottom = features(np.array([[100.0, 50.0]]))
    seen = NodeFeatures(top=features(np.zeros((0, 2))), bottom=bottom)
    moved = move_features(RIG, seen, np.nan, exposure(0.02))
    np.testing.assert_array_equal(moved.bottom.keypoints, bottom.keypoints)
