# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A small stereo rig over a flat patch, with truth."""

from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon.adjustment.results.colmap_export import SparseModel
from hullrecon.geometry import poses
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.records.tracks import Tracks
from hullrecon.rig import Rig, RigPriors

CAMERA = CameraModel(640, 512, 650.0, 651.0, 320.0, 250.0, -0.06, 0.03, 0.001, -0.0005)


def observe(camera, hull_from_camera, points, nodes, landmarks):
    """Pixels (m, 2) of landmarks from nodes, NaN outside the image."""
    pixel = camera.project(hull_from_camera.inverse()[nodes].apply(points[landmarks]))
    inside = (pixel >= 0).all(1) & (pixel <= [camera.width - 1, camera.height - 1]).all(1)
    pixel[~inside] = np.nan
    return pixel


@pytest.fixture
def scene():
    """20 nodes a decimetre apart looking down on 400 landmarks a metre below, a vertical stereo
    rig, no noise.
    """
    rng = np.random.default_rng(3)
    n, count = 20, 400
    nodes = poses.from_rpy(
        np.c_[0.1 * np.arange(n), np.zeros(n), np.zeros(n)], 0.02 * rng.standard_normal((n, 3))
    )
    points = np.c_[
        rng.uniform(-0.3, 2.2, count), rng.uniform(-0.3, 0.3, count), rng.uniform(0.95, 1.1, count)
    ]
    tray_from_top, top_from_bottom = (
        poses.from_mount([0.01, 0, 0, 0, 0, 0]),
        poses.from_mount([0.001, 0.1, 0, 0.1, -0.2, 0.1]),
    )
    rig = Rig(
        tray_origin=np.array([0.4, 0.0, 0.1]),
        pressure_origin=np.zeros(3),
        tray_from_dvl=poses.identity(),
        tray_from_top=tray_from_top,
        top_from_bottom=top_from_bottom,
        camera_models={Camera.TOP: CAMERA, Camera.BOTTOM: CAMERA},
        priors=RigPriors(
            tray_from_dvl=np.eye(6),
            tray_from_top=np.eye(6),
            dvl_position_sigma_m=np.zeros(3),
            tray_sigma_rad=0.01,
            navigation_sigma=np.ones(6),
            density_sigma=0.002,
            pixel_sigma_px=1.0,
            range_sigma_m=0.01,
        ),
    )
    tray = np.full(n, 0.05)
    top = nodes @ poses.tray_poses(rig.tray_origin, tray) @ tray_from_top
    bottom = top @ top_from_bottom
    landmark, node = np.repeat(np.arange(count), n), np.tile(np.arange(n), count)
    pixels = [observe(CAMERA, pose, points, node, landmark) for pose in (top, bottom)]
    seen = np.isfinite(pixels[0][:, 0]) | np.isfinite(pixels[1][:, 0])
    color = np.full((count, 3), 90, np.uint8)
    tracks = Tracks(
        landmark=landmark[seen],
        node=node[seen],
        top=pixels[0][seen],
        bottom=pixels[1][seen],
        response=np.full(seen.sum(), 0.02),
        color=color,
    )
    return SimpleNamespace(
        nodes=nodes, tray=tray, points=points, rig=rig, top=top, bottom=bottom, tracks=tracks
    )


@pytest.fixture
def sparse_model(scene):
    """The scene as a model to export, with a stamp for each image."""
    n = len(scene.nodes)
    top, bottom = (np.isfinite(pixel[:, 0]) for pixel in (scene.tracks.top, scene.tracks.bottom))
    assert len(scene.tracks.node) > 1000
    return SparseModel(
        tracks=scene.tracks,
        top=top,
        bottom=bottom,
        hull_from_top=scene.top,
        top_from_bottom=scene.rig.top_from_bottom,
        cameras=(scene.rig.top, scene.rig.bottom),
        stamps=np.stack([np.arange(n) * 10**9, np.arange(n) * 10**9 + 5], axis=1),
        position=scene.points,
    )
